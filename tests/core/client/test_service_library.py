# SPDX-License-Identifier: MIT
"""A library behind a real service gives the answers of its file."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
import trimesh

import shapegoogle_core as sg
from shapegoogle_core import cli
from shapegoogle_core.client import LibraryAddress
from shapegoogle_core.library.duplicates.groups import DuplicateGroup
from shapegoogle_core.mesh import Mesh
from shapegoogle_core.service.tokens import TokenFile
from shapegoogle_core.worker.checking import Near, check_meshes
from shapegoogle_core.worker.requests import changing, library_state
from shapegoogle_core.worker.session import Session
from tests.core.service.running import Running, running_service

SHAPES = {
    "box.ply": trimesh.creation.box((1, 2, 3)),
    "large box.ply": trimesh.creation.box((2, 4, 6)),
    "ball.ply": trimesh.creation.icosphere(2),
    "rod.ply": trimesh.creation.cylinder(0.2, 3),
}


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder "models", a library of it, and a token."""
    folder = tmp_path_factory.mktemp("client")
    (folder / "models").mkdir()
    for name, mesh in SHAPES.items():
        mesh.export(folder / "models" / name)
    with sg.Library.open(folder / "shapes.sglib") as library:
        paths = sg.find_meshes([folder / "models"])
        sg.index_files(library, paths, settings=sg.IndexSettings(jobs=1))
    return folder


@pytest.fixture(scope="module")
def token(folder: Path) -> str:
    return TokenFile(folder / "tokens.json").create("ana", "write")


@pytest.fixture(scope="module")
def running(folder: Path, token: str) -> Iterator[Running]:
    assert token
    with running_service(folder / "shapes.sglib", "--token-file", str(folder / "tokens.json")) as running:
        yield running


@pytest.fixture
def address(running: Running, token: str, folder: Path) -> LibraryAddress:
    return LibraryAddress(running.address, token=token, cache=str(folder / "models of services"))


@pytest.fixture
def file(folder: Path) -> Iterator[sg.Library]:
    with sg.Library.open(folder / "shapes.sglib", read_only=True) as library:
        yield library


def shown(matches: list[sg.Match]) -> list[tuple[Any, ...]]:
    """What is the same from file and service; the service names a source by its root."""
    return [
        (
            match.shape_id,
            match.name,
            match.distance,
            match.versions,
            match.version_ids,
            match.origin,
            None if match.evidence is None else match.evidence.kind,
            round(match.likeness or 0, 6),
        )
        for match in matches
    ]


@pytest.mark.parametrize(
    "options",
    [
        {},
        {"families": True, "top": 2},
        {"where": sg.Filter(kind="scaled", name="box"), "rank": "shape"},
        {"unlike": SHAPES["rod.ply"], "explain": 0},
    ],
)
def test_the_same_answers(address: LibraryAddress, file: sg.Library, options: dict[str, Any]) -> None:
    with address.open() as library:
        query = SHAPES["box.ply"].copy().apply_scale(3)
        expected = file.query(query, **options)
        assert expected
        assert shown(library.query(query, **options)) == shown(expected)
        assert len(library) == 4


def test_what_a_window_asks_for(address: LibraryAddress, file: sg.Library, folder: Path) -> None:
    with address.open() as library:
        signature = library.model.describe(SHAPES["box.ply"], keep_surface=True)
        (match, *_) = matches = library.query(signature, explain=0, families=True)
        assert match.source == "models/box.ply"
        assert [other.evidence and other.evidence.kind for other in library.explain(signature, matches)] == [
            other.evidence and other.evidence.kind
            for other in file.explain(signature, file.query(signature, explain=0, families=True))
        ]
        assert [version.name for version in library.versions(signature, match)] == [
            "box.ply",
            "large box.ply",
        ]
        assert library.thumbnails([match.shape_id, 99]).keys() == {match.shape_id}
        assert library.thumbnail(match.shape_id) == file.thumbnail(match.shape_id)
        assert library.preview(match.shape_id) == file.preview(match.shape_id)
        assert library.placements(match.shape_id) == file.placements(match.shape_id)
        assert [shape.name for shape in library.shapes()] == [shape.name for shape in file.shapes()]
        assert [one.text for one in library.suggest(signature)] == [
            one.text for one in file.suggest(signature)
        ]
        assert _kinds(library.duplicates()) == _kinds(file.duplicates())

        library.map_root("models", folder / "models")
        (found,) = library.find(sg.Filter(sources=(str(folder / "models" / "rod.ply"),)))
        assert found.source == str(folder / "models" / "rod.ply")
        assert library.find(sg.Filter(folder=folder / "models"), limit=2)[1].source.startswith(str(folder))
        with pytest.raises(sg.LibraryError, match="has no root 'scans'; its roots: 'models'"):
            library.map_root("scans", folder)
        for ask in (library.signature, library.shape, library.thumbnail, library.placements, library.preview):
            with pytest.raises(sg.LibraryError, match="no shape 99"):
                ask(99)


