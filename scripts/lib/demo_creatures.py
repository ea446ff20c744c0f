# SPDX-License-Identifier: MIT
"""Creatures as mesh files, the library of them, and running the command: what the parts of the demo share."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from lib import bootstrap

if TYPE_CHECKING:
    from shapegoogle_core import Mesh

__all__ = [
    "FOLDER",
    "INDIVIDUAL",
    "KINDS",
    "LIBRARY",
    "MESHES",
    "POSES_EACH",
    "forget_other_model",
    "library_meshes",
    "run_command",
    "write_library_meshes",
    "write_mesh",
]

FOLDER = bootstrap.ROOT / "demo"
MESHES = FOLDER / "creatures"
LIBRARY = FOLDER / "creatures.sglib"

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


def library_meshes() -> Iterator[tuple[str, Mesh]]:
    """Yield the shapes to search among, with the names of their files."""
    from benchmarks.creatures import make_creature

    for kind in KINDS:
        creature = make_creature(kind, INDIVIDUAL)
        for number, pose in enumerate(creature.pose_names[:POSES_EACH]):
            name = f"{kind}-{pose}".replace(" ", "_")
            yield name + SUFFIXES[number % len(SUFFIXES)], creature.pose(pose)


def write_library_meshes() -> None:
    """Write the files to search among, unless they are there."""
    print(f"Making {len(KINDS)} creatures in {POSES_EACH} poses each ...", flush=True)
    for name, mesh in library_meshes():
        write_mesh(MESHES / name, mesh)


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
    words = [_shown(word) for word in command]
    print(f"\n$ {' '.join(words)}", flush=True)
    # Same words, same folder: what is shown is what runs.
    code = subprocess.run([str(command[0]), *words[1:]], cwd=bootstrap.ROOT, check=False).returncode
    if code != 0:
        sys.exit(f"The command above ended with exit code {code}")


def _shown(word: str | Path) -> str:
    if isinstance(word, Path) and word.is_relative_to(bootstrap.ROOT):
        word = word.relative_to(bootstrap.ROOT)
    return str(word)
