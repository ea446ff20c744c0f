# SPDX-License-Identifier: MIT
"""A small library with every sort of object that an artist's files have, and what each must give."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import bpy

__all__ = ["EXPECTED", "LEFT_OUT", "Expected", "make_library"]

CATALOG = "3f4bd4d3-2f6c-4a4e-9f0e-2b1f6d5f8a11"


@dataclass(frozen=True)
class Expected:
    """What an entry must be.

    Parameters
    ----------
    shape_type, name, object_name : str
    placements : tuple of str
        Names of the objects that show it, once for each time.
    tags : tuple of str
    catalog : str
    """

    shape_type: str
    name: str
    object_name: str
    placements: tuple[str, ...]
    tags: tuple[str, ...] = ()
    catalog: str = ""


EXPECTED = (
    # An object of an instanced collection, which nothing else shows: as often as it is seen.
    Expected("object", "Seat", "Seat", ("Seat",) * (3 + 4)),
    Expected("object", "Backrest", "Backrest", ("Backrest",) * (3 + 4)),
    # Three objects that show the collection, and four times by geometry nodes.
    Expected("instance", "Chair A", "Chair A", ("Chair A", "Chair B", "Chair C", *("Row",) * 4)),
    # Collections that are assets: of several objects, and of one, which is no shape besides it.
    Expected("collection", "Lamp", "Lamp", ("Lamp", "Lamp 2"), ("light",), "Props/Lamps"),
    Expected("object", "Lamp (Cylinder)", "Cylinder", ("Cylinder", "Cylinder")),
    Expected("object", "Shade", "Shade", ("Shade", "Shade")),
    Expected("collection", "Vase", "Vase", ("Vase", "Vase 2"), ("pot",)),
    # What geometry nodes instance, realised or not, and the scatter as a whole.
    Expected("object", "Tree", "Tree", ("Tree", *("Tree",) * 4, *("Tree",) * 9)),
    Expected("object", "Forest", "Forest", ("Forest",)),
    Expected("scatter", "Forest", "Forest", ("Forest",)),
    Expected("scatter", "Wood", "Wood", ("Wood",)),
    Expected("object", "Bricks", "Bricks", ("Bricks",) * 4),
    Expected("scatter", "Bricks", "Bricks", ("Bricks",)),
    Expected("scatter", "Row", "Row", ("Row",)),
    # Particles and vertices.
    Expected("object", "Grass", "Grass", ("Grass", *("Grass",) * 5)),
    Expected("object", "Meadow", "Meadow", ("Meadow",)),
    Expected("scatter", "Meadow", "Meadow", ("Meadow",)),
    Expected("object", "Post", "Post", ("Post", *("Post",) * 4)),
    Expected("object", "Fence", "Fence", ("Fence",)),
    Expected("scatter", "Fence", "Fence", ("Fence",)),
    # Objects that share a mesh.
    Expected("object", "Wheel", "Wheel", ("Wheel", "Wheel mirrored", "Wheel twice")),
    # What is no mesh yet.
    Expected("curve", "Rope", "Rope", ("Rope",)),
    Expected("text", "Sign", "Sign", ("Sign",)),
    Expected("surface", "Hull", "Hull", ("Hull",)),
    Expected("metaball", "Drop", "Drop", ("Drop",)),
    # Names that say nothing.
    Expected("object", "everything (Cube.007)", "Cube.007", ("Cube.007",)),
    Expected("object", "Oak door", "Cube.008", ("Cube.008",)),
    # A collection of another file, which is shown by an object of this one.
    Expected("instance", "Shelf 1", "Shelf 1", ("Shelf 1",)),
)

LEFT_OUT = {
    "light": 2,
    "camera": 1,
    "empty": 1,
    "empty mesh": 2,
    "mesh without faces": 1,
    "empty curve": 1,
    "metaball element": 1,
}


def make_library(folder: Path) -> Path:
    """Write the library into a folder; returns its main file.

    Parameters
    ----------
    folder : Path
        Must exist. The main file, "everything.blend", links "shelves.blend" beside it.

    Returns
    -------
    path : Path
    """
    bpy.data.batch_remove([*bpy.data.objects, *bpy.data.collections])
    (folder / "blender_assets.cats.txt").write_text(
        f"# A comment\nVERSION 1\n\n{CATALOG}:Props/Lamps:Props-Lamps\n", encoding="utf-8"
    )
    shelves = _shelves(folder / "shelves.blend")
    _chairs()
    _lamps()
    _vases()
    _scatters()
    _particles()
    _wheels()
    _without_mesh()
    _unnamed()
    _linked(shelves)
    _left_out()
    path = folder / "everything.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path), copy=True)
    return path


def _add(name: str, build: Callable[..., Any], place: Any = (0, 0, 0), **options: Any) -> Any:
    build(location=place, **options)
    item = bpy.context.object
    item.name = name
    if item.data is not None:
        item.data.name = name
    return item


def _box(name: str, place: Any = (0, 0, 0), scale: Any = (1, 1, 1)) -> Any:
    return _add(name, bpy.ops.mesh.primitive_cube_add, place, scale=scale)


def _empty(name: str, collection: Any = None, place: Any = (0, 0, 0)) -> Any:
    item = bpy.data.objects.new(name, None)
    item.location = place
    if collection is not None:
        item.instance_type, item.instance_collection = "COLLECTION", collection
    bpy.context.scene.collection.objects.link(item)
    return item


def _collect(name: str, *items: Any, shown: bool = False) -> Any:
    collection = bpy.data.collections.new(name)
    for item in items:
        for other in item.users_collection:
            other.objects.unlink(item)
        collection.objects.link(item)
    if shown:
        bpy.context.scene.collection.children.link(collection)
    return collection


def _shelves(path: Path) -> Path:
    collection = _collect("Shelf", _box("Board", scale=(2, 1, 0.1)), _box("Stile", (2, 0, 0), (0.1, 1, 3)))
    bpy.context.scene.collection.children.link(collection)
    bpy.ops.wm.save_as_mainfile(filepath=str(path), copy=True)
    for item in list(collection.objects):
        bpy.data.objects.remove(item)
    bpy.data.collections.remove(collection)
    return path


def _chairs() -> None:
    seat, back = _box("Seat", scale=(1, 1, 0.1)), _box("Backrest", (0, 1, 1), (1, 0.1, 1))
    collection = _collect("Chair", seat, back)
    for number, name in enumerate(("Chair A", "Chair B", "Chair C")):
        _empty(name, collection, (5 * number, 0, 0)).scale = (1 + number,) * 3
    _nodes(_plane("Row"), lambda tree: _info(tree, "Collection", collection), joined=False)


def _lamps() -> None:
    foot = _add("Cylinder", bpy.ops.mesh.primitive_cylinder_add, vertices=12)
    shade = _add("Shade", bpy.ops.mesh.primitive_cone_add, (0, 0, 2), vertices=9)
    collection = _collect("Lamp", foot, shade, shown=True)
    collection.asset_mark()
    collection.asset_data.tags.new("light")
    collection.asset_data.catalog_id = CATALOG
    _empty("Lamp 2", collection, (0, 9, 0))


def _vases() -> None:
    collection = _collect("Vase", _add("Lathe", bpy.ops.mesh.primitive_torus_add), shown=True)
    collection.asset_mark()
    collection.asset_data.tags.new("pot")
    _empty("Vase 2", collection, (0, 9, 9))


def _plane(name: str, divisions: int = 1) -> Any:
    return _add(
        name, bpy.ops.mesh.primitive_grid_add, size=20, x_subdivisions=divisions, y_subdivisions=divisions
    )


def _scatters() -> None:
    tree = _add("Tree", bpy.ops.mesh.primitive_ico_sphere_add)
    _nodes(_plane("Forest"), lambda nodes: _info(nodes, "Object", tree), joined=True)
    _nodes(_plane("Wood", 2), lambda nodes: _info(nodes, "Object", tree), joined=False, realized=True)
    _nodes(_plane("Bricks"), lambda nodes: nodes.nodes.new("GeometryNodeMeshCube"), joined=False)


def _info(tree: Any, kind: str, block: Any) -> Any:
    node = tree.nodes.new(f"GeometryNode{kind}Info")
    node.inputs[kind].default_value = block
    if kind == "Object":
        node.inputs["As Instance"].default_value = True
    return node


def _nodes(item: Any, instance: Callable[[Any], Any], *, joined: bool, realized: bool = False) -> None:
    """Instance something on the points of an object."""
    tree = bpy.data.node_groups.new(item.name, "GeometryNodeTree")
    for direction in ("INPUT", "OUTPUT"):
        tree.interface.new_socket("Geometry", in_out=direction, socket_type="NodeSocketGeometry")
    start, end = tree.nodes.new("NodeGroupInput"), tree.nodes.new("NodeGroupOutput")
    points, source = tree.nodes.new("GeometryNodeInstanceOnPoints"), instance(tree)
    tree.links.new(start.outputs[0], points.inputs["Points"])
    tree.links.new(source.outputs[0 if "Mesh" in source.bl_idname else -1], points.inputs["Instance"])
    last = points
    if joined:
        last = tree.nodes.new("GeometryNodeJoinGeometry")
        tree.links.new(points.outputs[0], last.inputs[0])
        tree.links.new(start.outputs[0], last.inputs[0])
    if realized:
        real = tree.nodes.new("GeometryNodeRealizeInstances")
        tree.links.new(last.outputs[0], real.inputs[0])
        last = real
    tree.links.new(last.outputs[0], end.inputs[0])
    item.modifiers.new("Nodes", "NODES").node_group = tree


def _particles() -> None:
    blade = _box("Grass", scale=(0.1, 0.1, 1))
    meadow = _plane("Meadow", 3)
    settings = meadow.modifiers.new("Particles", "PARTICLE_SYSTEM").particle_system.settings
    settings.type, settings.count = "HAIR", 5
    settings.render_type, settings.instance_object = "OBJECT", blade
    fence, post = _plane("Fence"), _box("Post", scale=(0.2, 0.2, 2))
    fence.instance_type, post.parent = "VERTS", fence


def _wheels() -> None:
    first = _add("Wheel", bpy.ops.mesh.primitive_torus_add)
    for name, scale in (("Wheel mirrored", (-1, 1, 1)), ("Wheel twice", (2, 2, 2))):
        twin = first.copy()
        twin.name, twin.scale, twin.location = name, scale, (9, 9, 9)
        bpy.context.collection.objects.link(twin)


def _without_mesh() -> None:
    _add("Rope", bpy.ops.curve.primitive_bezier_circle_add).data.bevel_depth = 0.1
    _add("Sign", bpy.ops.object.text_add).data.extrude = 0.1
    _add("Hull", bpy.ops.surface.primitive_nurbs_surface_sphere_add)
    first = _add("Drop", bpy.ops.object.metaball_add)
    second = first.copy()
    second.name, second.location = "Drop.001", (1, 0, 0)
    bpy.context.collection.objects.link(second)


def _unnamed() -> None:
    _box("Cube.007", scale=(1, 2, 3)).data.name = "Cube.007"
    _box("Cube.008", scale=(1, 0.2, 3)).data.name = "Oak door"


def _linked(path: Path) -> None:
    with bpy.data.libraries.load(str(path), link=True) as (_, wanted):
        wanted.collections = ["Shelf"]
    _empty("Shelf 1", wanted.collections[0])


def _left_out() -> None:
    for _ in range(2):
        bpy.ops.object.light_add()
    bpy.ops.object.camera_add()
    _empty("Handle")
    _add("Wire", bpy.ops.curve.primitive_bezier_curve_add)
    for _ in range(2):
        bpy.context.collection.objects.link(bpy.data.objects.new("Nothing", bpy.data.meshes.new("Nothing")))
    rope = bpy.data.meshes.new("Rope")
    rope.from_pydata([(0, 0, 0), (1, 0, 0)], [(0, 1)], [])
    bpy.context.collection.objects.link(bpy.data.objects.new("Rope of edges", rope))
