# SPDX-License-Identifier: MIT
"""Export the meshes of .blend files as .ply, with several poses of animated files.

    python -m benchmarks blend-meshes FOLDER... --output DIR [--exclude NAME] [--poses N]

The shipped models are trained on such meshes. Needs the module bpy (Blender as a Python package). Each .blend
file is one shape: its visible mesh objects, with their modifiers, in world space, joined into one mesh. A
file with an armature and actions also yields its rest pose (`-pose0.ply`) and N poses spread over its actions
(`-pose1.ply` …). Scripts inside the files do not run, and the files are only read.

The exit code is 1 if some files could not be exported, each named on stderr.
"""

from __future__ import annotations

import argparse
import csv
import sys
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.errors import BenchmarkError
from shapegoogle_core.cli.arguments import number_from

__all__ = ["add_options", "find_blend_files", "run", "spread_frames", "write_ply"]

REST_POSE = 0


@dataclass(frozen=True)
class Source:
    """A .blend file and the names of its meshes.

    Attributes
    ----------
    path : Path
    pack : str
        Folder of the file, in the name of its shape.
    """

    path: Path
    pack: str

    @property
    def shape(self) -> str:
        """Name of the shape, unique within a searched folder."""
        return f"{self.pack}-{self.path.stem}"


def find_blend_files(folders: Sequence[Path], exclude: Sequence[str] = ()) -> list[Source]:
    """Find all .blend files below some folders, in a fixed order.

    Parameters
    ----------
    folders : sequence of Path
    exclude : sequence of str
        Names of folders, and of files without their suffix, to leave out at any depth.

    Returns
    -------
    sources : list of Source
        A file's pack is the path of its folder below the searched folder.
    """
    sources = []
    for folder in folders:
        for path in sorted(folder.rglob("*.blend")):
            place = path.relative_to(folder)
            if not {*place.parent.parts, path.stem}.intersection(exclude):
                sources.append(Source(path, "-".join(place.parent.parts) or folder.resolve().name))
    return sources


def spread_frames(ranges: Sequence[tuple[float, float]], count: int) -> list[tuple[int, float]]:
    """Choose frames evenly over some actions.

    Parameters
    ----------
    ranges : sequence of (first frame, last frame)
        One per action.
    count : int
        Number of frames.

    Returns
    -------
    frames : list of (action index, frame)
        In order. Every action has an equal share, however long it is (an idle loop is often the longest);
        inside an action the frames avoid both ends, where most actions stand still.
    """
    if not ranges:
        return []
    owners = [int((pose + 0.5) * len(ranges) / count) for pose in range(count)]
    frames = []
    for action, (first, last) in enumerate(ranges):
        share = owners.count(action)
        frames += [(action, first + (last - first) * (step + 0.5) / share) for step in range(share)]
    return frames


def write_ply(path: Path, vertices: NDArray[np.float32], faces: NDArray[np.int32]) -> None:
    """Write a triangle mesh as binary little-endian PLY.

    Parameters
    ----------
    path : Path
    vertices : (n, 3) array of float32
    faces : (m, 3) array of int32
    """
    header = (
        "ply\nformat binary_little_endian 1.0\n"
        f"element vertex {len(vertices)}\nproperty float x\nproperty float y\nproperty float z\n"
        f"element face {len(faces)}\nproperty list uchar int vertex_indices\nend_header\n"
    )
    rows = np.empty(len(faces), dtype=[("corners", "u1"), ("indices", "<i4", 3)])
    rows["corners"] = 3
    rows["indices"] = faces
    with path.open("wb") as file:
        file.write(header.encode("ascii"))
        file.write(np.ascontiguousarray(vertices, dtype="<f4").tobytes())
        file.write(rows.tobytes())


def joined_mesh(bpy: Any) -> tuple[NDArray[np.float32], NDArray[np.int32]]:
    """Join the evaluated meshes of the open scene in world space.

    Objects hidden in renders are included: packs hide parts that belong to the shape.

    Returns
    -------
    vertices : (n, 3) array of float32
    faces : (m, 3) array of int32

    Raises
    ------
    ValueError
        If there is no face.
    """
    all_vertices, all_faces = [np.empty((0, 3))], [np.empty((0, 3), np.int32)]
    offset = 0
    for instance in bpy.context.evaluated_depsgraph_get().object_instances:
        if instance.object.type != "MESH":
            continue
        mesh = instance.object.to_mesh()
        vertices = np.empty((len(mesh.vertices), 3), np.float32)
        mesh.vertices.foreach_get("co", vertices.ravel())
        mesh.calc_loop_triangles()
        faces = np.empty((len(mesh.loop_triangles), 3), np.int32)
        mesh.loop_triangles.foreach_get("vertices", faces.ravel())
        instance.object.to_mesh_clear()
        world = np.array(instance.matrix_world)
        if np.linalg.det(world[:3, :3]) < 0:
            faces = faces[:, ::-1]  # a mirrored object would come out inside out
        all_vertices.append(vertices @ world[:3, :3].T + world[:3, 3])
        all_faces.append(faces + offset)
        offset += len(vertices)
    faces = np.concatenate(all_faces)
    if not len(faces):
        raise ValueError("shows no mesh with faces")
    return np.concatenate(all_vertices).astype(np.float32), faces


