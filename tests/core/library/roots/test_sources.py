# SPDX-License-Identifier: MIT
"""Sources of a library: one for each file, however its path is spelt."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from shapegoogle_core.errors import LibraryError
from shapegoogle_core.indexing import find_meshes, index_files
from shapegoogle_core.indexing.settings import IndexSettings
from shapegoogle_core.library.filter import Filter
from shapegoogle_core.library.library import Library
from shapegoogle_core.library.placement import Placement
from shapegoogle_core.library.storage.records import NewShape, Root


@pytest.fixture
def rooted(indexed: Library, folder: Path) -> Library:
    """A library that knows `folder` as a root."""
    indexed.add_root(folder)
    index_files(indexed, find_meshes([folder]), IndexSettings(jobs=1))
    return indexed


def found(library: Library, where: Filter) -> list[str]:
    return sorted(library.shape(int(i)).name for i in library._store.filtered_ids(where))


def test_labels_become_files_below_a_root(rooted: Library, folder: Path) -> None:
    """The fixture stores them before their folder is a root."""
    assert rooted.roots() == [Root("meshes", str(folder), 3)]
    sources = rooted.sources()
    assert list(sources) == [str(path) for path in find_meshes([folder])]
    assert {source.relative for source in sources.values()} == {"apple.off", "more/plum.stl", "pear.obj"}
    assert len(rooted) == 3


@pytest.mark.parametrize("spelling", ["relative", "dots", "link", "link to a file", "trailing"])
def test_one_source_however_it_is_spelt(
    rooted: Library, folder: Path, spelling: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(folder)
    link = folder.parent / "link"
    link.symlink_to(folder)
    (folder / "fruit.obj").symlink_to(folder / "pear.obj")
    path = {
        "relative": "pear.obj",
        "dots": f"{folder}/more/../pear.obj",
        "link": str(link / "pear.obj"),
        "link to a file": str(folder / "fruit.obj"),
        "trailing": f"{folder}//pear.obj",
    }[spelling]
    report = index_files(rooted, path, IndexSettings(jobs=1))
    assert (report.added, report.unchanged, len(rooted), len(rooted.sources())) == (0, 1, 3, 3)
    assert rooted.source_path(path) == str(folder / "pear.obj")
    status = Path(path).stat()
    assert rooted.update_source(path, size=status.st_size, mtime_ns=5)
    assert rooted.sources()[str(folder / "pear.obj")].mtime_ns == 5
    assert found(rooted, Filter(sources=(path,))) == ["pear.obj"]
    assert found(rooted, Filter(not_sources=(path,))) == ["apple.off", "plum.stl"]
    # In the path or in the name.
    assert found(rooted, Filter(text="MESHES/more")) == ["plum.stl"]
    assert found(rooted, Filter(text="P*.???")) == ["pear.obj", "plum.stl"]
    assert rooted.remove(path)
    assert not rooted.remove(path)
    assert len(rooted) == 2


def test_folders_of_a_filter(rooted: Library, folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(folder)
    link = folder.parent / "link"
    link.symlink_to(folder)
    everything = ["apple.off", "pear.obj", "plum.stl"]
    for whole in (folder, folder.parent, ".", link, f"{folder}/"):
        assert found(rooted, Filter(folder=whole)) == everything
    for part in (folder / "more", "more", link / "more", "../link/more/"):
        assert found(rooted, Filter(folder=part)) == ["plum.stl"]
    assert found(rooted, Filter(folder=folder / "mor")) == []


def test_nested_roots(rooted: Library, folder: Path, tmp_path: Path) -> None:
    before = {shape.shape_id: shape.source for shape in rooted.shapes()}
    assert rooted.add_root(folder / "more").name == "meshes"
    assert rooted.add_root(tmp_path, "all") == Root("all", str(tmp_path), 0)
    assert rooted.add_root(folder / "more", "fruit") == Root("fruit", str(folder / "more"), 1)
    assert [(root.name, root.source_count) for root in rooted.roots()] == [
        ("all", 0),
        ("fruit", 1),
        ("meshes", 2),
    ]
    assert {shape.shape_id: shape.source for shape in rooted.shapes()} == before
    report = index_files(rooted, find_meshes([tmp_path]), IndexSettings(jobs=1))
    assert (report.added, report.unchanged) == (0, 3)
    with pytest.raises(LibraryError, match="the root 'all' of the library is"):
        rooted.add_root(folder.parent.parent, "all")


def test_roots_of_single_files(library: Library, folder: Path) -> None:
    library.add_roots([folder / "more" / "plum.stl", folder / "pear.obj"])
    assert [(root.name, root.path) for root in library.roots()] == [("meshes", str(folder))]
    other = folder.parent / "other" / "meshes"
    other.mkdir(parents=True)
    library.add_roots([other / "nut.obj"])
    assert [root.name for root in library.roots()] == ["meshes", "meshes 2"]


def test_labels_are_kept_as_they_are(rooted: Library, folder: Path) -> None:
    signature = rooted.signature(1)
    rooted.add_signature(signature, "a", source="animals.blend")
    rooted.add_signature(signature, "b", source="../animals.blend (open scene)")
    assert {"animals.blend", "../animals.blend (open scene)"} < set(rooted.sources())
    assert found(rooted, Filter(sources=("animals.blend",))) == ["a"]
    # The path of a file that was indexed is that file.
    rooted.add_signature(signature, "pear.obj", source=folder / "more" / ".." / "pear.obj")
    assert len(rooted) == 5
    assert rooted.remove("animals.blend")


def test_a_renamed_label_keeps_its_shapes(rooted: Library) -> None:
    signature = rooted.signature(1)
    first = rooted.add_signature(signature, "a", source="unsaved 1")
    rooted.add_signature(signature, "b", source="scene.blend (open scene)")
    other = rooted.add_signature(signature, "c", source="unsaved 2")
    assert rooted.rename_source("unsaved 1", "scene.blend (open scene)")
    assert not rooted.rename_source("unsaved 1", "scene.blend (open scene)")
    assert rooted.rename_source("unsaved 2", "unsaved 2")
    assert {shape.shape_id: shape.source for shape in rooted.shapes() if shape.shape_id > 3} == {
        first: "scene.blend (open scene)",
        other: "unsaved 2",
    }


def test_a_label_that_is_saved_below_a_root_becomes_that_file(rooted: Library, folder: Path) -> None:
    signature = rooted.signature(1)
    (root,) = rooted.roots()
    path = str(Path(root.path) / "new.blend")
    rooted.replace_source(path, size=1, mtime_ns=1, sha256="old", shapes=[])
    shape = rooted.add_signature(signature, "a", source="unsaved")
    assert rooted.rename_source("unsaved", path)
    assert rooted.shape(shape).source == path
    source = rooted.sources()[path]
    assert (source.root, source.relative, source.size, source.shape_count) == (
        root.name,
        "new.blend",
        None,
        1,
    )


def test_placements(library: Library, folder: Path, indexed: Library) -> None:
    signature = indexed.signature(1)
    placements = (
        Placement("Wheel", np.eye(4)),
        Placement("Wheel.001", np.diag([-2.0, 2.0, 2.0, 1.0])),
        Placement("Big", np.diag([5.0, 5.0, 5.0, 1.0]), (1.0, 2.0, 3.0)),
    )
    shape = NewShape(signature, "Wheel", "Wheel", placements=placements)
    (shape_id,) = library.replace_source("car.blend", size=None, mtime_ns=None, sha256=None, shapes=[shape])
    stored = library.placements(shape_id)
    assert [placement.object_name for placement in stored] == ["Wheel", "Wheel.001", "Big"]
    np.testing.assert_array_equal(stored[1].matrix, placements[1].matrix)
    assert stored[0].extents == signature.extents
    assert stored[1].extents == pytest.approx([2 * side for side in signature.extents])
    assert stored[2] == placements[2]
    assert library.shape(shape_id).placement_count == 3
    assert library.placements(1) == ()
    largest = max(signature.extents)
    for size, names in (
        ((1.999 * largest, 2.001 * largest), ["Wheel"]),
        ((3.0, 3.0), ["Wheel"]),
        ((2.1 * largest, 2.2 * largest), []),
    ):
        assert [name for name in found(library, Filter(size=size)) if name == "Wheel"] == names
    assert found(library, Filter(name="wheel.001")) == ["Wheel"]
    library.remove_shape(shape_id)
    with pytest.raises(LibraryError, match="has no shape"):
        library.placements(shape_id)
