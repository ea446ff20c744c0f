# SPDX-License-Identifier: MIT
"""Packages whose public names are imported when they are first used (PEP 562).

So help texts, error messages and the start of Blender need not wait for numpy, scipy and all that the modules
import. A package states its names once, in the stub `__init__.pyi` beside it, where type checkers and editors
find them too.
"""

from __future__ import annotations

import ast
import importlib
import sys
from collections.abc import Callable
from pathlib import Path

__all__ = ["lazy_names"]


def lazy_names(package: str) -> tuple[list[str], Callable[[str], object], Callable[[], list[str]]]:
    """Read the public names of a package from its stub.

    Parameters
    ----------
    package : str
        Its `__name__`.

    Returns
    -------
    names, getter, lister : list of str, callable, callable
        The package's `__all__`, `__getattr__` and `__dir__`.
    """
    module = sys.modules[package]
    stub = Path(str(module.__file__)).with_name("__init__.pyi").read_text(encoding="utf-8")
    imports = [node for node in ast.parse(stub).body if isinstance(node, ast.ImportFrom)]
    origin = {alias.name: str(node.module) for node in imports for alias in node.names}

    def getter(name: str) -> object:
        if name not in origin:
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        value: object = getattr(importlib.import_module(origin[name]), name)
        setattr(module, name, value)
        return value

    def lister() -> list[str]:
        return sorted({*vars(module), *origin})

    return sorted(origin), getter, lister
