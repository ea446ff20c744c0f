# SPDX-License-Identifier: MIT
"""Reading: every format gives the same shape, every kind of damage a sentence."""

from __future__ import annotations

import base64
import json
import os
import re
import struct
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
import trimesh
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from shapegoogle_core.errors import MeshError
from shapegoogle_core.mesh import MESH_SUFFIXES, Mesh, read_mesh
from shapegoogle_core.preprocessing import repair

POINTS = np.array(
    [[0, 0, 0], [2, 0, 0], [2, 1, 0], [0, 1, 0], [0, 0, 3], [2, 0, 3], [2, 1, 3], [0, 1, 3]], np.float64
)
QUADS = [(0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (2, 3, 7, 6), (1, 2, 6, 5), (3, 0, 4, 7)]
TRIANGLES = [(a, b, c) for a, b, c, d in QUADS for a, b, c in ((a, b, c), (a, c, d))]
MIXED = [*QUADS[:3], *TRIANGLES[6:]]
AREA = 2 * (2 * 1 + 2 * 3 + 1 * 3)
VOLUME = 6.0


def volume(mesh: Mesh) -> float:
    a, b, c = (mesh.vertices[mesh.faces[:, corner]] for corner in range(3))
    return float(np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6)


def obj(points=POINTS, faces=TRIANGLES) -> bytes:
    lines = [f"v {x} {y} {z}" for x, y, z in points]
    lines += ["f " + " ".join(str(corner + 1) for corner in face) for face in faces]
    return ("# a box\n" + "\n".join(lines) + "\n").encode()


def off(points=POINTS, faces=TRIANGLES, first="OFF") -> bytes:
    lines = [first, f"{len(points)} {len(faces)} 0", *(f"{x} {y} {z}" for x, y, z in points)]
    lines += [f"{len(face)} " + " ".join(map(str, face)) for face in faces]
    return ("\n".join(lines) + "\n").encode()


def ply(points=POINTS, faces=TRIANGLES, kind="binary_little_endian", corners="vertex_indices") -> bytes:
    header = [
        "ply",
        f"format {kind} 1.0",
        "comment made by a test",
        f"element vertex {len(points)}",
        *(f"property float {axis}" for axis in "xyz"),
        "property uchar red",
        f"element face {len(faces)}",
        "property uchar flags",
        f"property list uchar int {corners}",
        "end_header",
    ]
    data = ("\n".join(header) + "\n").encode()
    if kind == "ascii":
        rows = [f"{x} {y} {z} 7" for x, y, z in points]
        rows += [f"1 {len(face)} " + " ".join(map(str, face)) for face in faces]
        return data + ("\n".join(rows) + "\n").encode()
    order = "<" if kind == "binary_little_endian" else ">"
    data += b"".join(struct.pack(order + "3fB", *point, 7) for point in points)
    return data + b"".join(struct.pack(f"{order}BB{len(face)}i", 1, len(face), *face) for face in faces)


def stl(points=POINTS, faces=TRIANGLES) -> bytes:
    data = b"a box".ljust(80) + struct.pack("<I", len(faces))
    return data + b"".join(struct.pack("<12fH", 0, 0, 0, *points[list(face)].ravel(), 0) for face in faces)


def stl_text(points=POINTS, faces=TRIANGLES) -> bytes:
    lines = ["solid box"]
    for face in faces:
        lines += ["facet normal 0 0 0", " outer loop"]
        lines += [f"  vertex {x} {y} {z}" for x, y, z in points[list(face)]]
        lines += [" endloop", "endfacet"]
    return ("\n".join([*lines, "endsolid box"]) + "\n").encode()


def gltf_tree(points=POINTS, faces=TRIANGLES, uri: str | None = None) -> tuple[dict, bytes]:
    """The JSON part and the buffer of a glTF with one mesh in one node."""
    position = np.asarray(points, "<f4").tobytes()
    index = np.asarray(faces, "<u2").tobytes()
    buffer = {"byteLength": len(position) + len(index)}
    if uri is not None:
        buffer["uri"] = uri
    tree = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": len(points), "type": "VEC3"},
            {"bufferView": 1, "componentType": 5123, "count": 3 * len(faces), "type": "SCALAR"},
        ],
        "bufferViews": [
            {"buffer": 0, "byteOffset": 0, "byteLength": len(position)},
            {"buffer": 0, "byteOffset": len(position), "byteLength": len(index)},
        ],
        "buffers": [buffer],
    }
    return tree, position + index


