# SPDX-License-Identifier: MIT
"""Docstrings: their examples run, and those of public names describe parameters, results and exceptions."""

from __future__ import annotations

import ast
import doctest
import importlib
import inspect
import pkgutil
import re
import textwrap
from collections.abc import Callable, Iterator
from itertools import pairwise
from typing import Any

import pytest

import shapegoogle_core as sg

MODULES = sorted(
    module.name
    for module in pkgutil.walk_packages(sg.__path__, "shapegoogle_core.")
    if not module.name.endswith("__main__")
)

ENTRY = re.compile(r"(?P<names>\*{0,2}\w+(?:, \*{0,2}\w+)*)(?: : (?P<type>.+))?$")


@pytest.mark.parametrize("name", ["shapegoogle_core", *MODULES])
def test_examples_run(name: str) -> None:
    module = importlib.import_module(name)
    options = doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE
    assert doctest.testmod(module, optionflags=options).failed == 0


def members() -> Iterator[tuple[str, Any]]:
    """Public functions and classes, and the public methods and properties of these classes."""
    for name in sg.__all__:
        value = getattr(sg, name)
        yield name, value
        if inspect.isclass(value):
            own = [kind for kind in value.__mro__ if kind.__module__.startswith("shapegoogle_core")]
            methods = {method for kind in own for method, member in vars(kind).items() if is_method(member)}
            yield from (
                (f"{name}.{method}", inspect.getattr_static(value, method)) for method in sorted(methods)
            )


def is_method(member: object) -> bool:
    unwrapped = member.__func__ if isinstance(member, (classmethod, staticmethod)) else member
    if isinstance(unwrapped, property):
        unwrapped = unwrapped.fget
    return inspect.isfunction(unwrapped) and not unwrapped.__name__.startswith("_")


@pytest.mark.parametrize(("name", "member"), [pytest.param(*pair, id=pair[0]) for pair in members()])
def test_a_docstring_is_complete(name: str, member: object) -> None:
    assert not list(faults(name, member))


def faults(name: str, member: Any) -> Iterator[str]:
    """Say what a docstring lacks."""
    if isinstance(member, (classmethod, staticmethod)):
        member = member.__func__
    text = inspect.getdoc(member) or ""
    summary, *_ = text.split("\n", 1)
    if not summary.endswith("."):
        yield f"{name} has no summary line that ends with a full stop"
    sections = sections_of(text)
    if "." not in name and "Examples" not in sections:
        yield f"{name} has no section Examples"
    if "Examples" in sections and ">>>" not in sections["Examples"]:
        yield f"{name} has no example that runs"
    if isinstance(member, property) or (inspect.isclass(member) and issubclass(member, Exception)):
        return
    described = entries_of(sections.get("Parameters", ""))
    if inspect.isclass(member):
        described |= entries_of(sections.get("Attributes", ""))
    for parameter in parameters_of(member):
        if not described.get(parameter):
            yield f"{name} does not describe {parameter}"
    for parameter in set(entries_of(sections.get("Parameters", ""))) - set(parameters_of(member)):
        yield f"{name} describes {parameter}, which it does not take"
    if inspect.isclass(member):
        return
    returned = str(inspect.signature(member).return_annotation)
    if returned not in ("None", "Never", "NoReturn") and not {"Returns", "Yields"} & sections.keys():
        yield f"{name} does not say what it returns"
    mentioned = sections.get("Raises", "")
    for exception in sorted(raised_by(member)):
        if exception not in mentioned:
            yield f"{name} does not say when it raises {exception}"
    if not mentioned:
        for callee in called_by(member):
            if raised := raised_by(callee):
                yield f"{name} has no section Raises, but {callee.__name__} raises {sorted(raised)}"


def sections_of(text: str) -> dict[str, str]:
    """Sections of a numpydoc docstring by their titles."""
    lines = text.splitlines()
    titles = [
        index for index, (line, below) in enumerate(pairwise(lines)) if line and below == "-" * len(line)
    ]
    starts = [*titles, len(lines)]
    return {lines[start]: "\n".join(lines[start + 2 : end]) for start, end in pairwise(starts)}


def entries_of(section: str) -> dict[str, str]:
    """Descriptions of a section's entries by name; an empty string where there is none."""
    entries: dict[str, str] = {}
    names: list[str] = []
    for line in section.splitlines():
        if line and not line.startswith(" "):
            match = ENTRY.match(line)
            names = match["names"].split(", ") if match else []
            # "y : ignored" is scikit-learn's way to say that nothing is to be described.
            ignored = match is not None and match["type"] == "ignored"
            entries |= dict.fromkeys((entry.lstrip("*") for entry in names), "ignored" if ignored else "")
        else:
            entries |= {entry.lstrip("*"): entries[entry.lstrip("*")] + line.strip() for entry in names}
    return entries


def parameters_of(member: Callable[..., object]) -> list[str]:
    names = list(inspect.signature(member).parameters)
    return [name for name in names if name not in ("self", "cls") and not name.startswith("_")]


def raised_by(function: Callable[..., object]) -> set[str]:
    """Names of the exceptions that a function raises for its input, in its own body."""
    raised = set()
    for node in ast.walk(tree_of(function)):
        if (
            isinstance(node, ast.Raise)
            and isinstance(node.exc, ast.Call)
            and isinstance(node.exc.func, ast.Name)
        ):
            raised.add(node.exc.func.id)
    return raised - {"AssertionError", "NotImplementedError", "AttributeError"}


def called_by(function: Callable[..., object]) -> list[Callable[..., object]]:
    """Functions of the package that a function calls by name."""
    called = {
        node.func.id
        for node in ast.walk(tree_of(function))
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name)
    }
    known = getattr(inspect.unwrap(function), "__globals__", {})
    functions = [known[name] for name in sorted(called) if inspect.isfunction(known.get(name))]
    return [callee for callee in functions if callee.__module__.startswith("shapegoogle_core")]


def tree_of(function: Callable[..., object]) -> ast.Module:
    return ast.parse(textwrap.dedent(inspect.getsource(inspect.unwrap(function))))
