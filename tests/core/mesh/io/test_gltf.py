# SPDX-License-Identifier: MIT
"""Reading glTF, text and binary."""

from __future__ import annotations

import base64
import json
from pathlib import Path
from typing import Any

import pytest

from shapegoogle_core.mesh import read_mesh
from tests.core.mesh.io.mesh_files import VOLUME, glb, gltf, gltf_tree, refuse, volume, write


def test_nodes_put_meshes_in_place(tmp_path: Path) -> None:
    nodes = [
        {"children": [1, 2], "translation": [100, 0, 0]},
        {"mesh": 0, "scale": [2, 2, 2]},
        {"mesh": 0, "matrix": [-1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, -50, 0, 0, 1]},
    ]
    mesh = read_mesh(write(tmp_path, "nodes.glb", glb(nodes=nodes)))
    assert len(mesh.faces) == 24
    # The second is mirrored: its faces have to be turned for the volume to add up.
    assert volume(mesh) == pytest.approx(9 * VOLUME, rel=1e-5)
    assert mesh.vertices[:, 0].min() == pytest.approx(48)
    assert mesh.vertices[:, 0].max() == pytest.approx(104)


def test_several_primitives(tmp_path: Path) -> None:
    tree, _ = gltf_tree()
    primitive = tree["meshes"][0]["primitives"][0]
    mesh = read_mesh(write(tmp_path, "parts.glb", glb(meshes=[{"primitives": [primitive, primitive]}])))
    assert volume(mesh) == pytest.approx(2 * VOLUME)


def test_without_scene(tmp_path: Path) -> None:
    tree, data = gltf_tree()
    for key in ("scene", "scenes", "nodes"):
        del tree[key]
    tree["buffers"][0]["uri"] = "data:;base64," + base64.b64encode(data).decode()
    mesh = read_mesh(write(tmp_path, "library.gltf", json.dumps(tree).encode()))
    assert volume(mesh) == pytest.approx(VOLUME)


def test_buffer_beside_it(tmp_path: Path) -> None:
    tree, data = gltf_tree(uri="box%20data.bin")
    path = write(tmp_path, "box.gltf", json.dumps(tree).encode())
    refuse(path, "box%20data.bin")
    write(tmp_path, "box data.bin", data)
    assert volume(read_mesh(path)) == pytest.approx(VOLUME)
    write(tmp_path, "box data.bin", data[:-10])
    refuse(path)


@pytest.mark.parametrize("uri", ["../secret.bin", "http://127.0.0.1/a.bin", "file:///etc/hostname", ""])
def test_nothing_is_fetched_from_elsewhere(tmp_path: Path, uri: str) -> None:
    tree, data = gltf_tree(uri=uri)
    write(tmp_path, "secret.bin", data)
    (tmp_path / "folder").mkdir()
    refuse(write(tmp_path / "folder", "box.gltf", json.dumps(tree).encode()), "beside it")


def test_missing_textures_do_not_matter(tmp_path: Path) -> None:
    tree, _ = gltf_tree()
    tree["meshes"][0]["primitives"][0]["material"] = 0
    data = gltf(
        meshes=tree["meshes"],
        materials=[{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}],
        textures=[{"source": 0}],
        images=[{"uri": "nowhere.png"}],
    )
    assert volume(read_mesh(write(tmp_path, "textured.gltf", data))) == pytest.approx(VOLUME)


def test_what_trimesh_would_misread(tmp_path: Path) -> None:
    tree, _ = gltf_tree()
    accessors = tree["accessors"]
    primitive = tree["meshes"][0]["primitives"][0]
    refused: list[tuple[dict[str, Any], str]] = [
        ({"extensionsRequired": ["KHR_draco_mesh_compression"]}, "Draco"),
        ({"accessors": [accessors[0] | {"sparse": {}}, accessors[1]]}, "sparse"),
        ({"accessors": [accessors[0] | {"normalized": True}, accessors[1]]}, "quantisation"),
        ({"meshes": [{"primitives": [primitive | {"mode": 6}]}]}, "fans"),
        ({"nodes": [{"mesh": 0, "children": [0]}]}, "two parents"),
        ({"accessors": [accessors[0] | {"count": 10**12}, accessors[1]]}, "1,000,000,000,000 values"),
        ({"accessors": [accessors[0] | {"count": -1}, accessors[1]]}, "accessor 0"),
        ({"asset": {"version": "1.0"}}, "1.0"),
    ]
    for changes, word in refused:
        refuse(write(tmp_path, "odd.glb", glb(**changes)), word)
        refuse(write(tmp_path, "odd.gltf", gltf(**changes)), word)


def test_many_instances_count(tmp_path: Path) -> None:
    nodes = [{"mesh": 0} for _ in range(100)]
    data = glb(nodes=nodes, scenes=[{"nodes": list(range(100))}])
    refuse(write(tmp_path, "many.glb", data), "1,200 faces", max_faces=1000)


def test_errors_quote_no_python(tmp_path: Path) -> None:
    tree, _ = gltf_tree()
    accessors = tree["accessors"]
    broken: list[dict[str, Any]] = [
        {"accessors": [accessors[0] | {"type": "VEC"}, accessors[1]]},
        {"accessors": [accessors[0] | {"componentType": 1}, accessors[1]]},
        {"bufferViews": []},
        {"buffers": [{}]},
        {"meshes": [{}]},
    ]
    for changes in broken:
        refuse(write(tmp_path, "odd.gltf", gltf(**changes)), "is damaged, cut short, or uses a feature")
    text = json.dumps(tree, indent=1).replace("{", "{,", 1)
    refuse(write(tmp_path, "odd.gltf", text), "has no valid JSON at line 1, column 2")
