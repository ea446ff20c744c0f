# SPDX-License-Identifier: MIT
"""Damaged files: small files of all formats, with random changes to bits, lines, numbers and structure."""

from __future__ import annotations

import io
import json
import re
import struct
import zipfile
import zlib
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

from tests.core.mesh.io import mesh_files

__all__ = ["damaged", "seeds"]

Random = np.random.Generator
Change = Callable[[bytes, Random], bytes]

# Larger files of the corpus take too long to try in thousands of versions.
LARGEST_SEED = 20_000
CORPUS = Path(__file__).resolve().parents[3] / "files"

NUMBER = re.compile(rb"-?\d+(?:\.\d+)?(?:[eE][-+]?\d+)?")
NUMBERS = (
    b"-1 0 1 2 -2147483648 2147483647 2147483648 4294967295 99999999999999999999 1e308 -1e308 1e39 1e-320"
)
WORDS = [
    *NUMBERS.split(),
    b"nan",
    b"inf",
    b"-inf",
    b"",
    b"x",
    b"0x1f",
    b"1,5",
    b"1_0",
    b"\xff",
    b"\x00",
    b"'",
    b'"',
]
LINES = [
    *b"v 0 0 0|f 1 2 3 4 5|f -1 -2 -3|f 1/1/1 2//2 3|f 0 0 0|l 1 2|element vertex 4000000000".split(b"|"),
    *b"property list uchar int vertex_indices|property double x|element tristrips 3|end_header".split(b"|"),
    *b"facet normal 0 0 1|vertex 1 2|endsolid|DATA ascii|POINTS 4294967295|FIELDS x y z|SIZE 4 4 8".split(
        b"|"
    ),
    *b"OFF|COFF|4OFF|3 1 0|3 0 1 2|5 0 1 2 3 4|3.0 0 1 2|1,5 2,5 3,5|# a comment|\\|\t|".split(b"|"),
]
VALUES: list[Any] = [
    None,
    True,
    -1,
    0,
    1,
    7,
    2**31,
    2**64,
    1e308,
    0.5,
    "",
    "x",
    "data:,",
    "..",
    [],
    [0],
    [[]],
    {},
    {"x": 0},
]


def seeds() -> dict[str, bytes]:
    """Return small files of all formats that can be read, by their names."""
    rows = mesh_files.POINTS[:, None] + 0.1 * mesh_files.POINTS[None]
    points = rows.reshape(-1, 3)
    found = {
        **mesh_files.FILES,
        "quads.obj": b"mtllib none.mtl\no box\nvt 0 0\nvn 0 0 1\ng one\n"
        + mesh_files.obj(faces=mesh_files.QUADS)
        + b"f -1 -2 -3\nf 1/1/1 2/1/1 3/1/1\nf 4//1 5//1 \\\n6//1\nl 1 2\np 1\n",
        "mixed.off": mesh_files.off(faces=mesh_files.MIXED),
        "mixed.ply": mesh_files.ply(faces=mesh_files.MIXED),
        "mixed_text.ply": mesh_files.ply(faces=mesh_files.MIXED, kind="ascii"),
        "points.xyz": "".join(f"{x:.4f} {y:.4f} {z:.4f} 255 0 0\n" for x, y, z in points).encode(),
        "points.ply": mesh_files.ply(points=points, faces=[]),
        "scene.gltf": mesh_files.gltf(**_SCENE),
        "scene.glb": mesh_files.glb(**_SCENE),
        "part.3mf": _three_mf(),
    }
    found |= {f"{kind}.pcd": _pcd(points, kind) for kind in ("ascii", "binary", "binary_compressed")}
    for path in sorted(CORPUS.rglob("*")) if CORPUS.is_dir() else ():
        if path.is_file() and path.stat().st_size <= LARGEST_SEED:
            found[f"corpus-{path.name}"] = path.read_bytes()
    return found


