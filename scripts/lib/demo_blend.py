# SPDX-License-Identifier: MIT
"""What the demo does in Blender: index and search an asset library with the add-on, and render the answer.

Needs the `bpy` module; `demo_in_blender.py` runs it.
"""

from __future__ import annotations

import hashlib
import json
import os
import sys
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from pathlib import Path
from types import ModuleType
from typing import Any

import bpy
from PIL import Image
from PIL.PngImagePlugin import PngInfo

from benchmarks.blender import enable_addon
from benchmarks.creatures import blend_library, make_creature, rigs
from benchmarks.figures import workbench
from benchmarks.figures.contact_sheet import contact_sheet

__all__ = ["run"]

QUERY_NAME = "Rearing Horse"
QUERY_KIND, QUERY_INDIVIDUAL, QUERY_POSE = "horse", 2011, "rear"
QUERY_VERTICES, QUERY_SCALE = 4200, 2.5
MATCHES, COLUMNS = 9, 5
TILE = (280, 272)
QUERY_FLOOR, MATCH_FLOOR = (1.0, 0.94, 0.82), (0.965, 0.965, 0.975)
TITLE = "A query and its best matches in a library of .blend files, coloured by geometric word"


STAMP_KEY = "made-from"


@dataclass(frozen=True)
class Found:
    """A line of the answer."""

    name: str
    source: str
    similarity: float
    size: float
    kind: str


@contextmanager
def quiet() -> Iterator[None]:
    """Keep what Blender and its graphics driver print, from C, for every file and picture off the terminal.

    What goes wrong is raised as an exception and loses nothing by it.
    """
    sys.stdout.flush()
    sys.stderr.flush()
    terminal = [os.dup(stream) for stream in (1, 2)]
    nowhere = os.open(os.devnull, os.O_WRONLY)
    try:
        os.dup2(nowhere, 1)
        os.dup2(nowhere, 2)
        yield
    finally:
        sys.stdout.flush()
        sys.stderr.flush()
        for stream, original in zip((1, 2), terminal, strict=True):
            os.dup2(original, stream)
            os.close(original)
        os.close(nowhere)


def write_library(folder: Path) -> None:
    """Make the asset library, as far as it is not there."""
    started = time.monotonic()
    with quiet():
        written = blend_library.write_library(folder)
    shapes = sum(len(individual.figures) for individual in blend_library.INDIVIDUALS)
    files = len(blend_library.INDIVIDUALS)
    print(
        f"{files} .blend files with {shapes} posed rigs: {len(written)} written "
        f"in {time.monotonic() - started:.1f} s",
        flush=True,
    )


def add_query() -> Any:
    """Put into the scene what to search for: in a pose the library lacks, meshed anew and larger."""
    creature = make_creature(QUERY_KIND, QUERY_INDIVIDUAL, vertex_count=QUERY_VERTICES)
    collection = bpy.context.scene.collection
    (skin,) = rigs.add_creature(creature, QUERY_NAME, [QUERY_POSE], collection)
    skin.name = QUERY_NAME
    skin.parent.scale = (QUERY_SCALE,) * 3
    bpy.context.view_layer.update()
    return skin


def flat_copy(item: Any, name: str) -> Any:
    """Copy an object as it is seen: what its words are computed on is its posed mesh, not the rest pose."""
    evaluated = item.evaluated_get(bpy.context.evaluated_depsgraph_get())
    data = bpy.data.meshes.new_from_object(evaluated)
    copy = bpy.data.objects.new(name, data)
    copy.matrix_world = evaluated.matrix_world
    bpy.context.scene.collection.objects.link(copy)
    return copy


def index_library(addon: ModuleType, folder: Path, library: Path) -> None:
    """Let the add-on bring a library up to date with the .blend files."""
    started = time.monotonic()
    # Whatever asset libraries there are on this machine are none of the demo's; nothing of this is saved.
    bpy.context.preferences.addons[addon.__name__].preferences.use_asset_libraries = False
    with quiet():
        bpy.ops.shape_google.choose_library(filepath=str(library))
        bpy.ops.shape_google.add_folder(directory=str(folder))
        bpy.ops.shape_google.index_library()
    session = bpy.context.window_manager.shape_google
    if session.errors:
        sys.exit("\n".join(f"{error.path}: {error.reason}" for error in session.errors))
    print(f"Index Library: {session.summary}, in {time.monotonic() - started:.1f} s", flush=True)


def find_similar(item: Any) -> list[Found]:
    """Let the add-on search with an object."""
    session = bpy.context.window_manager.shape_google
    session.top = MATCHES
    session.collapse = False  # the picture shows all poses of the same horse
    select_only([item])
    with quiet():
        bpy.ops.shape_google.find_similar()
    return [
        Found(match.object_name, match.source, match.similarity, match.size, match.evidence.capitalize())
        for match in session.matches
    ]


