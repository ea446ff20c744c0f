# SPDX-License-Identifier: GPL-3.0-or-later
"""numpy, imported when it is first used.

Importing it takes most of what the add-on may cost of Blender's start, in sessions too in which nobody opens
its tab, and Blender does not import it by itself. Modules of the add-on take `np` from here, and read
``numpy`` only for the type checker.
"""

from __future__ import annotations

import importlib
from typing import Any

__all__ = ["np"]


class _LazyModule:
    """Stands for a module; each of its names is looked up once."""

    def __init__(self, name: str) -> None:
        self._name = name

    def __getattr__(self, attribute: str) -> Any:
        # Only called for what the instance has not.
        value = getattr(importlib.import_module(self._name), attribute)
        setattr(self, attribute, value)
        return value


np: Any = _LazyModule("numpy")
