# SPDX-License-Identifier: MIT
"""A small asset library of .blend files with posed, rigged creatures, as an artist might keep one.

Needs the `bpy` module. One file is one individual in several poses: meshes with Armature modifiers, vertex
groups, materials, each mesh object marked as an asset in a catalog. Some are made at another scale, some are
subdivided or decimated.
"""

from __future__ import annotations

import colorsys
import hashlib
import json
import uuid
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import bpy
import numpy as np

from benchmarks import creatures
from benchmarks.creatures import Creature, make_creature, rigs

__all__ = [
    "CATALOG_FILE",
    "INDIVIDUALS",
    "Figure",
    "Individual",
    "catalog_id",
    "start_empty",
    "write_library",
]

CATALOG_FILE = "blender_assets.cats.txt"
STAMP_FILE = ".made-from.json"

# Any fixed namespace would do: it only has to give the same identifiers every time.
_NAMESPACE = uuid.uuid5(uuid.NAMESPACE_URL, "shape-google/demo-library")
_GAP = 0.25  # between neighbours in a file, as a share of the width of both


@dataclass(frozen=True)
class Figure:
    """A pose that an individual takes in its file.

    Parameters
    ----------
    pose : str
        One of the creature's `pose_names`.
    scale : float
        Of the object; a creature is about 1 to 3 units long without.
    modifier : str
        On top of the Armature: "SUBSURF", "DECIMATE" or none.
    """

    pose: str
    scale: float = 1.0
    modifier: str = ""


@dataclass(frozen=True)
class Individual:
    """Contents of one .blend file.

    Parameters
    ----------
    folder : str
        In the library; also the catalog above the individual's own.
    name : str
        Of the file and the objects.
    kind : str
        One of `CREATURE_KINDS`.
    seed : int
        Which individual of the kind.
    figures : sequence of Figure
    """

    folder: str
    name: str
    kind: str
    seed: int
    figures: Sequence[Figure]

    @property
    def catalog(self) -> str:
        """Path of its catalog, such as "Animals/Horse"."""
        return f"{self.folder.title()}/{self.name}"

    @property
    def path(self) -> str:
        """Path of its file inside the library."""
        return f"{self.folder}/{self.name.lower().replace(' ', '_')}.blend"


# The default model was trained on other individuals.
INDIVIDUALS = (
    Individual(
        "animals",
        "Horse",
        "horse",
        2011,
        (
            Figure("rest"),
            Figure("walk", modifier="DECIMATE"),
            Figure("gallop", modifier="SUBSURF"),
            Figure("gather"),
            Figure("graze", scale=0.01),
            Figure("look back"),
        ),
    ),
    Individual("animals", "Stallion", "horse", 1972, (Figure("rest"), Figure("gallop"), Figure("kick"))),
    Individual("animals", "Dog", "dog", 2011, (Figure("rest"), Figure("walk"), Figure("sit", scale=0.3))),
    Individual("animals", "Deer", "deer", 2011, (Figure("walk"), Figure("look back"), Figure("gather"))),
    Individual("animals", "Elephant", "elephant", 2011, (Figure("rest", 100), Figure("trumpet", 100))),
    Individual("animals", "Giraffe", "giraffe", 2011, (Figure("rest", 2), Figure("walk", 2))),
    Individual("birds", "Bird", "bird", 2011, (Figure("glide", 0.3), Figure("wings up", 0.3))),
    Individual("birds", "Ostrich", "ostrich", 2011, (Figure("rest"), Figure("run"))),
    Individual(
        "people",
        "Dancer",
        "human",
        2011,
        (Figure("stand"), Figure("walk"), Figure("stretch", modifier="SUBSURF"), Figure("kick")),
    ),
    Individual("people", "Clerk", "human", 1972, (Figure("stand"), Figure("sit"), Figure("bow"))),
    Individual("people", "Ape", "ape", 2011, (Figure("crouch"), Figure("walk"))),
    Individual("monsters", "Dinosaur", "dinosaur", 2011, (Figure("stride", 5), Figure("roar", 5))),
    Individual(
        "monsters", "Octopus", "octopus", 2011, (Figure("sprawl"), Figure("reach up", modifier="DECIMATE"))
    ),
    Individual("monsters", "Spider", "spider", 2011, (Figure("step", 0.05), Figure("threaten", 0.05))),
    Individual("props", "Hand", "hand", 2011, (Figure("relax", 0.2), Figure("victory", 0.2))),
    Individual("props", "Desk Lamp", "desk lamp", 2011, (Figure("low", 0.5), Figure("high", 0.5))),
)


def catalog_id(path: str) -> str:
    """Return the identifier of a catalog: the same for the same path in every library made here.

    Parameters
    ----------
    path : str
        Such as "Animals/Horse".

    Returns
    -------
    identifier : str
        A UUID.
    """
    return str(uuid.uuid5(_NAMESPACE, path))


