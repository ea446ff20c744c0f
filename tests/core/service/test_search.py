# SPDX-License-Identifier: MIT
"""Searches through the service give the answers of the library, page by page."""

from __future__ import annotations

import base64
import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from fastapi.testclient import TestClient

import shapegoogle_core as sg
from shapegoogle_core.library.match import Match
from shapegoogle_core.library.storage.signature_file import signature_to_bytes


@pytest.fixture(scope="module")
def library(made_library: Path) -> Iterator[sg.Library]:
    with sg.Library.open(made_library, read_only=True) as opened:
        yield opened


def ask(client: TestClient, *like: dict[str, Any], **options: Any) -> dict[str, Any]:
    answer = client.post("/api/queries", json={"like": like, **options})
    assert answer.status_code == 200, answer.text
    content: dict[str, Any] = answer.json()
    return content


def figures(matches: list[Match]) -> list[dict[str, object]]:
    """All that the command line shows, but for the path."""
    shown = json.loads(json.dumps([match.to_json() for match in matches]))
    return [{name: value for name, value in record.items() if name != "source"} for record in shown]


def same_figures(page: dict[str, Any], matches: list[Match]) -> bool:
    expected = figures(matches)
    found = [
        {name: record[name] for name in other}
        for record, other in zip(page["matches"], expected, strict=True)
    ]
    return found == expected


@pytest.mark.parametrize("rank", ["both", "shape", "kind"])
@pytest.mark.parametrize("shape_id", [1, 3, 5, 7])
def test_twelve_searches_give_the_answers_of_the_file(
    client: TestClient, library: sg.Library, shape_id: int, rank: Any
) -> None:
    page = ask(client, {"shape_id": shape_id}, rank=rank, limit=5, evidence=3)
    assert same_figures(page, library.query(library.signature(shape_id), top=5, explain=3, rank=rank))


def test_an_upload_gives_the_answer_of_its_file(
    client: TestClient, library: sg.Library, made_library: Path
) -> None:
    path = made_library.parent / "models" / "rod.ply"
    answer = client.post("/api/uploads", files={"file": ("../../rod.ply", path.read_bytes())})
    assert answer.status_code == 200, answer.text
    upload = answer.json()
    (shape,) = upload["shapes"]
    assert (shape["name"], shape["faces"]) == ("rod.ply", len(sg.read_mesh(path).faces))
    page = ask(client, {"upload": upload["upload"]}, limit=4, evidence=4)
    assert same_figures(page, library.query(sg.read_mesh(path), top=4, explain=4))
    assert page["matches"][0]["evidence"]["kind"] == "identical"
    assert client.get(f"/api/uploads/{upload['upload']}/0/thumbnail").content.startswith(b"\x89PNG")
    assert client.get(f"/api/uploads/{upload['upload']}/0/preview").content.startswith(b"SGPV")
    assert client.get(f"/api/uploads/{upload['upload']}/1/preview").status_code == 404


def test_a_file_that_is_no_mesh_is_refused_in_one_sentence(client: TestClient, made_library: Path) -> None:
    for name, content in (
        ("notes.txt", b"hello"),
        ("bad.obj", b"v 1 2\nf 1 2 3\n"),
        ("", b"x"),
        ("a.glb", b""),
    ):
        answer = client.post("/api/uploads", files={"file": (name or "..", content)})
        assert answer.status_code == 422, answer.text
        assert "\n" not in answer.json()["error"]
        assert str(made_library.parent) not in answer.text
        assert "/tmp" not in answer.text


def test_a_signature_finds_what_its_shape_finds(client: TestClient, library: sg.Library) -> None:
    signature = library.signature(2)
    text = base64.b64encode(signature_to_bytes(signature)).decode()
    assert same_figures(ask(client, {"signature": text}, limit=3), library.query(signature, top=3))
    for wrong in ("????", "", base64.b64encode(b"SGSIG1" + bytes(40)).decode()):
        answer = client.post("/api/queries", json={"like": [{"signature": wrong}]})
        assert answer.status_code == 422
        assert "signature" in answer.json()["error"]


