# SPDX-License-Identifier: MIT
"""Imports go one way: down the pipeline, and never from the product into what uses it."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
CORE = ROOT / "shapegoogle_core"

# From the bottom up: a folder imports only folders that stand before it.
LAYERS = (
    "errors",
    "api",
    "processes",
    "mesh",
    "laplacian",
    "preprocessing",
    "spectral",
    "descriptors",
    "keypoints",
    "words",
    "registration",
    "correspondence",
    "views",
    "model",
    "library",
    "plugins",
    "rendering",
    "indexing",
    "client",
    "worker",
    "service",
    "cli",
)
USERS = ("benchmarks", "blender_addon", "scripts", "tests", "bpy")


@cache
def imported_modules(path: Path) -> frozenset[str]:
    """Modules that a file imports, at its top or inside functions, except those for the type checker only."""
    return frozenset(_imported(ast.parse(path.read_text(encoding="utf-8"))))


def _imported(tree: ast.Module) -> Iterator[str]:
    for_types = {
        id(inner)
        for node in ast.walk(tree)
        if isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING"
        for inner in ast.walk(node)
    }
    for node in ast.walk(tree):
        if id(node) in for_types:
            continue
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module is not None and node.level == 0:
            yield node.module
            yield from (f"{node.module}.{alias.name}" for alias in node.names)


def modules() -> dict[str, Path]:
    """All modules of the core, by dotted name."""
    found = {}
    for path in sorted(CORE.rglob("*.py")):
        parts = path.relative_to(ROOT).with_suffix("").parts
        found[".".join(parts).removesuffix(".__init__")] = path
    return found


def test_every_folder_has_a_layer() -> None:
    folders = {path.name for path in CORE.iterdir() if (path / "__init__.py").exists()}
    assert folders | {"errors"} == set(LAYERS)


@pytest.mark.parametrize("folder", LAYERS)
def test_a_folder_imports_only_those_below_it(folder: str) -> None:
    allowed = set(LAYERS[: LAYERS.index(folder) + 1])
    files = [CORE / f"{folder}.py"] if folder == "errors" else sorted((CORE / folder).rglob("*.py"))
    wrong = {
        f"{path.relative_to(CORE)} imports {module}"
        for path in files
        for module in imported_modules(path)
        if module.startswith("shapegoogle_core.") and module.split(".")[1] in set(LAYERS) - allowed
    }
    assert not wrong


def test_the_core_imports_nothing_that_uses_it() -> None:
    wrong = {
        f"{name} imports {module}"
        for name, path in modules().items()
        for module in imported_modules(path)
        if module.split(".")[0] in USERS
    }
    assert not wrong


def test_there_are_no_circles() -> None:
    known = modules()
    imports = {
        name: {module for module in imported_modules(path) if module in known and module != name}
        for name, path in known.items()
        if path.name != "__init__.py"  # packages hand on the names of their modules
    }
    while leaves := [name for name, needed in imports.items() if not needed & imports.keys()]:
        for name in leaves:
            del imports[name]
    assert not imports
