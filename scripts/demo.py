# SPDX-License-Identifier: MIT
"""Show the whole search once, on shapes made for it: set up, make creatures, index them, find one again.

    python3 scripts/demo.py

First with mesh files and the command, then, where Blender's bpy module can be had, with .blend files and the
add-on. Everything it makes stands in the folder `demo`. Run again, it only does what has changed.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import time
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from lib import bootstrap

if TYPE_CHECKING:
    from PIL import Image

    from shapegoogle_core import Mesh, ShapeModel

__all__ = ["main"]

FOLDER = bootstrap.ROOT / "demo"
MESHES = FOLDER / "creatures"
LIBRARY = FOLDER / "creatures.sglib"
BLENDS = FOLDER / "blend_library"
BLEND_LIBRARY = FOLDER / "blend_library.sglib"
PICTURE = FOLDER / "matches.png"

BLENDER_PART = "lib.demo_in_blender"
BLENDER_SERIES = ("4.5", "5.2")  # one for each Python that Blenders ship; the first that can be had is taken

KINDS = (
    "human",
    "ape",
    "horse",
    "dog",
    "deer",
    "elephant",
    "bird",
    "dinosaur",
    "octopus",
    "spider",
    "hand",
    "desk lamp",
)
INDIVIDUAL = 2011  # the default model was trained on others
POSES_EACH = 4
SUFFIXES = (".ply", ".obj", ".glb")
QUERY = FOLDER / "query" / "horse-rear.ply"
QUERY_KIND, QUERY_POSE, QUERY_VERTICES, QUERY_SCALE = "horse", "rear", 4200, 2.5
MATCHES = 9
COLUMNS = 5


def library_meshes() -> Iterator[tuple[str, Mesh]]:
    """Yield the shapes to search among, with the names of their files."""
    from benchmarks.creatures import make_creature

    for kind in KINDS:
        creature = make_creature(kind, INDIVIDUAL)
        for number, pose in enumerate(creature.pose_names[:POSES_EACH]):
            name = f"{kind}-{pose}".replace(" ", "_")
            yield name + SUFFIXES[number % len(SUFFIXES)], creature.pose(pose)


def query_mesh() -> Mesh:
    """Make what to search for: in a pose the library lacks, meshed anew and larger."""
    from benchmarks.creatures import make_creature
    from shapegoogle_core import Mesh

    creature = make_creature(QUERY_KIND, INDIVIDUAL, vertex_count=QUERY_VERTICES)
    if QUERY_POSE in creature.pose_names[:POSES_EACH]:
        raise ValueError(f"the pose {QUERY_POSE!r} is in the library already")
    mesh = creature.pose(QUERY_POSE)
    return Mesh(QUERY_SCALE * mesh.vertices, mesh.faces, QUERY.name)


def forget_other_model(path: Path) -> None:
    """Remove a library of the demo's own if an earlier version's model made it: none can search it now."""
    from shapegoogle_core import Library, load_model

    if path.exists():
        with Library.open(path, read_only=True) as library:
            outdated = library.model.identifier != load_model().identifier
        if outdated:
            path.unlink()


def write_mesh(path: Path, mesh: Mesh) -> None:
    """Write a mesh file, unless it is there with the same content: then it keeps its time."""
    import trimesh

    content = trimesh.Trimesh(mesh.vertices, mesh.faces, process=False).export(file_type=path.suffix[1:])
    data = content.encode() if isinstance(content, str) else bytes(content)
    if not path.is_file() or path.read_bytes() != data:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(data)


def run_command(*arguments: str | Path) -> None:
    """Run `shapegoogle` as a user would, and show the command line."""
    command = [Path(sys.executable).with_name("shapegoogle"), *arguments]
    words = [str(word.relative_to(bootstrap.ROOT) if isinstance(word, Path) else word) for word in command]
    print(f"\n$ {' '.join(words)}", flush=True)
    # Same words, same folder: what is shown is what runs.
    code = subprocess.run([str(command[0]), *words[1:]], cwd=bootstrap.ROOT, check=False).returncode
    if code != 0:
        sys.exit(f"The command above ended with exit code {code}")


def draw_words(model: ShapeModel, mesh: Mesh) -> Image.Image:
    """Draw a shape with its geometric words: each vertex in the colour of its likeliest word."""
    from shapegoogle_core import vertex_words
    from shapegoogle_core.rendering import look_from, render, word_palette

    words = vertex_words(model, mesh)
    colors = word_palette(words.words.shape[1])[words.heaviest]
    # Creatures stand on the xy plane and look along -y.
    return render(mesh, colors, size=(240, 240), view=look_from((1, -1.2, 0.5), up=(0, 0, 1)))


def write_picture() -> None:
    """Draw the query and its best matches; the same search as the command's, from Python."""
    from benchmarks.figures.contact_sheet import contact_sheet
    from shapegoogle_core import Library, read_mesh

    with Library.open(LIBRARY, read_only=True) as library:
        query = read_mesh(QUERY)
        matches = library.query(query, top=MATCHES)
        images = [draw_words(library.model, query)]
        images += [draw_words(library.model, read_mesh(match.source)) for match in matches]
    captions = [f"Query: {query.name}"]
    captions += [
        f"{rank}. {Path(match.source).name}\nsimilarity {match.similarity:.2f}"
        for rank, match in enumerate(matches, start=1)
    ]
    sheet = contact_sheet(
        images, captions, COLUMNS, "A query and its best matches, coloured by geometric word"
    )
    sheet.save(PICTURE)


