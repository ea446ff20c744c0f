# SPDX-License-Identifier: MIT
"""The files of tests/files: each gives the counts, area and extents of the table there, or the error."""

from __future__ import annotations

import re
import tomllib
import warnings
from pathlib import Path
from typing import Any

import pytest

from shapegoogle_core.errors import MeshError
from shapegoogle_core.mesh import read_mesh
from tests.core.mesh.io.mesh_files import volume

FOLDER = Path(__file__).resolve().parents[3] / "files"
TABLE: dict[str, Any] = tomllib.loads((FOLDER / "expected.toml").read_text("utf-8"))
PARTS: list[str] = TABLE.pop("parts")
KEYS = {"kind", "vertices", "triangles", "area", "extents", "volume", "warning", "error"}

# Names of exception classes, and the words in which Python and its libraries complain.
PYTHON = re.compile(
    r"\w+(Error|Exception|Warning)\b|Traceback|could not convert|invalid literal|NoneType|\bdtype\b"
)


@pytest.mark.parametrize("name", TABLE)
def test_file(name: str) -> None:
    expected = TABLE[name]
    assert expected["kind"]
    assert set(expected) <= KEYS
    if "error" in expected:
        with pytest.raises(MeshError) as caught:
            read_mesh(FOLDER / name)
        message = str(caught.value)
        parts = expected["error"] if isinstance(expected["error"], list) else [expected["error"]]
        assert [part for part in parts if part not in message] == [], message
        assert repr(Path(name).name) in message
        assert not PYTHON.search(message)
        return
    with warnings.catch_warnings(record=True) as caught_warnings:
        warnings.simplefilter("always")
        mesh = read_mesh(FOLDER / name)
    found = [str(warning.message) for warning in caught_warnings]
    assert len(found) == ("warning" in expected), found
    assert all(expected["warning"] in text and repr(mesh.name) in text for text in found), found
    assert (len(mesh.vertices), len(mesh.faces)) == (expected["vertices"], expected["triangles"])
    assert mesh.extents == pytest.approx(expected["extents"], rel=1e-6)
    if "volume" in expected:
        assert volume(mesh) == pytest.approx(expected["volume"], rel=1e-6)
    assert mesh.area == pytest.approx(expected.get("area", 0), rel=1e-6)


def test_table_and_folder_agree() -> None:
    files = {path.relative_to(FOLDER).as_posix() for path in FOLDER.glob("*/**/*") if path.is_file()}
    assert files == {*TABLE, *PARTS}
