# SPDX-License-Identifier: MIT
"""Evidence of shapes with several placements: that of the one that fits best."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import trimesh

import shapegoogle_core as sg
from benchmarks.creatures import make_creature
from shapegoogle_core.indexing import describe_shape
from shapegoogle_core.library.match import Match
from shapegoogle_core.library.placement import placements_of
from shapegoogle_core.library.storage.records import NewShape
from shapegoogle_core.mesh import Mesh
from shapegoogle_core.mesh.mesh import FloatArray

TURN = np.array([[0, -1, 0, 0], [1, 0, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]], np.float64)


def moved(x: float, y: float = 0.0, scale: tuple[float, float, float] = (1, 1, 1)) -> FloatArray:
    matrix = np.diag([*scale, 1.0])
    matrix[:2, 3] = x, y
    return matrix


# The first is neither at the origin nor of the size of its data.
OBJECTS = {
    "First": moved(5, 1, (0.5, 0.5, 0.5)) @ TURN,
    "Mirrored": moved(5, 1, (-0.5, 0.5, 0.5)) @ TURN,
    "Twice": moved(-20, 3),
    "Turned": moved(5, 1, (0.5, 0.5, 0.5)),
    "Far": moved(40, 0, (-3, 3, 3)),
}


def placed(mesh: Mesh, matrix: FloatArray) -> Mesh:
    faces = mesh.faces[:, ::-1] if np.linalg.det(matrix[:3, :3]) < 0 else mesh.faces
    return Mesh(mesh.vertices @ matrix[:3, :3].T + matrix[:3, 3], faces, mesh.name)


@pytest.fixture(scope="module")
def data() -> Mesh:
    """Without any symmetry."""
    return make_creature("ape", 0, 1_000).pose(2)


@pytest.fixture(scope="module")
def library(tmp_path_factory: pytest.TempPathFactory, data: Mesh) -> Iterator[sg.Library]:
    with sg.Library.open(tmp_path_factory.mktemp("placed") / "shapes.sglib") as opened:
        opened.replace_source("zoo.blend", size=None, mtime_ns=None, sha256=None, shapes=[zoo(opened, data)])
        yield opened


def zoo(library: sg.Library, data: Mesh) -> NewShape[sg.ShapeSignature]:
    mesh = placed(data, OBJECTS["First"])
    shape = NewShape(mesh, "First", "First", placements=placements_of(mesh, list(OBJECTS.items())))
    return describe_shape(shape, library.model)


def best(library: sg.Library, mesh: Mesh) -> Match:
    (match,) = library.query(mesh, top=1)
    assert match.evidence is not None
    assert match.placement is not None
    assert match.placement.object_name == match.object_name
    assert match.placement_count == len(OBJECTS)
    assert match.area == pytest.approx(
        sg.Mesh(mesh.vertices, mesh.faces).area * match.evidence.factor**2, 1e-3
    )
    return match


@pytest.mark.parametrize("name", OBJECTS)
def test_each_object_is_identical_to_its_own_placement(library: sg.Library, data: Mesh, name: str) -> None:
    match = best(library, placed(data, OBJECTS[name]))
    assert (match.object_name, match.evidence and match.evidence.kind) == (name, "identical")


@pytest.mark.parametrize(
    ("matrix", "name", "kind", "factor"),
    [
        (moved(100, 7, (1, 1, 1)) @ TURN, "Twice", "moved", 1.0),
        (moved(100, 7, (-3, 3, 3)), "Far", "moved", 1.0),
        (moved(100, 7, (-0.5, 0.5, 0.5)), "Mirrored", "moved", 1.0),
        (moved(0, 0, (0.9, 0.9, 0.9)), "Twice", "scaled", 1.111),
        (moved(0, 0, (-2.9, 2.9, 2.9)), "Far", "scaled", 1.034),
        # Of its size there is only a mirror image, so it is compared with the others.
        (moved(0, 0, (-1, 1, 1)), "Mirrored", "scaled", 0.5),
    ],
)
def test_other_places_and_sizes_are_compared_with_the_nearest(
    library: sg.Library, data: Mesh, matrix: FloatArray, name: str, kind: str, factor: float
) -> None:
    match = best(library, placed(data, matrix))
    assert match.evidence is not None
    assert (match.object_name, match.evidence.kind) == (name, kind)
    assert match.evidence.factor == pytest.approx(factor, rel=2e-3)


@pytest.mark.parametrize(
    ("where", "name", "factor"),
    [
        (sg.Filter(name="twice"), "Twice", 2.0),
        (sg.Filter(name="F*r"), "Far", 6.0),
        (sg.Filter(name="m?rr*d"), "Mirrored", 1.0),
        (sg.Filter(size=(2.0, None)), "Far", 6.0),
        # Each condition is met by another one.
        (sg.Filter(name="First", size=(2.0, None)), "First", 1.0),
    ],
)
def test_the_placement_meets_the_filter(
    library: sg.Library, data: Mesh, where: sg.Filter, name: str, factor: float
) -> None:
    (match,) = library.query(placed(data, OBJECTS["First"]), top=1, where=where)
    assert match.evidence is not None
    assert match.object_name == name
    assert match.evidence.factor == pytest.approx(factor, rel=1e-3)


def test_explaining_again_changes_nothing(library: sg.Library, data: Mesh) -> None:
    mesh = placed(data, OBJECTS["Far"])
    signature = library.model.describe(mesh, keep_surface=True)
    (match,) = library.query(signature, top=1)
    (again,) = library.explain(signature, match)
    assert again == match
    assert again.area == pytest.approx(match.area)
    other = library.model.describe(placed(data, OBJECTS["Twice"]), keep_surface=True)
    (third,) = library.explain(other, match)
    assert third.object_name == "Twice"
    assert third.area == pytest.approx(match.area / 9, rel=1e-3)


def test_another_pose_has_the_nearest_size(library: sg.Library) -> None:
    posed = make_creature("ape", 0, 1_000).pose(1)
    match = best(library, posed)
    assert match.evidence is not None
    assert match.evidence.kind == "re-posed"
    assert match.object_name == "Twice"
    assert match.evidence.factor == pytest.approx(1, rel=0.1)


def test_a_shape_that_is_its_own_mirror_image_moves(library: sg.Library) -> None:
    """Its mirrored object is not different from it."""
    mesh = Mesh(trimesh.creation.box((1, 2, 3)).vertices, trimesh.creation.box().faces)
    with sg.Library.open(library.path.with_name("symmetric.sglib")) as own:
        objects = [("First", moved(0)), ("Big", moved(9, 0, (-2, 2, 2)))]
        shape = NewShape(mesh, "First", "First", placements=placements_of(mesh, objects))
        described = describe_shape(shape, own.model)
        own.replace_source("zoo.blend", size=None, mtime_ns=None, sha256=None, shapes=[described])
        (match,) = own.query(placed(mesh, moved(30, 2, (2, 2, 2))), top=1)
        (here,) = own.query(placed(mesh, moved(9, 0, (2, 2, 2))), top=1)
    assert match.evidence is not None
    assert (match.object_name, match.evidence.kind, match.evidence.factor) == ("Big", "moved", 1)
    assert here.evidence is not None
    # The same points, but a cube's faces are cut along other diagonals in the mirror.
    assert (here.object_name, here.evidence.factor) == ("Big", 1)


def test_thousands_of_placements(library: sg.Library, data: Mesh) -> None:
    """Around one axis, so that all have the same centre, or nearly."""
    objects = []
    for number in range(1_400):
        angle = 2 * np.pi * number / 1_400
        matrix = np.eye(4)
        matrix[:2, :2] = [[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]
        objects.append((f"Blade.{number:04d}", matrix))
    with sg.Library.open(library.path.with_name("many.sglib")) as own:
        shape = NewShape(data, "Blade.0000", "Blade.0000", placements=placements_of(data, objects))
        described = describe_shape(shape, own.model)
        own.replace_source("fan.blend", size=None, mtime_ns=None, sha256=None, shapes=[described])
        assert len(own) == 1
        (record,) = own.shapes()
        assert record.placement_count == 1_400
        (match,) = own.query(placed(data, objects[777][1]), top=1)
    assert match.evidence is not None
    assert (match.object_name, match.evidence.kind) == ("Blade.0777", "identical")
    assert replace(match, placement=None).to_json()["placements"] == 1_400


def test_placements_are_no_duplicates(library: sg.Library) -> None:
    assert library.duplicates() == []
    (record,) = library.shapes()
    placements = library.placements(record.shape_id)
    shape = NewShape(library.signature(record.shape_id), "First", "First", placements=placements)
    with sg.Library.open(library.path.with_name("copies.sglib")) as own:
        for source in ("zoo.blend", "park.blend"):
            own.replace_source(source, size=None, mtime_ns=None, sha256=None, shapes=[shape])
        (group,) = own.duplicates()
    assert group.kind == "identical"
    assert [(member.source, member.placements) for member in group.members] == [
        ("zoo.blend", len(OBJECTS)),
        ("park.blend", len(OBJECTS)),
    ]
    assert group.to_json()["saving"] == {"faces": record.face_count, "bytes": 0}
    members = group.to_json()["members"]
    assert isinstance(members, list)
    assert set(members[0]) >= {"name", "source", "scale", "placements"}


@pytest.mark.parametrize(("name", "factor"), [("First", 0.5), ("Twice", 1.0), ("Far", 3.0), (None, 2.0)])
def test_any_placement_may_be_of_the_area_of_a_filter(
    library: sg.Library, data: Mesh, name: str | None, factor: float
) -> None:
    area = data.area * factor**2
    where = sg.Filter(area=(0.9 * area, 1.1 * area))
    # In another place, so that no placement is identical.
    found = library.query(placed(data, moved(9, 9, (factor, factor, factor))), where=where)
    assert [match.object_name for match in found] == ([] if name is None else [name])


def test_duplicates_compare_the_placements_that_agree_best(tmp_path: Path, data: Mesh) -> None:
    others = {
        "of the size of Twice": ("moved", 1.0, moved(70, 7)),
        "mirrored like Far": ("moved", 1.0, moved(0, 7, (3, -3, 3))),
        "larger than all": ("scaled", 2.0, moved(0, 7, (2, 2, 2))),
        "in the place of First": ("identical", 1.0, OBJECTS["First"]),
    }
    for name, (kind, factor, matrix) in others.items():
        with sg.Library.open(tmp_path / f"{name}.sglib") as both:
            both.replace_source("zoo.blend", size=None, mtime_ns=None, sha256=None, shapes=[zoo(both, data)])
            both.add(placed(data, matrix), name=name)
            (group,) = both.duplicates()
        assert (group.kind, len(group.members)) == (kind, 2), name
        assert group.members[1].scale == pytest.approx(factor, rel=1e-4), name