def blender_python() -> Path | None:
    """Python that has the bpy module; None, after a sentence with the reason, if there is none here."""
    reasons = []
    for series in BLENDER_SERIES:
        session = f"addon-{series}"
        try:
            bootstrap.run(
                f"Preparing Blender {series} as a Python module",
                bootstrap.nox("--session", session, "--install-only", "--error-on-missing-interpreters"),
            )
        except bootstrap.SetupError as error:
            reasons.append(str(error))
        else:
            return bootstrap.python_of(bootstrap.ROOT / ".nox" / session.replace(".", "-"))
    print(f"The part in Blender is left out, since it needs bpy: {'; '.join(reasons)}", flush=True)
    return None


def run_in_blender(python: Path) -> None:
    """Do the same in Blender, with the add-on."""
    print("\nThe same in Blender, with .blend files and the add-on:", flush=True)
    command = [str(python), "-m", BLENDER_PART, *map(str, (BLENDS, BLEND_LIBRARY, PICTURE))]
    path = os.pathsep.join([str(bootstrap.ROOT), str(Path(__file__).parent)])
    code = subprocess.run(command, env={**os.environ, "PYTHONPATH": path}, check=False).returncode
    if code != 0:
        sys.exit(f"The part in Blender ended with exit code {code}")


def main(arguments: Sequence[str] | None = None) -> int:
    argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0]).parse_args(arguments)
    bootstrap.enter(["demo"])
    python = blender_python()
    # For matrices as small as these, threads cost more than they bring. Read when numpy is imported.
    os.environ.setdefault("OMP_NUM_THREADS", "1")

    started = time.monotonic()
    print(f"Making {len(KINDS)} creatures in {POSES_EACH} poses each ...", flush=True)
    for name, mesh in library_meshes():
        write_mesh(MESHES / name, mesh)
    write_mesh(QUERY, query_mesh())
    forget_other_model(LIBRARY)
    run_command("index", MESHES, "--library", LIBRARY)
    run_command("query", QUERY, "--library", LIBRARY, "--top", str(MATCHES))
    if python is None:
        write_picture()
    else:
        forget_other_model(BLEND_LIBRARY)
        run_in_blender(python)
    print(f"\nPicture of the query and its matches: {PICTURE}")
    print(f"Done in {time.monotonic() - started:.0f} s")
    return 0


if __name__ == "__main__":
    sys.exit(main())