def gltf(points=POINTS, faces=TRIANGLES, **changes) -> bytes:
    tree, data = gltf_tree(points, faces)
    tree["buffers"][0]["uri"] = "data:application/octet-stream;base64," + base64.b64encode(data).decode()
    return json.dumps(tree | changes).encode()


def glb(points=POINTS, faces=TRIANGLES, **changes) -> bytes:
    tree, data = gltf_tree(points, faces)
    text = json.dumps(tree | changes).encode()
    text += b" " * (-len(text) % 4)
    data += b"\0" * (-len(data) % 4)
    chunks = (
        struct.pack("<II", len(text), 0x4E4F534A) + text + struct.pack("<II", len(data), 0x004E4942) + data
    )
    return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks


FILES = {
    "box.obj": obj(),
    "box.off": off(),
    "box.ply": ply(),
    "box_big.ply": ply(kind="binary_big_endian"),
    "box_text.ply": ply(kind="ascii"),
    "box.stl": stl(),
    "box_text.stl": stl_text(),
    "box.gltf": gltf(),
    "box.glb": glb(),
}


def write(folder: Path, name: str, data: bytes) -> Path:
    path = folder / name
    path.write_bytes(data)
    return path


def refuse(path: Path, *words: str, **options) -> None:
    """The file is refused with an error that names it and says these words."""
    with pytest.raises(MeshError) as caught:
        read_mesh(path, **options)
    message = str(caught.value)
    assert path.name in message
    for word in words:
        assert word in message


@pytest.mark.parametrize("name", FILES)
def test_every_format_gives_the_same_box(tmp_path, name):
    mesh = read_mesh(write(tmp_path, name, FILES[name]))
    assert mesh.name == name
    assert len(mesh.faces) == 12
    assert mesh.area == pytest.approx(AREA)
    assert volume(mesh) == pytest.approx(VOLUME)
    assert len(repair(mesh).vertices) == 8


def test_suffixes(tmp_path):
    assert sorted(MESH_SUFFIXES) == [".glb", ".gltf", ".obj", ".off", ".pcd", ".ply", ".stl", ".xyz"]
    assert read_mesh(str(write(tmp_path, "BOX.OBJ", obj()))).name == "BOX.OBJ"


@pytest.mark.parametrize(
    "data",
    [
        obj(faces=QUADS),
        obj(faces=MIXED),
        off(faces=QUADS),
        off(faces=MIXED),
        off(faces=[(*face, 255, 0, 0)[:3] for face in TRIANGLES], first="OFF # comment"),
        *(
            ply(faces=f, kind=k)
            for f in (QUADS, MIXED)
            for k in ("ascii", "binary_little_endian", "binary_big_endian")
        ),
        ply(corners="vertex_index"),
    ],
)
def test_polygons_become_triangles(tmp_path, data):
    suffix = ".off" if data.startswith(b"OFF") else ".ply" if data.startswith(b"ply") else ".obj"
    mesh = read_mesh(write(tmp_path, "box" + suffix, data))
    assert len(mesh.faces) == 12
    assert volume(mesh) == pytest.approx(VOLUME)


def test_pentagon_is_a_fan(tmp_path):
    points = np.array([[0, 0, 0], [2, 0, 0], [3, 1, 0], [1, 3, 0], [-1, 1, 0]], float)
    for name, data in {"a.obj": obj(points, [range(5)]), "a.off": off(points, [range(5)])}.items():
        mesh = read_mesh(write(tmp_path, name, data))
        assert mesh.faces.tolist() == [[0, 1, 2], [0, 2, 3], [0, 3, 4]]