def pose_actions(bpy: Any) -> list[Any]:
    """List the actions of the open file that move bones, sorted by name."""
    actions = sorted(bpy.data.actions, key=lambda action: action.name)
    return [a for a in actions if any(curve.data_path.startswith("pose.bones") for curve in a.fcurves)]


def pose_armature(armature: Any, action: Any) -> None:
    """Pose an armature by one action only."""
    armature.data.pose_position = "POSE"
    animation = armature.animation_data_create()
    animation.use_nla = False
    # Bones that the action does not move would otherwise keep the pose of the previous action.
    for bone in armature.pose.bones:
        bone.matrix_basis.identity()
    animation.action = action
    # Since Blender 4.4, an action has no effect before one of its slots is chosen.
    if hasattr(animation, "action_slot") and animation.action_slot is None:
        animation.action_slot = animation.action_suitable_slots[0]


def set_frame(scene: Any, frame: float) -> None:
    """Go to a frame, possibly between two whole frames."""
    whole = int(np.floor(frame))
    scene.frame_set(whole, subframe=frame - whole)


def poses(bpy: Any, count: int) -> Iterator[int]:
    """Put the open scene into each pose in turn.

    Parameters
    ----------
    bpy : module
    count : int
        Poses besides the rest pose.

    Yields
    ------
    pose : int
        Number of the pose; 0 is the rest pose, or the only pose of a file without animation.
    """
    armatures = [item for item in bpy.context.scene.objects if item.type == "ARMATURE"]
    for armature in armatures:
        armature.data.pose_position = "REST"
    yield REST_POSE
    actions = pose_actions(bpy) if armatures else []
    ranges = [tuple(action.frame_range) for action in actions]
    for pose, (action, frame) in enumerate(spread_frames(ranges, count), start=1):
        for armature in armatures:
            pose_armature(armature, actions[action])
        set_frame(bpy.context.scene, frame)
        yield pose


def export_file(bpy: Any, source: Source, output: Path, count: int) -> list[tuple[str, str, str, int]]:
    """Export one .blend file.

    Parameters
    ----------
    bpy : module
    source : Source
    output : Path
        Folder to write into.
    count : int
        Poses besides the rest pose, if the file is animated.

    Returns
    -------
    rows : list of (file, pack, shape, pose)
        One per mesh written.

    Raises
    ------
    RuntimeError
        If Blender cannot open the file.
    ValueError
        If it shows no mesh with faces.
    """
    bpy.ops.wm.open_mainfile(filepath=str(source.path), load_ui=False, use_scripts=False)
    meshes = [(pose, *joined_mesh(bpy)) for pose in poses(bpy, count)]
    rows = []
    for pose, vertices, faces in meshes:
        name = f"{source.shape}-pose{pose}.ply" if len(meshes) > 1 else f"{source.shape}.ply"
        write_ply(output / name, vertices, faces)
        rows.append((name, source.pack, source.shape, pose))
    return rows


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of the subcommand.

    Parameters
    ----------
    parser : argparse.ArgumentParser
    """
    parser.add_argument("folders", metavar="FOLDER", nargs="+", type=Path, help="searched for .blend files")
    parser.add_argument("--output", metavar="DIR", required=True, type=Path, help="folder for the .ply files")
    parser.add_argument(
        "--exclude", metavar="NAME", action="append", default=[], help="folder or file name to leave out"
    )
    parser.add_argument(
        "--poses",
        metavar="N",
        type=number_from(0),
        default=0,
        help="poses of animated files besides the rest pose (%(default)s)",
    )


def run(options: argparse.Namespace) -> int:
    """Export the meshes and write meshes.csv.

    Parameters
    ----------
    options : argparse.Namespace
        As from `add_options`.

    Returns
    -------
    exit_code : int

    Raises
    ------
    BenchmarkError
        If one of the folders does not exist.
    """
    import bpy

    for folder in options.folders:
        if not folder.is_dir():
            raise BenchmarkError(f"'{folder}' is not a folder")
    started = time.monotonic()
    options.output.mkdir(parents=True, exist_ok=True)
    sources = find_blend_files(options.folders, options.exclude)
    shapes: set[str] = set()
    rows = []
    failures = 0
    for source in sources:
        try:
            if source.shape in shapes:
                raise ValueError(f"another file already gave the shape {source.shape!r}; export it elsewhere")
            rows += export_file(bpy, source, options.output, options.poses)
            shapes.add(source.shape)
        except (RuntimeError, ValueError) as error:
            failures += 1
            print(f"{source.path}: skipped: {str(error).strip()}", file=sys.stderr)
    with (options.output / "meshes.csv").open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(["file", "pack", "shape", "pose"])
        writer.writerows(rows)
    print(
        f"{len(rows)} meshes of {len(shapes)} shapes written to {options.output} "
        f"in {time.monotonic() - started:.1f} s; {failures} of {len(sources)} files skipped"
    )
    return 1 if failures or not sources else 0
