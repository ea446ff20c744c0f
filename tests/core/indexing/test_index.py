# SPDX-License-Identifier: MIT
"""What is described, what is stored and what is left alone."""

from __future__ import annotations

import base64
import json
import os
import shutil
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import trimesh

from shapegoogle_core.indexing import FileOutcome, IndexReport, IndexSettings, find_meshes, index_files
from shapegoogle_core.indexing.reading.describing import ReadFunction
from shapegoogle_core.library.library import Library
from shapegoogle_core.mesh import read_mesh
from shapegoogle_core.model import ShapeModel
from tests.core.indexing import misbehaving
from tests.core.mesh.io.three_mf_files import item, mesh_object, moved, package
from tests.core.mesh.io.three_mf_files import model as plate

Log = Callable[[], list[str]]


@pytest.fixture
def log(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Log:
    """Names of the files that the workers described since the last call, sorted."""
    file = tmp_path / "described.log"
    monkeypatch.setenv("READ_LOG", str(file))

    def names() -> list[str]:
        lines = file.read_text().split("\n")[:-1] if file.exists() else []
        file.unlink(missing_ok=True)
        return sorted(lines)

    return names


def index(
    library: Library,
    folder: Path,
    read: ReadFunction = misbehaving.read_and_log,
    progress: Callable[[FileOutcome], None] | None = None,
) -> IndexReport:
    return index_files(library, find_meshes([folder]), IndexSettings(jobs=1), read=read, progress=progress)


def counts(report: IndexReport) -> tuple[int, int, int, int]:
    return report.added, report.updated, report.unchanged, len(report.failed)


def names(library: Library) -> list[str]:
    return sorted(shape.name for shape in library.shapes())


def test_a_folder_becomes_a_library(library: Library, folder: Path, model: ShapeModel, log: Log) -> None:
    outcomes: list[FileOutcome] = []
    report = index(library, folder, progress=outcomes.append)
    assert counts(report) == (3, 0, 0, 0)
    assert report.seconds > 0
    assert log() == ["apple.off", "pear.obj", "plum.stl"]
    assert sorted((outcome.path, outcome.status) for outcome in outcomes) == [
        (path, "added") for path in find_meshes([folder])
    ]
    assert [(shape.name, shape.source) for shape in sorted(library.shapes(), key=lambda s: s.source)] == [
        (path.name, str(path)) for path in find_meshes([folder])
    ]
    # What the workers send back is what the model says here.
    described = model.describe(read_mesh(folder / "apple.off"))
    match = library.query(described, top=1, explain=0)[0]
    assert (match.name, match.distance) == ("apple.off", 0.0)
    stored = library.signature(match.shape_id)
    np.testing.assert_array_equal(stored.code, described.code)
    assert (stored.vertex_count, stored.face_count, stored.area) == (162, 320, described.area)
    thumbnail = library.thumbnail(match.shape_id)
    assert thumbnail is not None
    assert thumbnail.startswith(b"\x89PNG")

    assert counts(index(library, folder)) == (0, 0, 3, 0)
    assert log() == []


def test_one_path_is_not_taken_apart(library: Library, folder: Path) -> None:
    report = index_files(library, str(folder / "apple.off"), IndexSettings(jobs=1))
    assert counts(report) == (1, 0, 0, 0)
    with pytest.raises(ValueError, match="a path must be a str"):
        index_files(library, 5)  # type: ignore[arg-type]


def test_a_touched_file_is_not_described_again(indexed: Library, folder: Path, log: Log) -> None:
    os.utime(folder / "apple.off", ns=(1, 1))
    assert counts(index(indexed, folder)) == (0, 0, 3, 0)
    assert log() == []
    assert indexed.sources()[str(folder / "apple.off")].mtime_ns == 1


def test_a_changed_file_replaces_its_shape(
    indexed: Library, folder: Path, make_mesh: Callable[..., Path], log: Log
) -> None:
    before = {shape.source: shape for shape in indexed.shapes()}
    make_mesh(folder / "apple.off", seed=9, subdivisions=3)
    assert counts(index(indexed, folder)) == (0, 1, 2, 0)
    assert log() == ["apple.off"]
    after = {shape.source: shape for shape in indexed.shapes()}
    assert len(after) == len(indexed) == 3
    changed = {source for source in after if after[source] != before[source]}
    assert changed == {str(folder / "apple.off")}
    assert after[str(folder / "apple.off")].vertex_count == 642


def test_only_new_files_are_described(
    indexed: Library, folder: Path, make_mesh: Callable[..., Path], log: Log
) -> None:
    make_mesh(folder / "quince.ply", seed=9)
    assert counts(index(indexed, folder)) == (1, 0, 3, 0)
    assert log() == ["quince.ply"]


def test_copies_are_described_once_and_are_shapes_of_their_own(
    library: Library, folder: Path, log: Log
) -> None:
    for number in range(8):
        shutil.copy(folder / "apple.off", folder / f"copy{number}.off")
    assert counts(index(library, folder)) == (11, 0, 0, 0)
    assert log() == ["apple.off", "pear.obj", "plum.stl"]
    assert len(library) == 11
    match_names = [match.name for match in library.query(library.signature(1), top=11, explain=0)]
    assert sorted(match_names) == names(library)


def test_a_copy_of_a_known_file_is_not_described(indexed: Library, folder: Path, log: Log) -> None:
    shutil.copy(folder / "apple.off", folder / "more" / "another.off")
    (folder / "pear.obj").rename(folder / "renamed.obj")
    assert counts(index(indexed, folder)) == (2, 0, 2, 0)
    assert log() == []
    ids = {shape.name: shape.shape_id for shape in indexed.shapes()}
    original, copy = indexed.signature(ids["apple.off"]), indexed.signature(ids["another.off"])
    np.testing.assert_array_equal(original.bags, copy.bags)
    assert indexed.thumbnail(ids["apple.off"]) == indexed.thumbnail(ids["another.off"])


def test_contents_that_change_places(
    indexed: Library, folder: Path, make_mesh: Callable[..., Path], log: Log
) -> None:
    make_mesh(folder / "fig.off", seed=5, subdivisions=1)
    assert counts(index(indexed, folder)) == (1, 0, 3, 0)
    log()
    (folder / "apple.off").rename(folder / "x")
    (folder / "fig.off").rename(folder / "apple.off")
    (folder / "x").rename(folder / "fig.off")
    assert counts(index(indexed, folder)) == (0, 2, 2, 0)
    vertex_counts = {shape.name: shape.vertex_count for shape in indexed.shapes()}
    assert (vertex_counts["apple.off"], vertex_counts["fig.off"]) == (42, 162)


def test_the_same_bytes_under_another_suffix_are_another_matter(library: Library, folder: Path) -> None:
    shutil.copy(folder / "apple.off", folder / "apple.ply")
    report = index(library, folder, read=misbehaving.read)
    assert counts(report) == (3, 0, 0, 1)
    assert report.failed[0][0] == folder / "apple.ply"


def write_gltf(path: Path, buffer: str, mesh: trimesh.Trimesh) -> bytes:
    """Write a .gltf whose coordinates lie in another file; returns what belongs in that file."""
    points = mesh.vertices.astype("<f4").tobytes()
    corners = mesh.faces.astype("<u4").tobytes()
    low, high = mesh.vertices.min(axis=0).tolist(), mesh.vertices.max(axis=0).tolist()
    document = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "buffers": [{"uri": buffer, "byteLength": len(points) + len(corners)}],
        "bufferViews": [
            {"buffer": 0, "byteOffset": 0, "byteLength": len(points)},
            {"buffer": 0, "byteOffset": len(points), "byteLength": len(corners)},
        ],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": len(mesh.vertices), "type": "VEC3"}
            | {"min": low, "max": high},
            {"bufferView": 1, "componentType": 5125, "count": mesh.faces.size, "type": "SCALAR"},
        ],
    }
    path.write_text(json.dumps(document))
    return points + corners


