# SPDX-License-Identifier: MIT
"""No message shows the class or the text of an exception that is not one of our own sentences."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
FOLDERS = ("shapegoogle_core", "blender_addon", "benchmarks", "scripts")

# Errors whose texts are sentences for users: ours, and what Blender reports through its operators.
OURS = {
    "BenchmarkError", "BlenderMissingError", "CrashError", "DamagedError", "FormatError", "LibraryError",
    "MeshError", "ModelError", "NotMakeableError", "PlacingError", "PluginError", "ServiceError",
    "SetupError", "ShapeGoogleError", "StudioError",
}  # fmt: skip
BLENDERS = {"RuntimeError"}
# Checks of arguments raise ValueError with a sentence of ours; these places hand it on.
SENTENCES = {
    "benchmarks/training/blend_meshes.py",
    "benchmarks/variants/bag_tasks.py",
    "shapegoogle_core/cli/commands/index.py",
    "shapegoogle_core/model/settings.py",
    "shapegoogle_core/model/shape_bags.py",
    "shapegoogle_core/service/queries.py",
    "shapegoogle_core/service/records.py",
    "shapegoogle_core/service/routes/decisions.py",
}


def caught(handler: ast.ExceptHandler) -> set[str]:
    """Names of the classes that a handler catches."""
    kinds = handler.type.elts if isinstance(handler.type, ast.Tuple) else [handler.type]
    return {ast.unparse(kind).split(".")[-1] for kind in kinds if kind is not None}


def texts_of(name: str, nodes: list[ast.stmt]) -> Iterator[tuple[int, str]]:
    """Places where the exception of this name becomes text."""
    for node in (inner for outer in nodes for inner in ast.walk(outer)):
        if isinstance(node, ast.FormattedValue):
            shown = ast.unparse(node.value)
            if (
                shown == name
                or shown.endswith(f" or {name}")
                or shown in (f"str({name})", f"repr({name})")
                or f"type({name})" in shown
            ):
                yield node.lineno, "{" + shown + "}"
        elif isinstance(node, ast.Call | ast.Attribute):
            shown = ast.unparse(node)
            if shown in (f"str({name})", f"repr({name})", f"type({name}).__name__"):
                yield node.lineno, shown


def is_read(path: Path) -> bool:
    """Whether a file is examined; what other readers raise is a result of the comparison of readers."""
    return "experiments/files" not in path.as_posix()


def faults_of(path: Path) -> Iterator[str]:
    name = path.relative_to(ROOT).as_posix()
    allowed = OURS | (BLENDERS if "bpy" in path.read_text() else set())
    allowed |= {"ValueError"} if name in SENTENCES else set()
    for handler in ast.walk(ast.parse(path.read_text())):
        if not isinstance(handler, ast.ExceptHandler) or handler.name is None:
            continue
        foreign = caught(handler) - allowed
        for line, text in texts_of(handler.name, handler.body):
            if foreign or "type(" in text or "repr(" in text:
                yield f"{name}:{line}: {text} of {', '.join(sorted(foreign or caught(handler)))}"


@pytest.mark.parametrize("folder", FOLDERS)
def test_no_text_of_an_exception_is_shown(folder: str) -> None:
    paths = [path for path in sorted((ROOT / folder).rglob("*.py")) if is_read(path)]
    found = [fault for path in paths for fault in faults_of(path)]
    assert not found, "\n".join(found)


def test_what_the_test_finds(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(f"{__name__}.ROOT", tmp_path)
    path = tmp_path / "code.py"
    path.write_text(
        "try:\n    pass\n"
        "except KeyError as error:\n    raise Fault(f'no {error}')\n"
        "except MeshError as error:\n    print(f'{error}', type(error).__name__)\n"
        "except OSError as error:\n    print(error.strerror, str(error))\n"
    )
    assert [fault.split(": ", 1)[1] for fault in faults_of(path)] == [
        "{error} of KeyError",
        "type(error).__name__ of MeshError",
        "str(error) of OSError",
    ]