def start_empty() -> None:
    """Open an empty file; what is open now is lost, preferences and add-ons stay."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True, load_ui=False)


def write_library(folder: Path, individuals: Sequence[Individual] = INDIVIDUALS) -> list[Path]:
    """Write those .blend files that are not there yet, or would come out different now, and the catalogs.

    Parameters
    ----------
    folder : Path
        Of the library; created if it does not exist. Files of other names in it stay.
    individuals : sequence of Individual

    Returns
    -------
    written : list of Path
        The files that were written; all others are as they were, to the byte. Where it is not empty, the
        open file is another one now.
    """
    folder.mkdir(parents=True, exist_ok=True)
    stamps = _read_stamps(folder)
    written = []
    for individual in individuals:
        path = folder / individual.path
        stamp = _stamp(individual)
        if stamps.get(individual.path) == stamp and path.is_file():
            continue
        path.parent.mkdir(exist_ok=True)
        _write_file(path, individual)
        stamps[individual.path] = stamp
        (folder / STAMP_FILE).write_text(json.dumps(stamps, indent=1) + "\n", encoding="utf-8")
        written.append(path)
    if written:
        _write_catalogs(folder / CATALOG_FILE, individuals)
    return written


def _read_stamps(folder: Path) -> dict[str, str]:
    """Read what the files were made from; nothing if that is not there or was cut short."""
    try:
        stamps = json.loads((folder / STAMP_FILE).read_text(encoding="utf-8"))
    except (FileNotFoundError, ValueError):
        return {}
    return stamps if isinstance(stamps, dict) else {}


def _stamp(individual: Individual) -> str:
    """Hash of all that a file follows from: Blender never saves the same bytes twice."""
    digest = hashlib.sha256(json.dumps([asdict(individual), bpy.app.version[:2]]).encode())
    sources = [*Path(creatures.__file__).parent.rglob("*.py"), Path(__file__)]
    for source in sorted(sources):
        digest.update(source.read_bytes())
    return digest.hexdigest()


def _write_catalogs(path: Path, individuals: Sequence[Individual]) -> None:
    lines = ["# This is an Asset Catalog Definition file for Blender.", "", "VERSION 1", ""]
    for catalog in sorted({individual.catalog for individual in individuals}):
        lines.append(f"{catalog_id(catalog)}:{catalog}:{catalog.replace('/', '-')}")
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


def _write_file(path: Path, individual: Individual) -> None:
    start_empty()
    creature = make_creature(individual.kind, individual.seed)
    collection = bpy.data.collections.new(individual.name)
    bpy.context.scene.collection.children.link(collection)
    poses = [figure.pose for figure in individual.figures]
    skins = rigs.add_creature(creature, individual.name, poses, collection)
    skins[0].data.materials.append(_material(individual))
    edge = 0.0
    for skin, figure in zip(skins, individual.figures, strict=True):
        edge = _stand(skin.parent, creature, figure, edge)
        _add_modifier(skin, figure.modifier)
        skin.asset_mark()
        skin.asset_data.catalog_id = catalog_id(individual.catalog)
        skin.asset_data.description = f"{individual.name} ({individual.kind}), {figure.pose}"
        for tag in (individual.kind, figure.pose):
            skin.asset_data.tags.new(tag)
    path.unlink(missing_ok=True)  # or Blender would keep the old one as a second file
    bpy.ops.wm.save_as_mainfile(filepath=str(path), compress=True, check_existing=False)


def _material(individual: Individual) -> Any:
    """Make a material in a colour of the individual's own."""
    shade = int.from_bytes(hashlib.sha256(individual.name.encode()).digest()[:2], "big") / 2**16
    color = (*colorsys.hsv_to_rgb(shade, 0.45, 0.7), 1.0)
    material = bpy.data.materials.new(individual.name)
    material.diffuse_color = color
    material.roughness = 0.6
    if bpy.app.version < (5, 0):  # since then there are always nodes
        material.use_nodes = True
    material.node_tree.nodes["Principled BSDF"].inputs["Base Color"].default_value = color
    return material


def _stand(rig: Any, creature: Creature, figure: Figure, edge: float) -> float:
    """Put a figure on the floor to the right of `edge`; return the edge for the next one, in metres."""
    vertices = figure.scale * creature.pose(figure.pose).vertices
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    margin = _GAP * (high[0] - low[0])
    rig.scale = np.full(3, figure.scale)
    rig.location = (edge + margin - low[0], 0, -low[2])
    return float(edge + 2 * margin + high[0] - low[0])


def _add_modifier(skin: Any, kind: str) -> None:
    if kind == "SUBSURF":
        modifier = skin.modifiers.new("Subdivision", kind)
        modifier.levels = modifier.render_levels = 1
    elif kind == "DECIMATE":
        skin.modifiers.new("Decimate", kind).ratio = 0.4
    elif kind:
        raise ValueError(f"no modifier {kind!r} is made here; there are SUBSURF and DECIMATE")
