# SPDX-License-Identifier: MIT
"""The add-on can be switched on and off, again and again, and costs little of Blender's start."""

from __future__ import annotations

import importlib
import re
import subprocess
import sys
from pathlib import Path
from types import ModuleType

import bpy
import pytest

# What takes long to import; numpy too is for when it is used, though other add-ons may have imported it.
HEAVY = ("numpy", "scipy", "sklearn", "trimesh", "PIL", "shapegoogle_core")
# Importing one is an error, though it can be found.
BLOCK = f"""
import importlib.abc, importlib.machinery
class Blocked(importlib.abc.MetaPathFinder, importlib.abc.Loader):
    def find_spec(self, name, path=None, target=None):
        return importlib.machinery.ModuleSpec(name, self) if name in {HEAVY} else None
    def create_module(self, spec):
        raise ImportError(spec.name)
    def exec_module(self, module):
        pass
for name in {HEAVY}:
    sys.modules.pop(name, None)
sys.meta_path.insert(0, Blocked())
"""
# None in place of a module: it is not there.
HIDE = "sys.modules['{name}'] = None\n"
ENABLE = """
import os, sys
import bpy
import addon_utils
{block}
sys.path.insert(0, sys.argv[1])
enabled = addon_utils.enable("blender_addon", default_set=True) is not None
"""
POLL = """
# Blender asks whether buttons can be pressed each time it draws them.
polled = [getattr(bpy.ops.shape_google, name).poll() for name in dir(bpy.ops.shape_google)]
print("enabled" if enabled and polled else "failed", flush=True)
os._exit(0)
"""
SAY = """
from blender_addon import commands, needs
from types import SimpleNamespace
class Layout(SimpleNamespace):
    def column(self, **options): return self
    def label(self, text, icon, translate): self.lines.append(text)
layout = Layout(lines=[])
region = SimpleNamespace(width=300)
context = SimpleNamespace(region=region, preferences=SimpleNamespace(system=SimpleNamespace(ui_scale=1.0)))
panel = bpy.types.SHAPEGOOGLE_PT_needs
panel.draw(SimpleNamespace(layout=layout), context)
assert " ".join(layout.lines) == needs.sentence(), layout.lines
layout.lines.clear()
preferences = bpy.context.preferences.addons["blender_addon"].preferences
type(preferences).draw(SimpleNamespace(layout=layout), context)
assert " ".join(layout.lines) == needs.sentence(), layout.lines
assert commands.main(["info"]) == 2
assert not hasattr(bpy.types, "SHAPEGOOGLE_PT_search")
import blender_addon
blender_addon.unregister()
blender_addon.register()
assert not hasattr(bpy.types.WindowManager, "shape_google")
print("enabled" if enabled else "failed", flush=True)
os._exit(0)
"""


def test_every_bundled_package_is_checked(addon: ModuleType) -> None:
    """The names to import are those of the packages, but for two."""
    needs = importlib.import_module(f"{addon.__name__}.needs")
    project = Path(__file__).parents[2] / "pyproject.toml"
    wanted = re.search(r"^extension = \[\n(.*?)^\]", project.read_text(encoding="utf-8"), re.S | re.M)
    assert wanted is not None
    names = {name.replace("-", "_") for name in re.findall(r'"([\w-]+)==', wanted[1])}
    names = names - {"scikit_learn", "pillow"} | {"sklearn", "PIL", "shapegoogle_core"}
    assert set(needs.BUNDLED) == names


def test_off_and_on_again(addon: ModuleType) -> None:
    for _ in range(2):
        addon.unregister()
        assert not hasattr(bpy.types.WindowManager, "shape_google")
        addon.register()
        assert not hasattr(bpy.types, "SHAPEGOOGLE_PT_needs")
        assert hasattr(bpy.types.WindowManager, "shape_google")


def enable(addon: ModuleType, block: str, then: str) -> subprocess.CompletedProcess[str]:
    """Switch the add-on on in another process, where packages are blocked or hidden."""
    assert addon.__file__ is not None
    script = ENABLE.replace("{block}", block) + then
    command = [sys.executable, "-c", script, str(Path(addon.__file__).parents[1])]
    done = subprocess.run(command, capture_output=True, text=True, timeout=300, check=False)
    assert done.stdout.splitlines()[-1:] == ["enabled"], done.stdout + done.stderr
    assert "Traceback" not in done.stderr, done.stderr
    return done


@pytest.mark.skipif(bool(bpy.app.binary_path), reason="needs a Python that has bpy as a module")
def test_registering_and_polling_import_nothing_heavy(addon: ModuleType) -> None:
    enable(addon, BLOCK, POLL)


@pytest.mark.skipif(bool(bpy.app.binary_path), reason="needs a Python that has bpy as a module")
@pytest.mark.parametrize(
    ("package", "sentence"),
    [
        (
            "numpy",
            "Shape Google needs numpy, which this Blender does not have: use a Blender from blender.org",
        ),
        (
            "scipy",
            "Shape Google cannot find scipy, which its zip contains: install the zip whose name ends in cp3",
        ),
    ],
)
def test_a_missing_package_is_said_in_one_sentence(addon: ModuleType, package: str, sentence: str) -> None:
    done = enable(addon, HIDE.format(name=package), SAY)
    assert f"shapegoogle: {sentence}" in done.stderr
    assert len(done.stderr.strip().splitlines()) == 1
