# SPDX-License-Identifier: MIT
"""Containers of glTF: text, binary, buffers beside them; versions and extensions."""

from __future__ import annotations

import base64
import codecs
import json
import os
import struct
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from shapegoogle_core.mesh import read_mesh
from shapegoogle_core.mesh.io.gltf import buffer_files
from tests.core.mesh.io.gltf.builder import GltfBuilder
from tests.core.mesh.io.mesh_files import VOLUME, glb, gltf, gltf_tree, refuse, volume, write


def test_buffer_beside_it(tmp_path: Path) -> None:
    tree, data = gltf_tree(uri="box%20data.bin")
    path = write(tmp_path, "box.gltf", json.dumps(tree).encode())
    refuse(path, "box%20data.bin", "not beside it")
    assert buffer_files(path) == []
    write(tmp_path, "box data.bin", data)
    assert volume(read_mesh(path)) == pytest.approx(VOLUME)
    assert buffer_files(path) == [tmp_path / "box data.bin"]
    write(tmp_path, "box data.bin", data[:-10])
    refuse(path, "needs 168 bytes of the file 'box data.bin', which has only 158")
    write(tmp_path, "box data.bin", b"")
    refuse(path, "needs the file 'box data.bin', which is empty")


@pytest.mark.parametrize(
    ("uri", "name"),
    [
        ("box data.bin", "box data.bin"),  # a blank that should be %20
        ("100%25.bin", "100%.bin"),
        ("100%.bin", "100%.bin"),
        ("b%C3%A4r.bin", "bär.bin"),
        ("bär.bin", "bär.bin"),
        ("a%20b.bin", "a%20b.bin"),  # written without decoding
        ("./box.bin", "box.bin"),
        ("data/box.bin", "data/box.bin"),
        ("data\\box.bin", "data/box.bin"),
    ],
)
def test_names_of_buffers(tmp_path: Path, uri: str, name: str) -> None:
    tree, data = gltf_tree(uri=uri)
    (tmp_path / "data").mkdir()
    write(tmp_path, name, data)
    path = write(tmp_path, "box.gltf", json.dumps(tree).encode())
    assert volume(read_mesh(path)) == pytest.approx(VOLUME)
    assert [found.resolve() for found in buffer_files(path)] == [tmp_path / name]


@pytest.mark.skipif(os.name != "posix", reason="links need rights on Windows")
def test_a_buffer_behind_a_link(tmp_path: Path) -> None:
    """As version control for large files stores it."""
    tree, data = gltf_tree(uri="box.bin")
    folder = tmp_path / "folder"
    folder.mkdir()
    (folder / "box.bin").symlink_to(write(tmp_path, "store", data))
    assert volume(read_mesh(write(folder, "box.gltf", json.dumps(tree)))) == pytest.approx(VOLUME)


@pytest.mark.parametrize(
    "uri",
    [
        "../secret.bin",
        "%2e%2e/secret.bin",
        "a/../../secret.bin",
        "..\\secret.bin",
        "http://127.0.0.1/a.bin",
        "file:///etc/hostname",
        "/etc/hostname",
        "",
        ".",
        "nul%00.bin",
        "x" * 5000,
    ],
)
def test_nothing_is_fetched_from_elsewhere(tmp_path: Path, uri: str) -> None:
    tree, data = gltf_tree(uri=uri)
    write(tmp_path, "secret.bin", data)
    (tmp_path / "folder").mkdir()
    path = write(tmp_path / "folder", "box.gltf", json.dumps(tree).encode())
    refuse(path, "beside it")
    assert buffer_files(path) == []


@pytest.mark.parametrize(
    "head", ["data:application/octet-stream;base64,", "data:;base64,", "DATA:x/y;BASE64,"]
)
def test_data_inside(tmp_path: Path, head: str) -> None:
    tree, data = gltf_tree()
    code = base64.b64encode(data).decode()
    for text in (
        code,
        code.rstrip("="),
        code.replace("+", "%2B").replace("=", "%3D"),
        code[:40] + "\n" + code[40:],
    ):
        tree["buffers"][0]["uri"] = head + text
        assert volume(read_mesh(write(tmp_path, "box.gltf", json.dumps(tree)))) == pytest.approx(VOLUME)
    for text, word in ((code[:-9] + "*", "not base64"), (code[:-9], "needs 168 bytes of buffers[0]")):
        tree["buffers"][0]["uri"] = head + text
        refuse(write(tmp_path, "box.gltf", json.dumps(tree)), word)
    tree["buffers"][0]["uri"] = "data:nothing"
    refuse(write(tmp_path, "box.gltf", json.dumps(tree)), "data URI without a comma in buffers[0]")