class TestObj:
    def test_relative_indices_count_back_from_their_line(self, tmp_path):
        first, second = obj(faces=[]).decode(), obj(POINTS + 10, faces=[]).decode()
        faces = "".join("f " + " ".join(str(corner - 8) for corner in face) + "\n" for face in TRIANGLES)
        mesh = read_mesh(write(tmp_path, "two.obj", (first + faces + "o second\n" + second + faces).encode()))
        assert volume(mesh) == pytest.approx(2 * VOLUME)
        assert np.ptp(mesh.vertices, axis=0).tolist() == [12, 11, 13]

    def test_what_real_files_bring(self, tmp_path):
        """Other indices, missing materials, colours, tabs, blanks, continued lines, letters outside UTF-8."""
        text = (
            obj()
            .decode()
            .replace("v ", "v\t")
            .replace("f ", "  f ")
            .replace("# a box", "mtllib no.mtl\no Würfel")
        )
        text = text.replace("f 1 4 3", "vt 0 0\nvn 0 0 1\nusemtl none\nf 1/1/1 \\\n 4//1 3/1\nl 1 2").replace(
            "3.0\n", "3.0 1 0.5 0.5\n"
        )
        mesh = read_mesh(write(tmp_path, "real.obj", text.encode("latin-1")))
        assert len(mesh.vertices) == 8
        assert volume(mesh) == pytest.approx(VOLUME)

    def test_texture_does_not_split_vertices(self, tmp_path):
        text = obj().decode().replace("f ", "vt 0 0\nvt 1 1\nf ")
        text = "\n".join(
            re.sub(r" (\d+)", rf" \1/{1 + index % 2}", line) if line.startswith("f") else line
            for index, line in enumerate(text.split("\n"))
        )
        mesh = read_mesh(write(tmp_path, "seams.obj", text.encode()))
        assert np.array_equal(mesh.vertices, POINTS)
        assert mesh.faces.tolist() == [list(face) for face in TRIANGLES]

    @pytest.mark.parametrize("seed", range(8))
    def test_many_lines_at_once_are_read_as_one_by_one(self, tmp_path, seed):
        """Polygons of all sizes, texture and normals, relative corners, weights and colours, in any mix."""
        rng = np.random.default_rng(seed)
        lines, vertices, faces = [], [], []
        for _ in range(60):
            vertices.append(rng.normal(size=3).tolist())
            lines.append(
                " ".join(["v", *map(repr, vertices[-1])]) + (" 1 0.5 0" if rng.random() < 0.2 else "")
            )
            if len(vertices) < 8 or (seed % 2 and rng.random() < 0.5):
                continue
            corners = rng.choice(len(vertices), rng.integers(1, 7) if seed % 4 else 4, replace=False)
            faces += [(corners[0], *pair) for pair in pairwise(corners[1:])]
            relative = rng.random() < 0.3
            spelt = [str(corner - len(vertices) if relative else corner + 1) for corner in corners]
            lines.append("f " + " ".join(one + rng.choice(["", "/7", "//7", "/7/7"]) for one in spelt))
        mesh = read_mesh(write(tmp_path, "mix.obj", "\n".join(lines).encode()))
        assert np.array_equal(mesh.vertices, vertices)
        read, expected = (
            sorted(np.roll(face, -np.argmin(face)).tolist() for face in every)
            for every in (mesh.faces, faces)
        )
        assert read == expected

    @pytest.mark.parametrize(
        "face", ["f", "f ", "f 1 1.5 3", "f 1-2 3", "f 1, 2, 3", "f /1 2 3", "v 1 2 z 4"]
    )
    def test_lines_that_numbers_alone_would_not_show(self, tmp_path, face):
        refuse(write(tmp_path, "bad.obj", face.encode() + b"\n" + obj()), f"a line {face.strip()!r}")

    @pytest.mark.parametrize("face", ["f 0 1 2", "f 1 2 99", "f 1 2 -9", "f 1 x 3", "v 1 2", "v 1 2 zz"])
    def test_damaged_lines(self, tmp_path, face):
        refuse(write(tmp_path, "bad.obj", obj() + face.encode() + b"\n"))