def test_a_gltf_changes_with_the_file_beside_it(library: Library, tmp_path: Path, log: Log) -> None:
    sphere = trimesh.creation.icosphere(2)
    folder = tmp_path / "gltf"
    for name in ("one", "two"):
        (folder / name).mkdir(parents=True)
    data = write_gltf(folder / "one" / "shape.gltf", "shape%20data.bin", sphere)
    (folder / "one" / "shape data.bin").write_bytes(data)
    # The same text beside other coordinates: no copy.
    shutil.copy(folder / "one" / "shape.gltf", folder / "two" / "shape.gltf")
    points = sphere.vertices.astype("<f4") * np.array([1, 1, 3], "<f4")
    other = points.tobytes() + data[points.nbytes :]
    (folder / "two" / "shape data.bin").write_bytes(other)
    assert counts(index(library, folder)) == (2, 0, 0, 0)
    assert log() == ["shape.gltf", "shape.gltf"]
    areas = {shape.source: shape.area for shape in library.shapes()}
    assert areas[str(folder / "two" / "shape.gltf")] > 1.5 * areas[str(folder / "one" / "shape.gltf")]

    assert counts(index(library, folder)) == (0, 0, 2, 0)
    (folder / "one" / "shape data.bin").write_bytes(other)
    os.utime(folder / "one" / "shape data.bin", ns=(2**60, 2**60))
    assert counts(index(library, folder)) == (0, 1, 1, 0)
    # Now it is one, so it was not described.
    assert log() == []


