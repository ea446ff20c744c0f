# SPDX-License-Identifier: MIT
"""Show the whole search once, on shapes made for it: set up, make creatures, index them, find one again.

    python3 scripts/demo.py
    python3 scripts/demo.py --studio [--check]

First with mesh files and the command, then, where Blender's bpy module can be had, with .blend files and the
add-on. Everything it makes stands in the folder `demo`. Run again, it only does what has changed.

With --studio instead what a studio runs, all on this machine: a PostgreSQL database, a cluster of two workers
that fills it, and the service with its web page, whose address is printed; Ctrl-C stops everything. --check
asks the file, the database and the service the same twelve queries, indexes again, compares, and stops.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import time
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from lib import bootstrap
from lib.demo_creatures import (
    FOLDER,
    INDIVIDUAL,
    LIBRARY,
    MESHES,
    POSES_EACH,
    forget_other_model,
    run_command,
    write_library_meshes,
    write_mesh,
)

if TYPE_CHECKING:
    from PIL import Image

    from shapegoogle_core import Mesh, ShapeModel

__all__ = ["main"]

BLENDS = FOLDER / "blend_library"
BLEND_LIBRARY = FOLDER / "blend_library.sglib"
PICTURE = FOLDER / "matches.png"

STUDIO_EXTRAS = ("postgresql", "cluster", "serve", "server")
BLENDER_PART = "lib.demo_in_blender"
BLENDER_SERIES = ("4.5", "5.2")  # one for each Python that Blenders ship; the first that can be had is taken

QUERY = FOLDER / "query" / "horse-rear.ply"
QUERY_KIND, QUERY_POSE, QUERY_VERTICES, QUERY_SCALE = "horse", "rear", 4200, 2.5
MATCHES = 9
COLUMNS = 5


def query_mesh() -> Mesh:
    """Make what to search for: in a pose the library lacks, meshed anew and larger."""
    from benchmarks.creatures import make_creature
    from shapegoogle_core import Mesh

    creature = make_creature(QUERY_KIND, INDIVIDUAL, vertex_count=QUERY_VERTICES)
    if QUERY_POSE in creature.pose_names[:POSES_EACH]:
        raise ValueError(f"the pose {QUERY_POSE!r} is in the library already")
    mesh = creature.pose(QUERY_POSE)
    return Mesh(QUERY_SCALE * mesh.vertices, mesh.faces, QUERY.name)


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
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument(
        "--studio", action="store_true", help="show a database, a cluster, and the service with its web page"
    )
    parser.add_argument(
        "--check",
        action="store_true",
        help="with --studio: compare the answers of file, database and service, and stop",
    )
    options = parser.parse_args(arguments)
    if options.check and not options.studio:
        parser.error("--check belongs to --studio; write: demo.py --studio --check")
    bootstrap.enter(["demo", *(STUDIO_EXTRAS if options.studio else ())])
    # For matrices as small as these, threads cost more than they bring. Read when numpy is imported.
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    if options.studio:
        from lib import demo_studio

        return demo_studio.run(check=options.check)
    python = blender_python()

    started = time.monotonic()
    write_library_meshes()
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
