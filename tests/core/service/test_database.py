# SPDX-License-Identifier: MIT
"""The service of a library in a database answers as that of a file."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

import shapegoogle_core as sg
from tests.core.postgresql_server import postgresql, postgresql_url
from tests.core.service.conftest import Serve

__all__ = ["postgresql", "postgresql_url"]


@pytest.mark.long
def test_a_database_answers_as_a_file(serve: Serve, library_path: Path, postgresql_url: str) -> None:
    with sg.Library.open(library_path, read_only=True) as file, sg.Library.open(postgresql_url) as database:
        for shape in file.shapes():
            picture = file.thumbnail(shape.shape_id)
            database.add_signature(file.signature(shape.shape_id), shape.name, thumbnail=picture)
        database.update_neighbours()
    services = [serve(library=place) for place in (str(library_path), postgresql_url)]

    def answers(method: str, path: str, content: Any = None) -> list[Any]:
        found = [service.request(method, f"/api/{path}", json=content) for service in services]
        assert [answer.status_code for answer in found] == [200, 200], found[1].text
        return [answer.json() for answer in found]

    shown = ("name", "distance", "similarity", "likeness", "evidence")
    for shape_id in range(1, 8):
        query = {"like": [{"shape_id": shape_id}], "limit": 7, "evidence": 3}
        pages = answers("POST", "queries", query)
        first, second = ([[match[name] for name in shown] for match in page["matches"]] for page in pages)
        assert first == second
    answers("POST", "decisions", {"kind": "master", "shape": {"shape_id": 1}, "author": "ana"})
    first, second = answers("GET", "decisions")
    assert first["decisions"][0]["sentence"] == second["decisions"][0]["sentence"]
    _, info = answers("GET", "info")
    assert info["library"] in postgresql_url
    assert "@" not in info["library"]
