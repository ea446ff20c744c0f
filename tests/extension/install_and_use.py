# SPDX-License-Identifier: MIT
"""Run inside a Blender without user files: install the zip, use it, switch it off and on, print a report."""

from __future__ import annotations

import importlib
import importlib.metadata
import json
import os
import shutil
import sys
from pathlib import Path
from typing import Any

import bpy

NAME = "bl_ext.user_default.shape_google"
BUNDLED: tuple[str, ...] = (
    "scipy",
    "sklearn",
    "joblib",
    "threadpoolctl",
    "robust_laplacian",
    "fast_simplification",
)
BUNDLED += (
    "trimesh",
    "mapbox_earcut",
    "onnxruntime",
    "PIL",
    "pebble",
    "tqdm",
    "psycopg",
    "psycopg_binary",
    "shapegoogle_core",
)


def is_known() -> Any:
    """What of the add-on Blender knows."""
    import addon_utils  # on the path only once bpy is imported

    operator = hasattr(bpy.types, "SHAPE_GOOGLE_OT_paint")
    return [addon_utils.check(NAME)[1], operator, hasattr(bpy.types.WindowManager, "shape_google")]


def paint() -> Any:
    """Paint a new object; the range of each attribute that was written."""
    bpy.ops.mesh.primitive_monkey_add()
    result = sorted(bpy.ops.shape_google.paint())
    mesh = bpy.context.object.data
    ranges = {}
    for attribute in mesh.attributes:
        if attribute.name.startswith("sg_") and attribute.data_type == "FLOAT":
            values = [item.value for item in attribute.data]
            ranges[attribute.name] = [min(values), max(values)]
    return {"result": result, "ranges": ranges, "vertices": len(mesh.vertices)}


def describe() -> Any:
    """Describe a shape by the shipped model, which needs most of the packages."""
    import numpy as np

    import shapegoogle_core as sg

    mesh = bpy.context.object.data
    vertices = np.array([vertex.co for vertex in mesh.vertices])
    mesh.calc_loop_triangles()
    faces = np.array([triangle.vertices for triangle in mesh.loop_triangles])
    return float(sg.load_model().describe(sg.Mesh(vertices, faces)).bags.sum())


def files_beside(module: Any) -> Any:
    """Every file of the installed extension with its size; Python's own caches aside."""
    folder = Path(module.__file__).parent
    files = sorted(path for path in folder.rglob("*") if path.is_file() and "__pycache__" not in path.parts)
    return [[path.relative_to(folder).as_posix(), path.stat().st_size] for path in files]


def main(path: str) -> dict[str, Any]:
    import addon_utils

    report = {"before": is_known()}
    bpy.ops.extensions.package_install_files(filepath=path, repo="user_default", enable_on_install=True)
    report["installed"] = is_known()
    files = files_beside(sys.modules[NAME])
    report["painted"] = paint()
    report["described"] = describe()
    report["origins"] = {name: importlib.import_module(name).__file__ for name in ("numpy", *BUNDLED)}
    report["core_version"] = importlib.metadata.version("shapegoogle-core")
    addon_utils.disable(NAME, default_set=True)
    report["disabled"] = is_known()
    addon_utils.enable(NAME, default_set=True)
    report["enabled_again"] = is_known()
    report["painted_again"] = paint()
    report["wrote_beside_itself"] = files_beside(sys.modules[NAME]) != files
    if bpy.app.binary_path:  # a Blender without a program crashes (4.2) when it reads them back
        bpy.ops.wm.save_userpref()
    return report


report = main(sys.argv[-1])
print(f"\nshape-google-report {json.dumps(report)}", flush=True)
sys.stdout.flush()
shutil.rmtree(bpy.app.tempdir, ignore_errors=True)
os._exit(0)