def test_data_that_is_not_base64(tmp_path: Path) -> None:
    tree, data = gltf_tree()
    tree["buffers"][0]["uri"] = "data:," + "".join(f"%{byte:02x}" for byte in data)
    assert volume(read_mesh(write(tmp_path, "box.gltf", json.dumps(tree)))) == pytest.approx(VOLUME)


@pytest.mark.parametrize("encoding", ["utf-8-sig", "utf-16", "utf-16-be"])
def test_texts_with_byte_order_marks(tmp_path: Path, encoding: str) -> None:
    mark = codecs.BOM_UTF16_BE if encoding == "utf-16-be" else b""
    data = mark + gltf().decode().encode(encoding)
    assert volume(read_mesh(write(tmp_path, "box.gltf", data))) == pytest.approx(VOLUME)


def chunks(*parts: tuple[int, bytes], version: int = 2, length: int | None = None) -> bytes:
    """A binary glTF of some chunks."""
    body = b"".join(struct.pack("<II", len(part), kind) + part for kind, part in parts)
    return struct.pack("<4sII", b"glTF", version, 12 + len(body) if length is None else length) + body


JSON, BINARY = 0x4E4F534A, 0x004E4942


def test_binary_containers(tmp_path: Path) -> None:
    tree, data = gltf_tree()
    text = json.dumps(tree).encode()
    for content in (
        chunks((JSON, text + b"   "), (BINARY, data)),
        chunks((JSON, text + b"\0\0\0"), (BINARY, data + b"\0\0")),
        chunks((JSON, codecs.BOM_UTF8 + text), (BINARY, data)),
        chunks((JSON, text), (0x12345678, b"other"), (BINARY, data), (BINARY, b"")),
        chunks((JSON, text), (BINARY, data)) + b"behind it",
    ):
        assert volume(read_mesh(write(tmp_path, "box.glb", content))) == pytest.approx(VOLUME)
    good = chunks((JSON, text), (BINARY, data))
    for content, word in (
        (b"glTX" + good[4:], "does not begin like a binary glTF"),
        (gltf(), "does not begin like a binary glTF"),
        (chunks((JSON, text), (BINARY, data), version=1), "is binary glTF 1"),
        (good[:-1], f"claims {len(good):,} bytes, but has {len(good) - 1:,}"),
        (chunks((JSON, text), (BINARY, data), length=len(good) - 4), "bytes in a chunk, of which only"),
        (chunks((JSON, text)), "has no data for buffers[0]"),
        (chunks((BINARY, data), (JSON, text)), "JSON in its first chunk"),
        (
            chunks((JSON, text), (BINARY, data[:-1])),
            "needs 168 bytes of its binary chunk, which has only 167",
        ),
        (chunks(length=20) + bytes(8), "JSON in its first chunk"),
        (b"glTF", "is binary glTF 0"),
    ):
        refuse(write(tmp_path, "box.glb", content), word)
    refuse(write(tmp_path, "box.gltf", good), "begins like a .glb file")


def test_a_binary_file_may_name_others(tmp_path: Path) -> None:
    tree, data = gltf_tree(uri="box.bin")
    path = write(tmp_path, "box.glb", chunks((JSON, json.dumps(tree).encode())))
    refuse(path, "'box.bin'")
    write(tmp_path, "box.bin", data)
    assert volume(read_mesh(path)) == pytest.approx(VOLUME)
    assert buffer_files(path) == [tmp_path / "box.bin"]


def test_several_buffers(tmp_path: Path) -> None:
    """The second one is empty until a view needs it, and may be missing then."""
    tree, _ = gltf_tree()
    more: list[dict[str, Any]] = [*tree["buffers"], {"byteLength": 4, "uri": "textures.bin"}]
    more[0]["byteLength"] = 168
    assert volume(read_mesh(write(tmp_path, "box.glb", glb(buffers=more)))) == pytest.approx(VOLUME)
    views = [tree["bufferViews"][0], tree["bufferViews"][1] | {"buffer": 1}]
    refuse(write(tmp_path, "box.glb", glb(buffers=more, bufferViews=views)), "'textures.bin'")


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