class TestPly:
    def test_more_properties_and_elements(self, tmp_path):
        data = ply(faces=MIXED).replace(
            b"property list uchar int vertex_indices",
            b"property list uchar int vertex_indices\nproperty float quality\n"
            b"element extra 1\nproperty list int short values",
        )
        head, body = data[: data.index(b"end_header\n") + 11], data[data.index(b"end_header\n") + 11 :]
        vertices, faces = body[: 13 * 8], body[13 * 8 :]
        rows, position = b"", 0
        while position < len(faces):
            end = position + 2 + 4 * faces[position + 1]
            rows += faces[position:end] + struct.pack("<f", 0.5)
            position = end
        mesh = read_mesh(write(tmp_path, "more.ply", head + vertices + rows + struct.pack("<i2h", 2, 1, 2)))
        assert volume(mesh) == pytest.approx(VOLUME)

    def test_element_before_the_vertices(self, tmp_path):
        data = ply(kind="ascii").replace(
            b"element vertex", b"element camera 1\nproperty float f\nelement vertex"
        )
        data = data.replace(b"end_header\n", b"end_header\n35.0\n")
        assert volume(read_mesh(write(tmp_path, "camera.ply", data))) == pytest.approx(VOLUME)

    @pytest.mark.parametrize("kind", ["ascii", "binary_little_endian", "binary_big_endian"])
    def test_polygons_of_many_sizes(self, tmp_path, kind):
        """Faces of 1 to 6 corners; those of one or two are no surface."""
        points = np.array([[2, 0, 0], [1, 2, 0], [-1, 2, 0], [-2, 0, 0], [-1, -2, 0], [1, -2, 0]], float)
        faces = [range(size) for size in (5, 3, 6, 1, 4, 2, 6)]
        mesh = read_mesh(write(tmp_path, "sizes.ply", ply(points, faces, kind)))
        assert len(mesh.faces) == 3 + 1 + 4 + 2 + 4
        assert mesh.area == pytest.approx(10 + 2 + 12 + 6 + 12)

    def test_sizes_that_add_up_to_as_many_bytes(self, tmp_path):
        """A triangle, a quad and a pentagon take as much room as three quads."""
        points = np.array([[2, 0, 0], [1, 2, 0], [-1, 2, 0], [-2, 0, 0], [0, -3, 0]], float)
        mesh = read_mesh(write(tmp_path, "sum.ply", ply(points, [range(4), range(3), range(5)])))
        assert mesh.faces.tolist() == [[0, 1, 2], [2, 3, 0], [0, 1, 2], [0, 1, 2], [0, 2, 3], [0, 3, 4]]

    def test_texture_does_not_split_vertices(self, tmp_path):
        """Texture coordinates at every corner, of one length or not, as scanners and MeshLab write them."""
        head = ply(faces=TRIANGLES).replace(
            b"property list uchar int vertex_indices",
            b"property list uchar int vertex_indices\nproperty list uchar float texcoord",
        )
        head = head[: head.index(b"end_header\n") + 11 + 13 * 8]
        for sizes in ([6] * 12, [6, 0] * 6):
            rows = b"".join(
                struct.pack(f"<BB3iB{size}f", 1, 3, *face, size, *np.arange(index, index + size))
                for index, (face, size) in enumerate(zip(TRIANGLES, sizes, strict=True))
            )
            mesh = read_mesh(write(tmp_path, "texture.ply", head + rows + b"and more"))
            assert np.array_equal(mesh.vertices, POINTS)
            assert mesh.faces.tolist() == [list(face) for face in TRIANGLES]
        data = ply(kind="ascii").replace(b"property uchar red", b"property float s\nproperty float t")
        data = data.replace(b" 7\n", b" 0.5 0.25\n\n", len(POINTS))
        mesh = read_mesh(write(tmp_path, "seam.ply", data))
        assert np.array_equal(mesh.vertices, POINTS)
        assert mesh.faces.tolist() == [list(face) for face in TRIANGLES]

    def test_cut_short(self, tmp_path):
        for cut in (1, 30, 150, 230):
            refuse(write(tmp_path, "cut.ply", ply()[:-cut]), "cut short")
        lines = ply(kind="ascii").splitlines(keepends=True)
        for count in range(9, len(lines)):
            refuse(write(tmp_path, "cut.ply", b"".join(lines[:count])), "cut short")

    @pytest.mark.parametrize("element", ["vertex 8", "face 12"])
    @pytest.mark.parametrize("count", [10**6, 10**9, 10**15, -1])
    def test_header_claims_more_than_the_file_holds(self, tmp_path, element, count):
        data = ply().replace(f"element {element}".encode(), f"element {element.split()[0]} {count}".encode())
        refuse(write(tmp_path, "huge.ply", data))

    @pytest.mark.parametrize("index", [8, -1, 2**31 - 1])
    def test_face_index_out_of_range(self, tmp_path, index):
        for kind in ("ascii", "binary_little_endian"):
            refuse(write(tmp_path, "range.ply", ply(faces=[*TRIANGLES, (0, 1, index)], kind=kind)), "vertex")


