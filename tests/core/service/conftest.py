# SPDX-License-Identifier: MIT
"""A small library of real files, and its service in this process."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import pytest
import trimesh
from fastapi.testclient import TestClient

import shapegoogle_core as sg
from shapegoogle_core.service.app import make_app
from shapegoogle_core.service.settings import ServiceSettings

SHAPES = {
    "box.ply": trimesh.creation.box((1, 2, 3)),
    "ball.ply": trimesh.creation.icosphere(3),
    "ring.ply": trimesh.creation.torus(2, 0.5),
    "rod.ply": trimesh.creation.cylinder(0.2, 3),
    "large box.ply": trimesh.creation.box((2, 4, 6)),
    "capsule.ply": trimesh.creation.capsule(2, 0.6),
}


@pytest.fixture(scope="session")
def made_library(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A library of a folder "models"; and one shape under a label that is the path of a file."""
    folder = tmp_path_factory.mktemp("studio")
    models = folder / "models"
    models.mkdir()
    for name, mesh in SHAPES.items():
        mesh.export(models / name)
    path = folder / "shapes.sglib"
    with sg.Library.open(path) as library:
        sg.index_files(library, sg.find_meshes([models]), settings=sg.IndexSettings(jobs=1))
        secret = folder / "secret.txt"
        secret.write_text("not for everybody")
        library.add(SHAPES["ring.ply"], name="labelled", source=str(secret), tags=["wood"])
    return path


@pytest.fixture
def library_path(made_library: Path, tmp_path: Path) -> Path:
    """A copy of the library, to change."""
    return Path(shutil.copy(made_library, tmp_path / "shapes.sglib"))


Serve = Callable[..., TestClient]


@pytest.fixture(scope="session")
def settings(made_library: Path, tmp_path_factory: pytest.TempPathFactory) -> ServiceSettings:
    return ServiceSettings(str(made_library), str(tmp_path_factory.mktemp("spool")), rate=100_000)


@pytest.fixture(scope="session")
def client(settings: ServiceSettings) -> Iterator[TestClient]:
    """The service of the library that nobody changes."""
    with TestClient(make_app(settings), base_url="http://localhost") as opened:
        yield opened


@pytest.fixture
def serve(settings: ServiceSettings, tmp_path: Path) -> Iterator[Serve]:
    """Start services with other settings."""
    started = []
    spool = tmp_path / "spool"
    spool.mkdir()

    def start(**changes: object) -> TestClient:
        own = replace(settings, spool=str(spool), **changes)  # type: ignore[arg-type]
        opened = TestClient(make_app(own), base_url="http://localhost", raise_server_exceptions=False)
        opened.__enter__()
        started.append(opened)
        return opened

    yield start
    for opened in started:
        opened.__exit__(None, None, None)