def test_objects_of_a_plate(library: Library, tmp_path: Path) -> None:
    """Each object of a 3MF is a shape with its places, found by its name."""
    ball, ring = trimesh.creation.icosphere(2), trimesh.creation.torus(3, 1)
    resources = mesh_object(1, ball.vertices, 'name="Ball"', faces=ball.faces.tolist())
    resources += mesh_object(2, ring.vertices, 'name="Ring"', faces=ring.faces.tolist())
    built = item(1) + item(2, moved(20, 0, 0)) + item(1, moved(5, 5, 0))
    folder = tmp_path / "plates"
    folder.mkdir()
    (folder / "plate.3mf").write_bytes(package(plate(resources, built, unit="centimeter")))
    assert counts(index(library, folder, read=misbehaving.read)) == (1, 0, 0, 0)
    shapes = {shape.name: shape for shape in library.shapes()}
    assert {name: shape.placement_count for name, shape in shapes.items()} == {"Ball": 2, "Ring": 1}
    assert shapes["Ball"].object_name == "Ball"
    assert shapes["Ball"].area == pytest.approx(100 * ball.area, rel=1e-6)  # in millimetres
    places = library.placements(shapes["Ball"].shape_id)
    assert [place.matrix[:3, 3].tolist() for place in places] == [[0, 0, 0], [50, 50, 0]]


def test_a_gltf_is_tried_again_when_its_missing_part_arrives(library: Library, tmp_path: Path) -> None:
    folder = tmp_path / "gltf"
    folder.mkdir()
    data = write_gltf(folder / "shape.gltf", "shape.bin", trimesh.creation.icosphere(2))
    report = index(library, folder, read=misbehaving.read)
    assert counts(report) == (0, 0, 0, 1)
    assert "shape.bin" in report.failed[0][1]
    (folder / "shape.bin").write_bytes(data)
    assert counts(index(library, folder, read=misbehaving.read)) == (1, 0, 0, 0)


def test_a_gltf_with_its_coordinates_inside(library: Library, tmp_path: Path) -> None:
    folder = tmp_path / "gltf"
    folder.mkdir()
    data = write_gltf(folder / "shape.gltf", "URI", trimesh.creation.icosphere(2))
    uri = f"data:application/octet-stream;base64,{base64.b64encode(data).decode()}"
    (folder / "shape.gltf").write_text((folder / "shape.gltf").read_text().replace("URI", uri))
    assert counts(index(library, folder, read=misbehaving.read)) == (1, 0, 0, 0)


@pytest.mark.skipif(sys.platform != "linux", reason="other systems have no such file names")
def test_a_name_that_is_no_utf8(library: Library, tmp_path: Path, make_mesh: Callable[..., Path]) -> None:
    odd = Path(os.fsdecode(os.fsencode(tmp_path) + b"/odd/b\xe4r.off"))
    make_mesh(tmp_path / "odd" / "bear.off").rename(odd)
    assert counts(index(library, odd.parent, read=misbehaving.read)) == (1, 0, 0, 0)
    assert counts(index(library, odd.parent, read=misbehaving.read)) == (0, 0, 1, 0)
    assert [shape.source for shape in library.shapes()] == [str(odd)]


def test_a_shape_goes_when_its_file_becomes_bad(indexed: Library, folder: Path) -> None:
    (folder / "apple.off").write_text("OFF\n")
    report = index(indexed, folder, read=misbehaving.read)
    assert counts(report) == (0, 0, 2, 1)
    assert names(indexed) == ["pear.obj", "plum.stl"]


def test_one_path_needs_no_list_and_a_folder_is_refused(library: Library, tmp_path: Path) -> None:
    (tmp_path / "meshes").mkdir()
    report = index_files(library, str(tmp_path / "meshes"), IndexSettings(jobs=1))
    reason = "'meshes' is a folder; list its files with find_meshes"
    assert report.failed == [(tmp_path / "meshes", reason)]