class TestStl:
    def test_cut_short(self, tmp_path):
        refuse(write(tmp_path, "cut.stl", stl()[:-1]), "cut short")
        refuse(write(tmp_path, "cut.stl", stl()[:60]), "60 bytes")
        refuse(write(tmp_path, "cut.stl", stl_text()[:-20]), "cut short")
        refuse(write(tmp_path, "cut.stl", stl_text()[:500]), "cut short")

    def test_facets_that_are_no_triangles(self, tmp_path):
        second = b"endfacet\nfacet normal 0 0 0\n outer loop\n"
        first, rest = stl_text().split(b" endloop\n" + second, 1)
        *lines, last = first.splitlines(keepends=True)
        data = b"".join(lines) + b" endloop\n" + second + last + rest  # two vertices, then four
        refuse(write(tmp_path, "moved.stl", data), "12 facets", "damaged")
        refuse(write(tmp_path, "two.stl", stl_text().replace(b"0.0 0.0 0.0", b"0.0 0.0", 1)), "damaged")

    def test_count_beyond_the_file(self, tmp_path):
        data = stl()[:80] + struct.pack("<I", 2**32 - 1) + stl()[84:]
        refuse(write(tmp_path, "huge.stl", data), "4,294,967,295 triangles")

    def test_several_solids(self, tmp_path):
        data = stl_text() + stl_text(POINTS + 10)
        assert volume(read_mesh(write(tmp_path, "two.stl", data))) == pytest.approx(2 * VOLUME)

    def test_any_name(self, tmp_path):
        for name in ("vertex 1 2", "a solid of facets", "Würfel"):
            data = stl_text().replace(b"solid box", f"SOLID {name}".encode("latin-1"))
            assert volume(read_mesh(write(tmp_path, "name.stl", data))) == pytest.approx(VOLUME)

    def test_binary_that_begins_with_solid(self, tmp_path):
        assert len(read_mesh(write(tmp_path, "solid.stl", b"solid" + stl()[5:])).faces) == 12


