# SPDX-License-Identifier: MIT
"""Points without faces, from files to matches."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import KDTree

import shapegoogle_core as sg
from benchmarks.creatures import make_creature
from shapegoogle_core.cli import main
from shapegoogle_core.mesh import check_cloud, face_areas
from shapegoogle_core.mesh.mesh import FloatArray, Mesh
from shapegoogle_core.model.working_shape import working_shape

Creatures = dict[str, Mesh]

KINDS = ("horse", "spider", "fish", "human")


def scan(mesh: Mesh, count: int, noise: float = 0.0, sparse: float = 1.0, seed: int = 0) -> Mesh:
    """Random points, fewer towards one side, moved by noise (a share of the diagonal)."""
    random = np.random.default_rng(seed)
    corners = mesh.vertices[mesh.faces]
    height = corners.mean(axis=1) @ random.standard_normal(3)
    density = face_areas(mesh) * (sparse + (1 - sparse) * (height - height.min()) / np.ptp(height))
    face = random.choice(len(corners), count, p=density / density.sum())
    points = np.einsum("nk,nki->ni", random.dirichlet(np.ones(3), count), corners[face])
    diagonal = np.linalg.norm(np.ptp(mesh.vertices, axis=0))
    return Mesh(points + noise * diagonal * random.standard_normal(points.shape), name=f"scan of {mesh.name}")


def write_pcd(path: Path, points: FloatArray) -> None:
    head = f"FIELDS x y z\nSIZE 8 8 8\nTYPE F F F\nWIDTH {len(points)}\nHEIGHT 1\nDATA binary\n"
    path.write_bytes(head.encode() + points.astype("<f8").tobytes())


@pytest.fixture(scope="module")
def model() -> sg.ShapeModel:
    return sg.load_model()


@pytest.fixture(scope="module")
def creatures() -> Creatures:
    return {kind: make_creature(kind, 100, 2000).pose(0) for kind in KINDS}


@pytest.fixture(scope="module")
def library_file(
    creatures: Creatures, model: sg.ShapeModel, tmp_path_factory: pytest.TempPathFactory
) -> Path:
    path = tmp_path_factory.mktemp("library") / "shapes.sglib"
    with sg.Library.open(path, model=model) as library:
        for kind, mesh in creatures.items():
            library.add(mesh, name=kind, source=kind)
    return path


@pytest.mark.parametrize(
    ("kinds", "count", "noise", "sparse"), [(KINDS, 5000, 0.0, 1.0), (KINDS[:2], 8000, 0.003, 0.1)]
)
def test_a_scan_finds_its_mesh(
    kinds: tuple[str, ...],
    count: int,
    noise: float,
    sparse: float,
    creatures: Creatures,
    model: sg.ShapeModel,
    library_file: Path,
) -> None:
    with sg.Library.open(library_file, model=model) as library:
        for kind in kinds:
            matches = library.query(scan(creatures[kind], count, noise, sparse), top=3)
            assert matches[0].name == kind


def test_a_scan_in_the_library_is_found_by_its_mesh(
    creatures: Creatures, model: sg.ShapeModel, tmp_path: Path
) -> None:
    with sg.Library.open(tmp_path / "scans.sglib", model=model) as library:
        for kind, mesh in creatures.items():
            library.add(scan(mesh, 5000), name=kind, source=kind)
        for kind in ("horse", "spider"):
            assert library.query(creatures[kind], top=1)[0].name == kind


def test_descriptors_are_those_of_the_mesh(creatures: Creatures, model: sg.ShapeModel) -> None:
    """Signatures at points and the nearest vertices are as close as docs/concepts/operators.md states."""
    times = np.array([64, 256, 1024, 4096]) / 40_000
    medians = []
    for mesh in creatures.values():
        known, found = (working_shape(model.settings, each) for each in (mesh, scan(mesh, 5000)))
        points, vertices = (each.placement.restore(each.mesh).vertices for each in (found, known))
        nearest = KDTree(vertices).query(points)[1]
        ratio = (
            sg.heat_kernel_signature(found.spectrum, times)
            / sg.heat_kernel_signature(known.spectrum, times)[nearest]
        )
        medians.append(np.median(np.abs(ratio - 1), axis=0))
    assert np.max(medians) < 0.25  # the thin legs of the spider
    assert (np.median(medians, axis=0) < 0.1).all()


def test_the_size_of_a_scan_is_that_of_its_surface(creatures: Creatures, model: sg.ShapeModel) -> None:
    mesh = creatures["horse"]
    signature = model.describe(scan(mesh, 5000), keep_surface=True)
    assert signature.area == pytest.approx(mesh.area, rel=0.1)
    assert (signature.vertex_count, signature.face_count, signature.surface) == (5000, 0, None)
    for size in (1e-6, 1e6):
        moved = Mesh(scan(mesh, 5000).vertices * size + size)
        assert model.describe(moved).area == pytest.approx(signature.area * size**2, rel=1e-3)


def test_copies_of_scans_are_copies_and_their_mesh_is_no_copy(
    creatures: Creatures, model: sg.ShapeModel, tmp_path: Path
) -> None:
    mesh = creatures["horse"]
    points = scan(mesh, 3000)
    turned = Mesh(points.vertices[:, [1, 2, 0]] + 3, name="turned")
    with sg.Library.open(tmp_path / "l.sglib", model=model) as library:
        library.add(points, name="scan", source="scan")
        library.add(mesh, name="mesh", source="mesh")
        (scan_found, mesh_found) = library.query(turned, top=2)
        assert scan_found.name == "scan"
        assert scan_found.evidence
        assert mesh_found.evidence
        assert scan_found.evidence.kind == "moved"
        assert mesh_found.evidence.kind not in ("identical", "moved", "scaled", "mirrored")


def test_files_of_scans_are_indexed_and_queried(
    creatures: Creatures, library_file: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    import trimesh

    scans = {kind: scan(creatures[kind], 2500).vertices for kind in list(creatures)[:3]}
    folder = tmp_path / "scans"
    folder.mkdir()
    paths = [folder / f"{kind}{suffix}" for kind, suffix in zip(scans, (".xyz", ".pcd", ".ply"), strict=True)]
    first, second, third = scans.values()
    np.savetxt(paths[0], first)
    write_pcd(paths[1], second)
    cloud: Any = trimesh.PointCloud
    paths[2].write_bytes(cloud(third).export(file_type="ply"))
    assert main(["query", *map(str, paths), "--library", str(library_file), "--top", "1", "--json"]) == 0
    for line, kind in zip(capsys.readouterr().out.splitlines(), scans, strict=True):
        assert json.loads(line)["matches"][0]["name"] == kind
    made = tmp_path / "made.sglib"
    assert main(["index", str(folder), "--library", str(made), "--jobs", "1", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["added"] == 3


def test_training_needs_faces(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    np.savetxt(tmp_path / "a.xyz", np.random.default_rng(0).random((50, 3)))
    assert main(["train", str(tmp_path / "a.xyz"), "--output", str(tmp_path / "m.npz")]) == 2
    assert "'a.xyz' has no faces; a model is learnt from surfaces" in capsys.readouterr().err


def test_what_needs_a_surface_says_so(creatures: Creatures) -> None:
    points = scan(creatures["horse"], 500)
    for ask in (
        lambda: sg.match_vertices(points, creatures["horse"]),
        lambda: sg.vertex_spectrum(points),
        lambda: sg.vertex_words(sg.load_model(), points),
        lambda: sg.compute_spectrum(points),
    ):
        with pytest.raises(sg.MeshError, match="has no faces"):
            ask()


@pytest.mark.parametrize(
    ("points", "words"),
    [
        (np.random.default_rng(0).random((9, 3)), "no faces and 9 points"),
        (np.tile(np.random.default_rng(0).random((9, 3)), (5, 1)), "only 9 distinct"),
        (np.outer(np.arange(50), [1, 2, 3]), "on a line"),
        (np.full((50, 3), 7.0), "only 1 distinct"),
        (np.random.default_rng(0).random((50, 3)) * 1e200, "scale the points"),
        (np.random.default_rng(0).random((50, 3)) * 1e-200, "scale the points"),
    ],
)
def test_what_is_no_scan(points: FloatArray, words: str, model: sg.ShapeModel) -> None:
    for check in (check_cloud, model.describe):
        with pytest.raises(sg.MeshError, match="'thing'") as caught:
            check(Mesh(points, name="thing"))
        assert words in str(caught.value)


@settings(max_examples=25, deadline=None)
@given(
    seed=st.integers(0, 10_000),
    count=st.integers(10, 300),
    kind=st.sampled_from(["ball", "sheet", "grid", "crowds", "ring", "lattice"]),
)
def test_strange_points_are_described_or_refused_but_crash_nothing(
    model: sg.ShapeModel, seed: int, count: int, kind: str
) -> None:
    random = np.random.default_rng(seed)
    points = random.standard_normal((count, 3))
    if kind == "sheet":
        points[:, 2] = 0
    elif kind == "grid":
        points = np.stack([np.arange(count) % 7, np.arange(count) // 7, np.zeros(count)], axis=1)
    elif kind == "crowds":
        points = points[random.integers(0, min(count, 20), count)] + 1e-9 * points
    elif kind == "ring":
        points = np.stack([np.cos(points[:, 0]), np.sin(points[:, 0]), np.zeros(count)], axis=1)
    elif kind == "lattice":
        points = np.stack([np.arange(count) % 4, np.arange(count) // 4 % 4, np.arange(count) // 16], axis=1)
    try:
        signature = model.describe(Mesh(points, name="strange"))
    except sg.MeshError:
        return
    assert np.isfinite(signature.bags).all()
    assert signature.area > 0
    assert signature.sample is not None
    assert np.isfinite(signature.sample.descriptors).all()