def test_examples_and_counter_examples(client: TestClient, library: sg.Library) -> None:
    page = ask(client, {"shape_id": 1}, {"shape_id": 2}, unlike=[{"shape_id": 4}], limit=7, evidence=0)
    like = [library.signature(1), library.signature(2)]
    assert same_figures(page, library.query(like, unlike=library.signature(4), top=7, explain=0))


def test_pages_go_on_where_the_last_one_ended(client: TestClient, library: sg.Library) -> None:
    page = ask(client, {"shape_id": 6}, limit=2, evidence=0)
    seen = [match["shape_id"] for match in page["matches"]]
    while page["next"] is not None:
        address = f"/api/queries/{page['query']}?offset={page['next']}&limit=2&evidence=1"
        page = client.get(address).json()
        seen += [match["shape_id"] for match in page["matches"]]
        # Asking again gives the same page.
        assert client.get(address).json() == page
        assert [match["evidence"] is not None for match in page["matches"]][:1] == [True]
    assert sorted(seen) == sorted(shape.shape_id for shape in library.shapes())
    assert len(set(seen)) == len(seen)


def test_conditions(client: TestClient, library: sg.Library) -> None:
    found = ask(client, {"shape_id": 1}, where={"name": "box", "faces": [None, 100]})["matches"]
    assert {match["name"] for match in found} == {"box.ply", "large box.ply"}
    found = ask(client, {"shape_id": 1}, where={"folder": "models"})["matches"]
    assert len(found) == len(library) - 1
    found = ask(client, {"shape_id": 3}, where={"tag": "wood"})["matches"]
    assert [(match["name"], match["tags"]) for match in found] == [("labelled", ["wood"])]
    (box,) = [shape.shape_id for shape in library.find(sg.Filter(name="box.ply"))][:1]
    found = ask(client, {"shape_id": box}, where={"kind": "scaled"})["matches"]
    assert [match["evidence"]["factor"] for match in found] in ([2.0], [0.5])


@pytest.mark.parametrize(
    ("where", "sentence"),
    [
        ({"folder": "elsewhere/x"}, "begin with the name of a root of this library ('models')"),
        ({"folder": "models/../.."}, "begin with the name of a root"),
        ({"faces": [5, 1]}, "faces must be a range from low to high"),
        ({"kind": "odd"}, "where.kind: input should be 'identical'"),
        ({"nmae": "x"}, "where.nmae: extra inputs are not permitted"),
    ],
)
def test_conditions_that_cannot_be_met(client: TestClient, where: dict[str, Any], sentence: str) -> None:
    answer = client.post("/api/queries", json={"like": [{"shape_id": 1}], "where": where})
    assert answer.status_code == 422
    assert sentence in answer.json()["error"]


def test_families_and_their_versions(client: TestClient, library: sg.Library) -> None:
    (box, _) = (shape.shape_id for shape in library.find(sg.Filter(name="box")))
    page = ask(client, {"shape_id": box}, families=True)
    first = page["matches"][0]
    assert first["versions"] == 1
    versions = client.get(f"/api/queries/{page['query']}/versions/{first['shape_id']}").json()["matches"]
    assert {match["name"] for match in versions} == {"box.ply", "large box.ply"}
    assert client.get(f"/api/queries/{page['query']}/versions/999").status_code == 404


def test_what_is_not_there_is_named(client: TestClient) -> None:
    assert client.post("/api/queries", json={"like": [{"shape_id": 99}]}).status_code == 404
    assert client.post("/api/queries", json={"like": [{"upload": "../../etc/passwd"}]}).status_code == 404
    assert client.get("/api/queries/AAAAAAAAAAAAAAAAAAAAAAAA").status_code == 404
    assert client.get("/api/nothing").json()["error"].startswith("there is nothing at this address")


def test_no_answer_shows_a_path_of_the_server(client: TestClient, made_library: Path) -> None:
    folder = str(made_library.parent)
    shown = [ask(client, {"shape_id": 7})] + [
        client.get(f"/api/{address}").json()
        for address in ("info", "shapes", "shapes/7", "duplicates", "decisions", "map", "openapi.json")
    ]
    assert folder not in json.dumps(shown)