def damaged(first: int, count: int, suffixes: frozenset[str]) -> Iterator[tuple[str, bytes]]:
    """Make damaged files; each depends on its number alone.

    Parameters
    ----------
    first, count : int
        Numbers of the files.
    suffixes : frozenset of str
        Of the formats that are wanted.

    Yields
    ------
    name : str
    data : bytes
    """
    files = [(name, data) for name, data in seeds().items() if Path(name).suffix.lower() in suffixes]
    by_suffix: dict[str, list[tuple[str, bytes]]] = {}
    for name, data in files:
        by_suffix.setdefault(Path(name).suffix.lower(), []).append((name, data))
    order = sorted(by_suffix)
    for number in range(first, first + count):
        random = np.random.default_rng([25, number])
        suffix = order[number % len(order)]
        name, data = by_suffix[suffix][number // len(order) % len(by_suffix[suffix])]
        changes = _CHANGES_OF.get(suffix, ()) or (_TEXT if _is_text(data) else _BYTES)
        for _ in range(random.choice([1, 1, 1, 2, 3])):
            data = changes[random.integers(len(changes))](data, random)
        yield f"{Path(name).stem}-{number}{Path(name).suffix}", data


def _is_text(data: bytes) -> bool:
    return not data.translate(None, bytes(range(32, 127)) + b"\t\r\n")


def _place(data: bytes, random: Random) -> int:
    """Choose a place; half of them are near the start, where the headers are."""
    return int(random.integers(min(len(data), 200) if random.random() < 0.5 else len(data))) if data else 0


def _flip(data: bytes, random: Random) -> bytes:
    changed = bytearray(data)
    for _ in range(int(2 ** random.integers(5))):
        if changed:
            changed[_place(data, random)] ^= 1 << random.integers(8)
    return bytes(changed)


def _cut(data: bytes, random: Random) -> bytes:
    return data[: _place(data, random)]


def _insert(data: bytes, random: Random) -> bytes:
    place = _place(data, random)
    return data[:place] + random.bytes(int(random.integers(1, 20))) + data[place:]


def _remove(data: bytes, random: Random) -> bytes:
    place = _place(data, random)
    return data[:place] + data[place + random.integers(1, 60) :]


def _repeat(data: bytes, random: Random) -> bytes:
    place = _place(data, random)
    return data[: place + int(random.integers(1, 60))] + data[place:]


def _huge(data: bytes, random: Random) -> bytes:
    """Overwrite four aligned or unaligned bytes with a number that is no sensible count or index."""
    place = _place(data, random)
    value = random.choice([0, 0x7FFFFFFF, 0x80000000, 0xFFFFFFFF, 0x7F800000, 0x7FC00000, 65536])
    return data[:place] + struct.pack("<I", value) + data[place + 4 :]


def _swap(data: bytes, random: Random) -> bytes:
    one, other = sorted((_place(data, random), _place(data, random)))
    size = int(random.integers(1, 16))
    if other < one + size:
        return data
    return (
        data[:one]
        + data[other : other + size]
        + data[one + size : other]
        + data[one : one + size]
        + data[other + size :]
    )


def _lines(data: bytes, random: Random) -> bytes:
    """Remove, repeat, exchange or insert a line, or change the ends of all."""
    lines = data.split(b"\n")
    one, other = (int(random.integers(len(lines))) for _ in range(2))
    kind = random.integers(7)
    if kind == 0:
        del lines[one]
    elif kind == 1:
        lines.insert(other, lines[one])
    elif kind == 2:
        lines[one], lines[other] = lines[other], lines[one]
    elif kind == 3:
        lines.insert(one, LINES[random.integers(len(LINES))])
    elif kind == 4:
        words = lines[one].split()
        random.shuffle(words)
        lines[one] = b" ".join(words[: int(random.integers(len(words) + 1))])
    elif kind == 5:
        lines[one] = lines[one] + b" " + lines[other]
    else:
        return [b"\r", b"\r\n", b" \n", b"\n\n", b";"][random.integers(5)].join(lines)
    return b"\n".join(lines)


def _number(data: bytes, random: Random) -> bytes:
    """Replace a number by one that is none, or by a very large or small one."""
    found = list(NUMBER.finditer(data))
    if not found:
        return data
    chosen = found[random.integers(len(found))]
    return data[: chosen.start()] + WORDS[random.integers(len(WORDS))] + data[chosen.end() :]


def _swap_numbers(data: bytes, random: Random) -> bytes:
    found = list(NUMBER.finditer(data))
    if len(found) < 2:
        return data
    one, other = np.sort(random.choice(len(found), 2, replace=False))
    a, b = found[int(one)], found[int(other)]
    return data[: a.start()] + b.group() + data[a.end() : b.start()] + a.group() + data[b.end() :]


def _encoded(data: bytes, random: Random) -> bytes:
    """Write a text as other programs do: in UTF-16, with a mark, with decimal commas or tabs."""
    text = data.decode("latin-1")
    kind = random.integers(4)
    if kind == 0:
        return text.encode("utf-16")
    if kind == 1:
        return b"\xef\xbb\xbf" + data
    return data.replace(b".", b",") if kind == 2 else data.replace(b" ", b"\t")


_BYTES: tuple[Change, ...] = (_flip, _cut, _insert, _remove, _repeat, _huge, _swap, _number, _lines)
_TEXT: tuple[Change, ...] = (
    _flip,
    _cut,
    _remove,
    _repeat,
    _lines,
    _lines,
    _number,
    _number,
    _swap_numbers,
    _encoded,
)


def _in_tree(tree: Any, random: Random) -> Any:
    """Replace, remove or repeat a random value of a tree of JSON."""
    places: list[tuple[Any, Any]] = []

    def walk(value: Any) -> None:
        keys = value if isinstance(value, dict) else range(len(value)) if isinstance(value, list) else ()
        for key in keys:
            places.append((value, key))
            walk(value[key])

    walk(tree)
    if not places:
        return tree
    owner, key = places[random.integers(len(places))]
    kind = random.integers(4)
    if kind == 0:
        del owner[key]
    elif kind == 1 and isinstance(owner, list):
        owner.append(owner[key])
    elif kind == 2 and isinstance(owner[key], int | float):
        owner[key] = owner[key] * int(random.choice([-1, 2, 1000])) + int(random.integers(3))
    else:
        owner[key] = VALUES[random.integers(len(VALUES))]
    return tree


def _gltf_tree(data: bytes, random: Random) -> bytes:
    try:
        return json.dumps(_in_tree(json.loads(data), random)).encode()
    except ValueError:  # damaged by an earlier change
        return _flip(data, random)


def _glb_tree(data: bytes, random: Random) -> bytes:
    size = struct.unpack_from("<I", data.ljust(20, b"\0"), 12)[0]
    text = _gltf_tree(data[20 : 20 + size], random)
    text += b" " * (-len(text) % 4)
    rest = data[20 + size :]
    head = struct.pack("<4sIIII", b"glTF", 2, 20 + len(text) + len(rest), len(text), 0x4E4F534A)
    return head + text + rest


def _in_archive(data: bytes, random: Random) -> bytes:
    """Damage one of the files of an archive, and pack it again."""
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            files = {name: archive.read(name) for name in archive.namelist()}
    except (zipfile.BadZipFile, NotImplementedError, OSError, ValueError, EOFError, zlib.error):
        return _flip(data, random)
    if not files:
        return data
    name = list(files)[random.integers(len(files))]
    files[name] = _TEXT[random.integers(len(_TEXT))](files[name], random)
    if random.random() < 0.1:
        del files[name]
    return _zipped(files)


def _zipped(files: dict[str, bytes]) -> bytes:
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in files.items():
            archive.writestr(name, content)
    return buffer.getvalue()


_CHANGES_OF: dict[str, tuple[Change, ...]] = {
    ".gltf": (*_TEXT, *[_gltf_tree] * 12),
    ".glb": (*_BYTES, *[_glb_tree] * 12),
    ".3mf": (*_BYTES, *[_in_archive] * 12),
}

_SCENE: dict[str, Any] = {
    "scenes": [{"nodes": [0, 1]}],
    "nodes": [
        {"mesh": 0, "translation": [1, 2, 3], "rotation": [0, 0, 1, 0], "scale": [1, 2, 1]},
        {"children": [2], "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 5, 0, 0, 1]},
        {"mesh": 0, "name": "child", "skin": 0},
        {"name": "joint"},
    ],
    "skins": [{"joints": [3]}],
    "extensionsUsed": ["KHR_lights_punctual"],
}


def _pcd(points: mesh_files.Points, kind: str) -> bytes:
    count = len(points)
    header = (
        "# .PCD v0.7\nVERSION 0.7\nFIELDS x y z rgb\nSIZE 4 4 4 4\nTYPE F F F F\nCOUNT 1 1 1 1\n"
        f"WIDTH {count}\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS {count}\nDATA {kind}\n"
    ).encode()
    table = np.column_stack([points, np.zeros(count)]).astype("<f4")
    if kind == "ascii":
        return header + "".join(f"{x} {y} {z} 0\n" for x, y, z in points).encode()
    if kind == "binary":
        return header + table.tobytes()
    content = table.T.tobytes()
    # Runs of literal bytes alone are a valid compression.
    pieces = [content[start : start + 32] for start in range(0, len(content), 32)]
    packed = b"".join(bytes([len(piece) - 1]) + piece for piece in pieces)
    return header + struct.pack("<II", len(packed), len(content)) + packed


def _three_mf() -> bytes:
    vertices = "".join(f'<vertex x="{x}" y="{y}" z="{z}"/>' for x, y, z in mesh_files.POINTS)
    triangles = "".join(f'<triangle v1="{a}" v2="{b}" v3="{c}"/>' for a, b, c in mesh_files.TRIANGLES)
    model = (
        '<?xml version="1.0" encoding="UTF-8"?>\n'
        '<model unit="millimeter" xmlns="http://schemas.microsoft.com/3dmanufacturing/core/2015/02">\n'
        f'<resources>\n<object id="1" type="model"><mesh>\n<vertices>\n{vertices}\n</vertices>\n'
        f"<triangles>\n{triangles}\n</triangles>\n</mesh></object>\n"
        '<object id="2" type="model"><components>\n<component objectid="1" '
        'transform="1 0 0 0 1 0 0 0 1 5 0 0"/>\n<component objectid="1"/>\n</components></object>\n'
        '</resources>\n<build>\n<item objectid="2"/>\n</build>\n</model>\n'
    )
    types = (
        '<?xml version="1.0"?>\n<Types xmlns="http://schemas.openxmlformats.org/package/2006/content-types">\n'
        '<Default Extension="model" ContentType="application/vnd.ms-package.3dmanufacturing-3dmodel+xml"/>\n'
        '<Default Extension="rels" ContentType="application/vnd.openxmlformats-package.relationships+xml"/>\n'
        "</Types>\n"
    )
    relations = (
        '<?xml version="1.0"?>\n'
        '<Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships">\n'
        '<Relationship Target="/3D/3dmodel.model" Id="rel0" '
        'Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/>\n</Relationships>\n'
    )
    files = {"[Content_Types].xml": types, "_rels/.rels": relations, "3D/3dmodel.model": model}
    return _zipped({name: text.encode() for name, text in files.items()})
