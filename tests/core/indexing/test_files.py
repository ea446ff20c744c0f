# SPDX-License-Identifier: MIT
"""Which files a folder stands for."""

from __future__ import annotations

from pathlib import Path

import pytest

from shapegoogle_core.errors import MeshError
from shapegoogle_core.indexing import find_meshes
from shapegoogle_core.mesh.io.other_formats import skipped_formats


def touch(path: Path) -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.touch()
    return path


def link(place: Path, target: Path) -> None:
    try:
        place.symlink_to(target)
    except OSError as error:
        pytest.skip(f"links cannot be made here: {error}")


def test_all_formats_in_all_folders_below(tmp_path: Path) -> None:
    names = ["a.obj", "b/c.PLY", "b/d.Stl", "b/e/f.off", "g.glb", "h.gltf"]
    expected = [touch(tmp_path / name) for name in names]
    for other in ("notes.txt", "b/texture.png", "no_suffix", "animals.blend"):
        touch(tmp_path / other)
    assert find_meshes([tmp_path]) == sorted(expected)


def test_files_of_other_formats_are_told_apart(tmp_path: Path) -> None:
    """Those that hold shapes, and are not read, are not passed over silently."""
    mesh = touch(tmp_path / "a.obj")
    other = [touch(tmp_path / name) for name in ("b.step", "c/d.STP", "c/e.Fbx")]
    for name in ("notes.txt", ".hidden.step", "picture.png"):
        touch(tmp_path / name)
    skipped: list[Path] = []
    assert find_meshes([tmp_path, tmp_path / "c"], lambda *_: None, on_skipped=skipped.append) == [mesh]
    assert sorted(skipped) == sorted(other)
    assert [each.sentence() for each in skipped_formats(skipped)] == [
        "1 FBX file skipped: index with Blender and scripts/index_library.py, or export as glTF",
        "2 STEP files skipped: export from the CAD program as STL or 3MF, with a fine tolerance",
    ]
    skipped.clear()
    found = find_meshes([tmp_path], suffixes={".obj", ".fbx"}, exclude="b.*", on_skipped=skipped.append)
    assert found == [mesh, other[2]]
    assert skipped == [other[1]]


def test_hidden_files_and_folders_are_passed_over(tmp_path: Path) -> None:
    shown = touch(tmp_path / "horse.obj")
    for hidden in ("._horse.obj", ".hidden.obj", ".trash/old.obj"):
        touch(tmp_path / hidden)
    assert find_meshes([tmp_path]) == [shown]


def test_a_file_named_itself_is_taken_whatever_its_name(tmp_path: Path) -> None:
    odd = touch(tmp_path / ".horse.xyz")
    assert find_meshes([odd]) == [odd]


def test_each_file_once_and_sorted(tmp_path: Path) -> None:
    first, second = touch(tmp_path / "b" / "1.obj"), touch(tmp_path / "a" / "2.obj")
    inputs = [first, tmp_path / "b", tmp_path, tmp_path / "a" / ".." / "a"]
    assert find_meshes(inputs) == [second, first]


def test_paths_are_absolute(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    mesh = touch(tmp_path / "models" / "horse.obj")
    monkeypatch.chdir(tmp_path)
    assert find_meshes(["models"]) == [mesh]
    assert find_meshes(["models/horse.obj"]) == [mesh]


def test_one_input_is_not_taken_apart(tmp_path: Path) -> None:
    mesh = touch(tmp_path / "horse.obj")
    assert find_meshes(str(tmp_path)) == find_meshes(tmp_path) == [mesh]
    with pytest.raises(MeshError, match=r"'.*missing' does not exist"):
        find_meshes("missing")
    with pytest.raises(ValueError, match="a path must be a str"):
        find_meshes(5)  # type: ignore[arg-type]


def test_a_circle_of_links_ends(tmp_path: Path) -> None:
    mesh = touch(tmp_path / "models" / "deep" / "horse.obj")
    link(tmp_path / "models" / "deep" / "up", tmp_path / "models")
    assert find_meshes([tmp_path / "models"]) == [mesh]


def test_linked_folders_are_followed(tmp_path: Path) -> None:
    touch(tmp_path / "store" / "horse.obj")
    (tmp_path / "models").mkdir()
    link(tmp_path / "models" / "linked", tmp_path / "store")
    assert find_meshes([tmp_path / "models"]) == [tmp_path / "models" / "linked" / "horse.obj"]


def test_missing_folder(tmp_path: Path) -> None:
    with pytest.raises(MeshError, match="nowhere' does not exist"):
        find_meshes([tmp_path / "nowhere"])


def test_folder_without_meshes(tmp_path: Path) -> None:
    touch(tmp_path / "notes.txt")
    with pytest.raises(MeshError, match=r"has no mesh files \(.*\.obj.*\)"):
        find_meshes([tmp_path])


def test_with_a_callback_the_others_go_on(tmp_path: Path) -> None:
    mesh = touch(tmp_path / "models" / "horse.obj")
    (tmp_path / "empty").mkdir()
    problems: dict[Path, str] = {}
    found = find_meshes([tmp_path / "nowhere", tmp_path / "empty", tmp_path / "models"], problems.__setitem__)
    assert found == [mesh]
    assert list(problems) == [tmp_path / "nowhere", tmp_path / "empty"]
    assert "does not exist" in problems[tmp_path / "nowhere"]
    assert "has no mesh files" in problems[tmp_path / "empty"]


def test_one_path_needs_no_list(tmp_path: Path) -> None:
    path = touch(tmp_path / "horse.ply")
    assert find_meshes(str(tmp_path)) == find_meshes(tmp_path) == [path]
    with pytest.raises(MeshError, match="missing' does not exist"):
        find_meshes("missing")
    with pytest.raises(ValueError, match="a path must be a str"):
        find_meshes([3])  # type: ignore[list-item]