@pytest.mark.parametrize(
    ("asset", "word"),
    [
        ({"version": "1.0"}, "is glTF '1.0', which cannot be read; export it as glTF 2.0"),
        ({"version": 1}, "is glTF '1'"),
        ({"version": "3.0"}, "is glTF '3.0'"),
        ([], "[] as asset instead of an object"),
    ],
)
def test_versions(tmp_path: Path, asset: Any, word: str) -> None:
    refuse(write(tmp_path, "old.gltf", gltf(asset=asset)), word)
    refuse(write(tmp_path, "old.glb", glb(asset=asset)), word)
    for known in ({"version": "2.0"}, {"version": "2.1"}, {"version": 2.0}, {}):
        assert len(read_mesh(write(tmp_path, "new.gltf", gltf(asset=known))).faces) == 12


def test_json_that_is_damaged(tmp_path: Path) -> None:
    tree, _ = gltf_tree()
    text = json.dumps(tree, indent=1).replace("{", "{,", 1)
    refuse(write(tmp_path, "odd.gltf", text), "has no valid JSON at line 1, column 2")
    refuse(write(tmp_path, "odd.gltf", "[]"), "JSON that is not an object")
    refuse(write(tmp_path, "odd.gltf", "{}"), "has no 'asset' entry")
    refuse(write(tmp_path, "odd.gltf", "[" * 100_000), "has no valid JSON")
    for changes, word in (
        ({"bufferViews": []}, "names bufferViews[0] in accessors[0], but has only 0"),
        ({"buffers": [{}]}, "has no 'byteLength' in buffers[0]"),
        ({"buffers": [None]}, "[null] as buffers instead of a list of objects"),
        ({"meshes": [{}]}, "shows no triangles and no points"),
        ({"meshes": {"primitives": []}}, "as meshes instead of a list"),
        ({"scene": "main"}, '"main" as scene instead of a whole number'),
        ({"scenes": [{"nodes": [5]}]}, "names nodes[5] in scenes[0]"),
    ):
        refuse(write(tmp_path, "odd.gltf", gltf(**changes)), word)


def test_null_is_nothing(tmp_path: Path) -> None:
    tree, _ = gltf_tree()
    primitive = tree["meshes"][0]["primitives"][0] | {"mode": None, "targets": None, "extensions": None}
    node = {"mesh": 0, "skin": None, "matrix": None, "children": None, "rotation": None, "weights": None}
    data = gltf(scene=None, skins=None, nodes=[node], meshes=[{"primitives": [primitive], "weights": None}])
    assert volume(read_mesh(write(tmp_path, "box.gltf", data))) == pytest.approx(VOLUME)


UNKNOWN = [
    "ACME_gizmo",
    "KHR_gaussian_splatting",
    "EXT_mesh_primitive_restart",
    "KHR_materialsish",
    "khr_lights_x",
]
HARMLESS = [
    "ADOBE_materials_thin_transparency",
    "EXT_lights_image_based",
    "EXT_texture_webp",
    "GOOGLE_texture_basis",
    "KHR_animation_pointer",
    "KHR_lights_punctual",
    "KHR_materials_unlit",
    "KHR_materials_variants",
    "KHR_node_visibility",
    "KHR_techniques_webgl",
    "KHR_texture_basisu",
    "KHR_texture_transform",
    "KHR_xmp_json_ld",
    "VRMC_vrm",
]


def test_unknown_required_extensions_are_refused_by_name(tmp_path: Path) -> None:
    for name in UNKNOWN:
        refuse(
            write(tmp_path, "odd.gltf", gltf(extensionsRequired=[name])),
            f"requires the glTF extension {name}",
        )
        mesh = read_mesh(write(tmp_path, "odd.gltf", gltf(extensionsUsed=[name])))
        assert volume(mesh) == pytest.approx(VOLUME)
    refuse(
        write(tmp_path, "odd.glb", glb(extensionsRequired=UNKNOWN[:2])), "ACME_gizmo, KHR_gaussian_splatting"
    )
    refuse(write(tmp_path, "odd.glb", glb(extensionsRequired="ACME_gizmo")), "as extensionsRequired")
    made = write(tmp_path, "plain.gltf", gltf(extensionsRequired=HARMLESS, extensionsUsed=HARMLESS))
    assert volume(read_mesh(made)) == pytest.approx(VOLUME)


def test_points_that_are_no_numbers_print_nothing(tmp_path: Path, recwarn: pytest.WarningsRecorder) -> None:
    made = GltfBuilder()
    points = np.full((8, 3), np.inf)
    made.scene(made.add("nodes", mesh=made.mesh(points), scale=[0, -1, 1]))
    refuse(made.save(tmp_path), "infinite")
    assert not list(recwarn)