def _kinds(groups: list[DuplicateGroup]) -> list[tuple[str, list[str], int]]:
    return [(group.kind, [member.name for member in group.members], group.saved_faces) for group in groups]


def test_decisions(address: LibraryAddress) -> None:
    with changing(address) as library:
        (box, large, *_) = library.query(library.signature(library.find(sg.Filter(name="box"))[0].shape_id))
        query = library.model.describe(SHAPES["box.ply"])
        decision = library.decide("not a match", query, large.shape_id, author="somebody")
        assert decision.author == "ana"  # the name of the token
        assert large.name not in [match.name for match in library.query(query)]
        assert library.decisions() == [decision]
        library.undo(decision.number)
        assert large.name in [match.name for match in library.query(query)]
        with pytest.raises(sg.LibraryError, match="there is no decision"):
            library.undo(decision.number)
        with pytest.raises(sg.LibraryError, match="no shape 99"):
            library.decide("master", 99)
        assert box.name == "box.ply"


def test_what_is_kept_beside_a_shape_is_known_by_its_mesh(address: LibraryAddress) -> None:
    """No check of new objects lists it again, in whatever file and under whatever name."""
    ball = Mesh(SHAPES["ball.ply"].vertices * 3.0, SHAPES["ball.ply"].faces, "Moon")

    def near(mesh: Mesh, source: str) -> list[str]:
        found = check_meshes(address, [mesh], source, 0.99)
        return [line.match.name for line in found if isinstance(line, Near)]

    assert near(ball, "/scenes/sky.blend") == ["ball.ply"]
    with changing(address) as library:
        (stored,) = library.find(sg.Filter(name="ball"))
        signature = library.model.describe(ball)
        kept = library.decide("keep both", signature, stored.shape_id, name="Moon", source="sky.blend")
    moved = Mesh(ball.vertices + 5.0, ball.faces, "Moon.001")
    assert near(moved, "/scenes/other.blend") == []
    with changing(address) as library:
        library.undo(kept.number)
    assert near(moved, "/scenes/other.blend") == ["ball.ply"]


def test_searches_that_a_service_has_forgotten(address: LibraryAddress, folder: Path, token: str) -> None:
    """A service that was started again knows nothing of earlier searches: signatures are sent again."""
    options = str(folder / "shapes.sglib"), "--token-file", str(folder / "tokens.json")
    session = Session()
    with running_service(Path(options[0]), *options[1:]) as first:
        here = LibraryAddress(first.address, token=token, cache=address.cache)
        library = session.library(here)
        signature = library.model.describe(SHAPES["ball.ply"])
        before = library.query(signature, explain=0)
        port = first.address.rstrip("/").rpartition(":")[2]
    with pytest.raises(sg.LibraryError, match=f"nothing answers at 'http://127.0.0.1:{port}'"):
        session.library(here).query(signature)
    with running_service(Path(options[0]), *options[1:], "--port", port):
        library = session.library(here, look=True)
        assert library.explain(signature, before, 1)[0].evidence is not None
        assert shown(library.query(signature, explain=0)) == shown(before)
    session.close()


def test_the_model_is_downloaded_once(address: LibraryAddress, folder: Path) -> None:
    address.open().close()
    (kept,) = (folder / "models of services").glob("*.npz")
    written = kept.stat().st_ino
    address.open().close()
    assert kept.stat().st_ino == written
    kept.write_bytes(b"damaged")
    with address.open() as library:
        assert library.model.identifier == sg.ShapeModel.from_bytes(kept.read_bytes(), origin="x").identifier


def test_wrong_tokens_and_requests(running: Running, address: LibraryAddress) -> None:
    with pytest.raises(sg.LibraryError, match="refuses the token"):
        LibraryAddress(running.address, token="wrong").open()
    with pytest.raises(sg.LibraryError, match="needs a token"):
        sg.open_library(running.address, token="")
    with address.open() as library:
        with pytest.raises(sg.LibraryError, match="does not compare all shapes in full"):
            library.query(SHAPES["box.ply"], exact=True)
        with pytest.raises(ValueError, match="nothing to search for"):
            library.query([])


def test_the_command_line(
    running: Running,
    token: str,
    folder: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.setenv("SHAPEGOOGLE_TOKEN", token)
    monkeypatch.setenv("XDG_CACHE_HOME", str(folder / "cache"))
    mapped = f"models={folder / 'models'}"
    mesh = str(folder / "models" / "box.ply")
    options = ["--library", running.address]
    assert cli.main(["query", mesh, *options, "--root", mapped, "--json", "--top", "1"]) == 0
    (match,) = json.loads(capsys.readouterr().out)["matches"]
    assert (match["name"], match["source"], match["evidence"]["kind"]) == ("box.ply", mesh, "identical")
    assert cli.main(["info", *options]) == 0
    assert "models" in capsys.readouterr().out
    assert cli.main(["forget", str(folder / "models"), *options]) == 2
    assert "is a service, which others can search and decide in" in capsys.readouterr().err
    assert library_state(LibraryAddress(running.address, token=token)).roots[0].name == "models"