def select_only(items: Sequence[Any]) -> None:
    """Select objects, the first one as the active one, and nothing else."""
    bpy.ops.object.select_all(action="DESELECT")
    for item in items:
        item.select_set(True)
    bpy.context.view_layer.objects.active = items[0]


def print_matches(query: Any, matches: Sequence[Found]) -> None:
    """Print the answer."""
    print(f"Find Similar: the best {len(matches)} for {query.name!r}")
    print("   similarity  name              size     kind        source")
    for rank, match in enumerate(matches, start=1):
        size = f"×{match.size:.2g}"
        columns = f"{match.similarity:10.3f}  {match.name:<16}  {size:<7}  {match.kind:<10}"
        print(f"{rank:<3}{columns}  {match.source}", flush=True)


def load_objects(matches: Sequence[Found]) -> list[Any]:
    """Bring the matches' objects into the scene, with the armatures they follow."""
    items = []
    for match in matches:
        with bpy.data.libraries.load(match.source) as (_, wanted):
            wanted.objects = [match.name]
        (item,) = wanted.objects
        for part in (item, item.parent):
            bpy.context.scene.collection.objects.link(part)
        items.append(item)
    bpy.context.view_layer.update()
    return items


def paint_words(items: Sequence[Any]) -> None:
    """Paint objects with the add-on, each vertex in the colour of its word."""
    select_only(items)
    bpy.context.scene.shape_google_painting.kind = "WORDS"
    with quiet():
        bpy.ops.shape_google.paint()


def write_picture(query: Any, matches: Sequence[Found], path: Path, stamp: str) -> None:
    """Render the query and its matches, each in the colours of its words; note in the file what it shows."""
    items = [query, *load_objects(matches)]
    copies = [flat_copy(item, f"{item.name} in word colours") for item in items]
    paint_words(copies)
    workbench.set_up_studio(bpy.context.scene)
    with quiet():
        images = [
            workbench.photograph(copy, TILE, MATCH_FLOOR if number else QUERY_FLOOR)
            for number, copy in enumerate(copies)
        ]
    sizes = [f"{len(copy.data.vertices):,} vertices, {max(copy.dimensions):.2g} m" for copy in copies]
    captions = [f"Query: {query.name}\nnot in the library, {sizes[0]}"]
    captions += [
        f"{rank}. {match.name}, similarity {match.similarity:.2f}\n{Path(match.source).name}, {size}"
        for rank, (match, size) in enumerate(zip(matches, sizes[1:], strict=True), start=1)
    ]
    sheet = contact_sheet(images, captions, COLUMNS, TITLE)
    notes = PngInfo()
    notes.add_text(STAMP_KEY, stamp)
    sheet.save(path, optimize=True, pnginfo=notes)


def update_picture(query: Any, matches: Sequence[Found], path: Path) -> None:
    """Write the picture, unless it is there and would come out the same."""
    missing = workbench.missing_library()
    if missing:
        print(f"No picture by Blender: Workbench needs {missing}; on Debian and Ubuntu: apt install libegl1")
        return
    stamp = picture_stamp(matches)
    if not path.is_file() or Image.open(path).info.get(STAMP_KEY) != stamp:
        started = time.monotonic()
        write_picture(query, matches, path, stamp)
        print(f"Words computed and picture rendered in {time.monotonic() - started:.1f} s", flush=True)


def picture_stamp(matches: Sequence[Found]) -> str:
    """Hash of all that the picture follows from."""
    content = [TITLE, QUERY_KIND, QUERY_INDIVIDUAL, QUERY_POSE, QUERY_VERTICES, QUERY_SCALE, TILE]
    digest = hashlib.sha256(json.dumps([content, [asdict(match) for match in matches]]).encode())
    for source in {match.source for match in matches}:
        digest.update(Path(source).read_bytes())
    for module in (rigs, workbench, sys.modules[__name__]):
        digest.update(Path(module.__file__ or "").read_bytes())
    return digest.hexdigest()


def run(folder: Path, library: Path, picture: Path) -> None:
    """Do the whole of it, as far as it is not done yet.

    Parameters
    ----------
    folder : Path
        For the .blend files.
    library : Path
        For what the search needs of them.
    picture : Path
        For the picture of the answer.
    """
    write_library(folder)
    blend_library.start_empty()
    addon = enable_addon()
    index_library(addon, folder, library)
    query = add_query()
    matches = find_similar(query)
    print_matches(query, matches)
    update_picture(query, matches, picture)
