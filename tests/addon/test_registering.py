# SPDX-License-Identifier: MIT
"""The add-on can be switched on and off, again and again, and costs little of Blender's start."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from types import ModuleType

import bpy
import pytest

# What takes long to import; numpy too is for when it is used, though other add-ons may have imported it.
HEAVY = ("numpy", "scipy", "sklearn", "trimesh", "PIL", "shapegoogle_core")
# None in place of a module makes importing it an error.
ENABLE = f"""
import os, sys
import bpy
import addon_utils
for name in {HEAVY}:
    sys.modules[name] = None
sys.path.insert(0, sys.argv[1])
enabled = addon_utils.enable("blender_addon", default_set=True) is not None
# Blender asks whether buttons can be pressed each time it draws them.
polled = [getattr(bpy.ops.shape_google, name).poll() for name in dir(bpy.ops.shape_google)]
print("enabled" if enabled and polled else "failed", flush=True)
os._exit(0)
"""


def test_off_and_on_again(addon: ModuleType) -> None:
    for _ in range(2):
        addon.unregister()
        assert not hasattr(bpy.types.WindowManager, "shape_google")
        addon.register()
        assert hasattr(bpy.types.WindowManager, "shape_google")


@pytest.mark.skipif(bool(bpy.app.binary_path), reason="needs a Python that has bpy as a module")
def test_registering_and_polling_import_nothing_heavy(addon: ModuleType) -> None:
    assert addon.__file__ is not None
    folder = Path(addon.__file__).parents[1]
    command = [sys.executable, "-c", ENABLE, str(folder)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=300, check=False)
    assert done.stdout.splitlines()[-1:] == ["enabled"], done.stdout + done.stderr
    assert "Traceback" not in done.stderr, done.stderr