class TestOff:
    @pytest.mark.parametrize("first", ["COFF", "NOFF", "STCNOFF"])
    def test_vertices_with_colours_and_normals(self, tmp_path, first):
        points = np.column_stack([POINTS, np.full((8, 4), 0.5)])
        data = off(faces=TRIANGLES, first=first).decode().split("\n")
        data[2:10] = [" ".join(map(str, row)) for row in points]
        assert volume(read_mesh(write(tmp_path, "colour.off", "\n".join(data).encode()))) == pytest.approx(
            VOLUME
        )

    def test_counts_behind_the_word(self, tmp_path):
        data = off().replace(b"OFF\n", b"OFF")
        assert len(read_mesh(write(tmp_path, "joined.off", data)).faces) == 12

    def test_damage(self, tmp_path):
        refuse(write(tmp_path, "cut.off", off()[:-10]), "cut short")
        refuse(write(tmp_path, "word.off", b"hello" + off()), "OFF")
        refuse(write(tmp_path, "huge.off", off().replace(b"8 12 0", b"8 1200000 0")), "1,200,000 faces")
        refuse(
            write(tmp_path, "huge.off", off().replace(b"8 12 0", b"8000000000 12 0")),
            "8,000,000,000 vertices",
        )
        refuse(write(tmp_path, "range.off", off(faces=[*TRIANGLES, (0, 1, -2)])), "vert")
        refuse(write(tmp_path, "letter.off", off().replace(b"3.0", b"3\xff0", 1)))
        remark = off().replace(b"OFF", "OFF # Würfel".encode("latin-1"))
        assert len(read_mesh(write(tmp_path, "remark.off", remark)).faces) == 12
        refuse(write(tmp_path, "counts.off", off().replace(b"8 12 0", b"many")), "counts")


class TestGltf:
    def test_nodes_put_meshes_in_place(self, tmp_path):
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

    def test_several_primitives(self, tmp_path):
        tree, _ = gltf_tree()
        primitive = tree["meshes"][0]["primitives"][0]
        mesh = read_mesh(write(tmp_path, "parts.glb", glb(meshes=[{"primitives": [primitive, primitive]}])))
        assert volume(mesh) == pytest.approx(2 * VOLUME)

    def test_without_scene(self, tmp_path):
        tree, data = gltf_tree()
        for key in ("scene", "scenes", "nodes"):
            del tree[key]
        tree["buffers"][0]["uri"] = "data:;base64," + base64.b64encode(data).decode()
        mesh = read_mesh(write(tmp_path, "library.gltf", json.dumps(tree).encode()))
        assert volume(mesh) == pytest.approx(VOLUME)

    def test_buffer_beside_it(self, tmp_path):
        tree, data = gltf_tree(uri="box%20data.bin")
        path = write(tmp_path, "box.gltf", json.dumps(tree).encode())
        refuse(path, "box%20data.bin")
        write(tmp_path, "box data.bin", data)
        assert volume(read_mesh(path)) == pytest.approx(VOLUME)
        write(tmp_path, "box data.bin", data[:-10])
        refuse(path)

    @pytest.mark.parametrize("uri", ["../secret.bin", "http://127.0.0.1/a.bin", "file:///etc/hostname", ""])
    def test_nothing_is_fetched_from_elsewhere(self, tmp_path, uri):
        tree, data = gltf_tree(uri=uri)
        write(tmp_path, "secret.bin", data)
        (tmp_path / "folder").mkdir()
        refuse(write(tmp_path / "folder", "box.gltf", json.dumps(tree).encode()), "beside it")

    def test_missing_textures_do_not_matter(self, tmp_path):
        tree, _ = gltf_tree()
        tree["meshes"][0]["primitives"][0]["material"] = 0
        data = gltf(
            meshes=tree["meshes"],
            materials=[{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}],
            textures=[{"source": 0}],
            images=[{"uri": "nowhere.png"}],
        )
        assert volume(read_mesh(write(tmp_path, "textured.gltf", data))) == pytest.approx(VOLUME)

    def test_what_trimesh_would_misread(self, tmp_path):
        tree, _ = gltf_tree()
        accessors = tree["accessors"]
        primitive = tree["meshes"][0]["primitives"][0]
        for changes, word in [
            ({"extensionsRequired": ["KHR_draco_mesh_compression"]}, "Draco"),
            ({"accessors": [accessors[0] | {"sparse": {}}, accessors[1]]}, "sparse"),
            ({"accessors": [accessors[0] | {"normalized": True}, accessors[1]]}, "quantisation"),
            ({"meshes": [{"primitives": [primitive | {"mode": 6}]}]}, "fans"),
            ({"nodes": [{"mesh": 0, "children": [0]}]}, "two parents"),
            ({"accessors": [accessors[0] | {"count": 10**12}, accessors[1]]}, "1,000,000,000,000 values"),
            ({"accessors": [accessors[0] | {"count": -1}, accessors[1]]}, "accessor 0"),
            ({"asset": {"version": "1.0"}}, "1.0"),
        ]:
            refuse(write(tmp_path, "odd.glb", glb(**changes)), word)
            refuse(write(tmp_path, "odd.gltf", gltf(**changes)), word)

    def test_many_instances_count(self, tmp_path):
        nodes = [{"mesh": 0} for _ in range(100)]
        data = glb(nodes=nodes, scenes=[{"nodes": list(range(100))}])
        refuse(write(tmp_path, "many.glb", data), "1,200 faces", max_faces=1000)


