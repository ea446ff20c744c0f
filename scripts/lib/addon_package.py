# SPDX-License-Identifier: MIT
"""Find the add-on for the scripts that run inside Blender, and give them their command line.

Such a script is started in one of two ways:

    blender --background --python SCRIPT -- ARGUMENTS
    python SCRIPT ARGUMENTS                             (a Python that has the bpy module)

Blender does not put a script's folder on the path, so scripts reach this file with `runpy.run_path`.
"""

from __future__ import annotations

import importlib
import importlib.util
import os
import shutil
import sys
from pathlib import Path
from types import ModuleType
from typing import NoReturn

__all__ = ["end_module", "load_addon", "run"]

EXTENSION = "shape_google"
PACKAGE = "blender_addon"
UNUSABLE = 2


def load_addon() -> ModuleType:
    """Return the add-on's package, switched on.

    Inside Blender that is the installed extension, whose wheels hold the core; under a plain Python it is the
    folder of this repository. Blender's saved preferences are not touched.

    Returns
    -------
    addon : module

    Raises
    ------
    SystemExit
        With code 2, after one sentence on stderr, if something has to be installed first.
    """
    try:
        import bpy
    except ModuleNotFoundError:
        _give_up(
            f"{sys.executable} has no bpy module; run this script with "
            f"'blender --background --python {sys.argv[0]} -- …', or 'pip install bpy' into this Python"
        )
    import addon_utils  # on the path only once bpy is imported

    # Blender as a Python module has no program of its own.
    name = _installed_extension() if bpy.app.binary_path else _repository_package()
    addon: ModuleType | None = sys.modules.get(name)
    if not getattr(addon, "__addon_enabled__", False):  # switching on again would switch off first
        addon = addon_utils.enable(name, default_set=True)
    if addon is None:
        _give_up(f"the add-on {name} cannot be switched on; the lines above say why")
    return addon


def run(module: str, *first: str, **options: str) -> NoReturn:
    """Run `main(arguments)` of one of the add-on's modules and end the process with its exit code.

    Parameters
    ----------
    module : str
        Its name inside the add-on.
    *first : str
        Arguments to put before those of the command line.
    **options : str
        What else `main` takes.
    """
    _keep_output_clean()
    addon = load_addon()
    try:
        code = importlib.import_module(f"{addon.__name__}.{module}").main([*first, *_arguments()], **options)
    except SystemExit as stop:  # argparse's, after --help or wrong usage
        code = stop.code
    import bpy

    if bpy.app.binary_path:
        sys.exit(code)
    end_module(code)


def end_module(code: int) -> NoReturn:
    """End a Python with the module bpy at once: those of 4.2 and 4.5 can crash while Python shuts down.

    Parameters
    ----------
    code : int
        Exit code, which a crash would hide.
    """
    import bpy

    # Blender removes its folder for temporary files only when it shuts down.
    shutil.rmtree(bpy.app.tempdir, ignore_errors=True)
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(code)


def _keep_output_clean() -> None:
    """Leave standard output to the command: what Blender prints there goes to standard error.

    Blender writes its banner and its warnings from C, past Python's streams; `--json` must stay JSON.
    """
    sys.stdout.flush()
    own = os.dup(1)
    os.dup2(2, 1)
    sys.stdout = os.fdopen(own, "w", encoding=sys.stdout.encoding, errors="backslashreplace")


def _arguments() -> list[str]:
    """Arguments of the script; Blender leaves those behind `--` to it, and has its own before."""
    import bpy

    arguments = sys.argv[1:]
    if "--" in arguments:
        return arguments[arguments.index("--") + 1 :]
    return [] if bpy.app.binary_path else arguments


def _installed_extension() -> str:
    import addon_utils

    names = [module.__name__ for module in addon_utils.modules()]
    installed = [name for name in names if name.endswith(f".{EXTENSION}")]
    if not installed:
        _give_up(
            "the extension Shape Google is not installed in this Blender; install it with: "
            f"blender --command extension install-file --repo user_default --enable {EXTENSION}.zip"
        )
    return str(installed[0])


def _repository_package() -> str:
    folder = Path(__file__).resolve().parents[2]
    if importlib.util.find_spec("shapegoogle_core") is None:
        _give_up(f"{sys.executable} has no shapegoogle_core module; install it with: pip install {folder}")
    if PACKAGE not in sys.modules:
        package = folder / PACKAGE
        spec = importlib.util.spec_from_file_location(
            PACKAGE, package / "__init__.py", submodule_search_locations=[str(package)]
        )
        if spec is None or spec.loader is None:
            _give_up(f"{package} is missing; run this script inside a whole copy of the repository")
        module = importlib.util.module_from_spec(spec)
        # Blender would take a module without its time for changed, and look for it on the path to reload it.
        vars(module)["__time__"] = (package / "__init__.py").stat().st_mtime
        sys.modules[PACKAGE] = module
        spec.loader.exec_module(module)
    return PACKAGE


def _give_up(reason: str) -> NoReturn:
    print(f"{Path(sys.argv[0]).name}: {reason}", file=sys.stderr, flush=True)
    sys.exit(UNUSABLE)
