# SPDX-License-Identifier: MIT
"""Shapes, files, duplicates, the map and decisions through the service."""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import trimesh
from fastapi.testclient import TestClient

import shapegoogle_core as sg
from shapegoogle_core.rendering import read_preview
from shapegoogle_core.service.settings import ServiceError
from shapegoogle_core.service.spool import Spool

Serve = Callable[..., TestClient]


def test_lists_of_shapes(client: TestClient) -> None:
    first = client.get("/api/shapes?limit=4").json()
    rest = client.get(f"/api/shapes?limit=4&after={first['next']}").json()
    assert rest["next"] is None
    assert len({shape["shape_id"] for shape in first["shapes"] + rest["shapes"]}) == 7
    found = client.get("/api/shapes?search=BOX").json()["shapes"]
    assert {shape["source"]["path"] for shape in found} == {"box.ply", "large box.ply"}
    assert found[0]["source"]["root"] == "models"
    assert client.get("/api/shapes/1").json() == first["shapes"][0]
    by_number = client.post("/api/shapes", json={"shape_ids": [2, 99, 1]}).json()["shapes"]
    assert {shape["shape_id"] for shape in by_number} == {1, 2}
    refused = client.post("/api/shapes", json={"shape_ids": [1], "where": {"name": "ball"}})
    assert refused.status_code == 422
    assert "leave one of them out" in refused.json()["error"]


def test_pictures_and_previews(client: TestClient) -> None:
    assert client.get("/api/shapes/1/thumbnail").content.startswith(b"\x89PNG")
    assert len(read_preview(client.get("/api/shapes/1/preview").content).mesh.faces) > 0
    # The shape that was added by hand has no picture; its sample is shown.
    assert client.get("/api/shapes/7/thumbnail").status_code == 404
    points = read_preview(client.get("/api/shapes/7/preview").content).mesh
    assert points.is_point_cloud
    np.testing.assert_allclose(np.ptp(points.vertices, axis=0), [5, 5, 1], rtol=0.03)


def test_only_indexed_files_can_be_downloaded(serve: Serve, client: TestClient, made_library: Path) -> None:
    assert client.get("/api/shapes/1/file").status_code == 403
    open_service = serve(allow_download=True)
    shape = open_service.get("/api/shapes/1").json()
    content = (made_library.parent / "models" / shape["source"]["path"]).read_bytes()
    answer = open_service.get("/api/shapes/1/file")
    assert answer.content == content
    assert answer.headers["content-disposition"].startswith("attachment")
    assert open_service.get("/api/shapes/7/file").status_code == 404


def test_duplicates_and_decisions(serve: Serve, library_path: Path) -> None:
    client = serve(library=str(library_path))
    (group,) = [
        found for found in client.get("/api/duplicates").json()["groups"] if found["kind"] == "scaled"
    ]
    first, second = (member["shape_id"] for member in group["members"])
    kept = client.post(
        "/api/decisions", json={"kind": "keep both", "shape": {"shape_id": first}, "other": second}
    )
    assert kept.status_code == 200
    assert "scaled" not in {found["kind"] for found in client.get("/api/duplicates").json()["groups"]}
    query = {"like": [{"shape_id": first}], "limit": 10, "evidence": 0}
    client.post("/api/decisions", json={"kind": "not a match", "shape": {"shape_id": first}, "other": second})
    found = client.post("/api/queries", json=query).json()["matches"]
    assert second not in {match["shape_id"] for match in found}
    decisions = client.get("/api/decisions").json()["decisions"]
    assert [decision["kind"] for decision in decisions] == ["keep both", "not a match"]
    for decision in decisions:
        assert client.delete(f"/api/decisions/{decision['number']}").status_code == 200
    assert client.delete("/api/decisions/1").status_code == 404
    found = client.post("/api/queries", json=query).json()["matches"]
    assert second in {match["shape_id"] for match in found}
    client.post("/api/decisions", json={"kind": "tag", "shape": {"shape_id": first}, "tag": "crate"})
    assert [shape["shape_id"] for shape in client.get("/api/shapes?tag=crate").json()["shapes"]] == [first]


@pytest.mark.parametrize(
    ("decision", "status"),
    [
        ({"kind": "keep both", "shape": {"shape_id": 1}}, 422),
        ({"kind": "keep both", "shape": {"shape_id": 1}, "other": 1}, 422),
        ({"kind": "tag", "shape": {"shape_id": 1}}, 422),
        ({"kind": "master", "shape": {"shape_id": 99}}, 404),
        ({"kind": "like it", "shape": {"shape_id": 1}}, 422),
    ],
)
def test_decisions_that_make_no_sense(client: TestClient, decision: dict[str, object], status: int) -> None:
    assert client.post("/api/decisions", json=decision).status_code == status


def test_the_map_shows_all_shapes(client: TestClient) -> None:
    answer = client.get("/api/map").json()
    assert (answer["ready"], answer["total"], len(answer["points"])) == (True, 7, 7)
    place = {point["name"]: np.array([point["x"], point["y"]]) for point in answer["points"]}
    same = np.linalg.norm(place["box.ply"] - place["large box.ply"])
    assert same < np.linalg.norm(place["box.ply"] - place["ring.ply"])


def test_the_model_is_there_for_clients(client: TestClient, tmp_path: Path) -> None:
    answer = client.get("/api/model")
    (tmp_path / "model.npz").write_bytes(answer.content)
    model = sg.load_model(tmp_path / "model.npz")
    assert model.identifier == client.get("/api/info").json()["model"]
    assert client.get("/api/model", headers={"If-None-Match": answer.headers["etag"]}).status_code == 304


def test_new_shapes_and_a_new_file_are_seen(serve: Serve, library_path: Path) -> None:
    client = serve(library=str(library_path))
    assert client.get("/api/info").json()["shapes"] == 7
    with sg.Library.open(library_path) as library:
        library.add(trimesh.creation.cone(1, 2), name="cone")
    assert client.get("/api/info").json()["shapes"] == 8
    other = library_path.with_name("other.sglib")
    with sg.Library.open(other) as library:
        library.add(trimesh.creation.cone(1, 2), name="cone")
    other.replace(library_path)
    assert client.get("/api/info").json()["shapes"] == 1


def test_the_spool_forgets_what_is_old(tmp_path: Path) -> None:
    spool = Spool(tmp_path)
    names = [spool.new_name() for _ in range(3)]
    for name in names:
        spool.put(name, "query.json", b"{}")
    old = tmp_path / f"{names[0]}.query.json"
    long_ago = time.time() - 10 * 3600
    os.utime(old, (long_ago, long_ago))
    Spool(tmp_path).put(names[1], "query.json", b"new")
    assert spool.get(names[1], "query.json") == b"new"
    with pytest.raises(ServiceError, match="not known any more"):
        spool.get(names[0], "query.json")