def test_cut_short_anywhere(tmp_path):
    """No beginning of a binary file or of a text with a known end passes for the whole."""
    for name in (
        "box.ply",
        "box_big.ply",
        "box_text.ply",
        "box.stl",
        "box_text.stl",
        "box.glb",
        "box.gltf",
        "box.off",
    ):
        data = FILES[name].rstrip()
        for length in range(0, len(data) - 2, max(len(data) // 40, 1)):
            refuse(write(tmp_path, name, data[:length]))


@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@pytest.mark.parametrize("name", FILES)
@given(data=st.data())
def test_damage_gives_a_mesh_or_a_mesh_error(tmp_path, name, data):
    """Flipped bytes, cut ends, doubled and deleted pieces: nothing but MeshError comes out."""
    content = bytearray(FILES[name])
    position = st.integers(0, len(content) - 1)
    for place, value in data.draw(st.lists(st.tuples(position, st.integers(0, 255)), max_size=4)):
        content[place] = value
    if data.draw(st.booleans()):
        begin, end = sorted((data.draw(position), data.draw(position)))
        piece = bytes(content[begin:end])
        content[begin:end] = data.draw(st.sampled_from([b"", piece * 2, b"-" + piece, b"\0\xff", b"9" * 40]))
    path = write(tmp_path, name, bytes(content))
    try:
        mesh = read_mesh(path)
    except MeshError:
        refuse(path)
    else:
        assert np.isfinite(mesh.vertices).all()
        assert mesh.area > 0


@pytest.mark.parametrize("name", FILES)
def test_too_many_faces(tmp_path, name):
    path = write(tmp_path, name, FILES[name])
    refuse(path, "12 faces", "limit of 11", max_faces=11)
    assert len(read_mesh(path, max_faces=12).faces) == 12


def test_file_beyond_any_mesh_of_that_size(tmp_path):
    path = write(tmp_path, "huge.obj", obj())
    os.truncate(path, 600_000_000)  # a hole, which takes no room
    refuse(path, "600,000,000 bytes", "limit of 12", max_faces=12)


@pytest.mark.parametrize("suffix", sorted(MESH_SUFFIXES))
def test_no_usable_file(tmp_path, suffix):
    refuse(tmp_path / f"missing{suffix}", "does not exist")
    folder = tmp_path / f"folder{suffix}"
    folder.mkdir()
    refuse(folder, "is a folder")
    refuse(write(tmp_path, f"empty{suffix}", b""), "empty")
    refuse(write(tmp_path, f"blank{suffix}", b"\n"))
    refuse(write(tmp_path, f"zeros{suffix}", bytes(3_000_000)))
    refuse(write(tmp_path, f"picture{suffix}", b"\x89PNG\r\n\x1a\n" + bytes(range(256)) * 40))
    refuse(write(tmp_path, f"page{suffix}", b"<!DOCTYPE html>\n<html><body>Not found</body></html>\n"))


@pytest.mark.parametrize("name", ["a.blend", "a.fbx", "a.txt", "a", ".obj", "a.ply.gz"])
def test_unsupported_suffix(tmp_path, name):
    refuse(write(tmp_path, name, obj()), ".obj", "convert")


def test_content_of_another_format(tmp_path):
    for name, data in FILES.items():
        for suffix in MESH_SUFFIXES - {Path(name).suffix}:
            refuse(write(tmp_path, "renamed" + suffix, data))
    refuse(write(tmp_path, "renamed.obj", ply()), "begins like a .ply file")
    refuse(write(tmp_path, "renamed.stl", glb()), "begins like a .glb file")


def writers():
    return {".obj": obj, ".off": off, ".ply": ply, ".stl": stl, ".gltf": gltf, ".glb": glb}.items()


@pytest.mark.parametrize(("suffix", "make"), writers())
def test_no_surface(tmp_path, suffix, make):
    def refuse_shape(points, faces, *words):
        refuse(write(tmp_path, "shape" + suffix, make(np.asarray(points, float), faces)), *words)

    line = np.arange(8)[:, None] * np.array([1.0, 2.0, 3.0])
    refuse_shape(np.ones((8, 3)), TRIANGLES, "coincide")
    refuse_shape(line, TRIANGLES, "no area")
    refuse_shape(POINTS[:3], [(0, 1, 2)], "3 vertices")
    for value in (np.nan, np.inf, -np.inf):
        bad = POINTS.copy()
        bad[2, 1] = value
        refuse_shape(bad, TRIANGLES, "NaN or infinite")
    if suffix not in (".stl",):
        refuse_shape(POINTS, [], "no faces" if suffix in (".obj", ".off", ".ply") else "")
        refuse_shape(POINTS, [*TRIANGLES, (0, 1, 8)], "vert")


@pytest.mark.parametrize(("suffix", "make"), writers())
def test_units_do_not_matter(tmp_path, suffix, make):
    for unit in (1e-6, 1e6):
        mesh = read_mesh(write(tmp_path, "shape" + suffix, make(POINTS * unit, TRIANGLES)))
        assert mesh.area == pytest.approx(AREA * unit**2)


def test_point_cloud(tmp_path):
    for name, data in {"a.obj": obj(faces=[]), "a.ply": ply(faces=[]), "a.off": off(faces=[])}.items():
        path = write(tmp_path, name, data)
        refuse(path, "no faces and 8 points")
        cloud = read_mesh(path, point_cloud=True)
        assert cloud.is_point_cloud
        assert np.array_equal(cloud.vertices, POINTS)
    assert read_mesh(write(tmp_path, "b.obj", obj()), point_cloud=True).is_point_cloud
    refuse(write(tmp_path, "c.obj", obj(np.zeros((9, 3)), [])), "coincide", point_cloud=True)
    refuse(write(tmp_path, "d.obj", obj(POINTS[:3], [])), "3 points", point_cloud=True)


def test_memory_running_out_is_said(tmp_path, monkeypatch):
    def exhausted(file):
        raise MemoryError

    monkeypatch.setitem(read_mesh.__globals__["_READERS"], ".obj", exhausted)
    refuse(write(tmp_path, "a.obj", obj()), "memory")


@pytest.mark.skipif(os.name != "posix" or os.geteuid() == 0, reason="root may read everything")
def test_no_permission(tmp_path):
    path = write(tmp_path, "secret.obj", obj())
    path.chmod(0)
    refuse(path, "permission")


def test_files_of_trimesh(tmp_path):
    """What another program writes is read: trimesh's exporters, every format."""
    ball = trimesh.creation.icosphere(subdivisions=2)
    for kind, options in [
        ("obj", {}),
        ("ply", {}),
        ("ply", {"encoding": "ascii", "vertex_normal": True}),
        ("stl", {}),
        ("stl_ascii", {}),
        ("off", {}),
        ("glb", {}),
    ]:
        data = ball.export(file_type=kind, **options)
        data = data.encode() if isinstance(data, str) else data
        mesh = read_mesh(write(tmp_path, "ball." + kind.removesuffix("_ascii"), data))
        assert len(mesh.faces) == len(ball.faces)
        assert mesh.area == pytest.approx(ball.area, rel=1e-5)


def test_nothing_is_printed(tmp_path, capfd):
    for name, data in FILES.items():
        read_mesh(write(tmp_path, name, data))
        refuse(write(tmp_path, name, data[: len(data) // 2])) if name != "box.obj" else None
    assert capfd.readouterr() == ("", "")
