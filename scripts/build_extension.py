# SPDX-License-Identifier: MIT
"""Build the Blender extension: zips in `dist` for "Install from Disk", with all packages they need inside.

    python3 scripts/build_extension.py [--platform linux-x64|windows-x64|macos-arm64 … | --all]
                                       [--python 3.11|3.13 …] [--repository]

One zip for each platform and Python: Blender 4.2 to 5.0 has Python 3.11, later ones 3.13. For the platform of
this machine if none is named, and for both Pythons. Blender's own extension tool checks and packs them.
With --repository they also go to `dist/repository`, with the index by which Blender installs and updates them
from a web server (Preferences › Get Extensions › Repositories).
"""

from __future__ import annotations

import argparse
import hashlib
import itertools
import os
import shutil
import sys
import tempfile
import time
import zipfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from lib import bootstrap, wheels
from lib.manual import write_manual

__all__ = ["build", "main"]

ADDON = bootstrap.ROOT / "blender_addon"
MANIFEST = "blender_manifest.toml"
EXTENSION = "shape_google"
DIST = bootstrap.ROOT / "dist"
REPOSITORY = DIST / "repository"
CACHE = bootstrap.ROOT / ".cache"
WHEELS = CACHE / "wheels"
CONVERTER = CACHE / "markdown"
STAGES = CACHE / "extension"
PIP = (sys.executable, "-m", "pip")
PIP_OPTIONS = ("--no-input", "--disable-pip-version-check", "--progress-bar=off")
CORE_FILES = ("pyproject.toml", "README.md", "LICENSE", "shapegoogle_core")
# Files of the add-on that are packed; what is not named here, such as caches, stays out.
PACKED = ("*.py", "*.png", "*.svg", "LICENSE", "README.md")
LARGEST = 95e6  # bytes of a zip
ZIP_DATE = (2020, 1, 1, 0, 0, 0)  # any, but always the same


def build(platform: str, python: str) -> Path:
    """Build and check the zip for one platform and Python, unless it is there and nothing has changed.

    Parameters
    ----------
    platform : str
        A key of `wheels.TAGS`.
    python : str
        Such as "3.11".

    Returns
    -------
    path : Path
        See `zip_path`.

    Raises
    ------
    SetupError
        If a wheel cannot be had, Blender's tool is nowhere, it finds a fault, or the zip is too large.
    """
    path = zip_path(platform, python)
    stage = STAGES / f"{platform}-{wheels.python_tag(python)}" / "contents"
    fill(stage, platform, python)
    stamp = {"contents": digest(stage), "path": str(path)}
    if path.exists() and bootstrap.read_stamp(stage.parent) == {**stamp, "zip": digest(path)}:
        return path
    tool = extension_tool()
    DIST.mkdir(exist_ok=True)
    packed = stage.parent / path.name
    command = [*tool, "build", "--source-dir", str(stage), "--output-filepath", str(packed)]
    bootstrap.run(f"Packing {path.name}", command)
    make_reproducible(packed, path)
    packed.unlink()
    if (size := path.stat().st_size) > LARGEST:
        path.unlink()
        raise bootstrap.SetupError(f"it has {size / 1e6:.1f} MB, and may have {LARGEST / 1e6:.0f}")
    bootstrap.run(f"Checking {path.name}", [*tool, "validate", str(path)])
    bootstrap.write_stamp(stage.parent, {**stamp, "zip": digest(path)})
    return path


def zip_path(platform: str, python: str) -> Path:
    """Path of the zip for one platform and Python.

    Parameters
    ----------
    platform : str
    python : str

    Returns
    -------
    path : Path
        `dist/shape_google-VERSION-PLATFORM-cpNNN.zip`.
    """
    tag = wheels.python_tag(python)
    return DIST / f"{EXTENSION}-{version()}-{platform.replace('-', '_')}-{tag}.zip"


def version() -> str:
    """Read the version of the project.

    Returns
    -------
    version : str
    """
    text = (bootstrap.ROOT / bootstrap.VERSION_FILE).read_text(encoding="utf-8")
    return text.partition('__version__ = "')[2].partition('"')[0]


def fill(stage: Path, platform: str, python: str) -> None:
    """Lay out the extension as it will be packed: the add-on, its wheels, and the manifest naming both."""
    wheel_files = {path.name: path for path in downloaded(platform, python)}
    core = core_wheel()
    wheel_files[core.name] = core
    shutil.rmtree(stage, ignore_errors=True)
    (stage / "wheels").mkdir(parents=True)
    for name, path in wheel_files.items():
        os.link(path, stage / "wheels" / name)
    sources = sorted({path for pattern in PACKED for path in ADDON.rglob(pattern)})
    for source in sources:
        target = stage / source.relative_to(ADDON)
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(source, target)
    (pin,) = pyproject()["dependency-groups"]["manual"]
    write_manual(stage / "manual", CONVERTER, PIP, pin)
    text = (ADDON / MANIFEST).read_text(encoding="utf-8")
    complete = complete_manifest(text, version(), platform, sorted(wheel_files))
    (stage / MANIFEST).write_text(complete, encoding="utf-8")


def complete_manifest(text: str, version: str, platform: str, wheel_names: Sequence[str]) -> str:
    """Add to the manifest what only the build knows.

    Parameters
    ----------
    text : str
        The manifest in the repository.
    version : str
    platform : str
    wheel_names : sequence of str
        File names in the folder `wheels`.

    Returns
    -------
    text : str
    """
    names = "".join(f'  "./wheels/{name}",\n' for name in wheel_names)
    before, table, after = text.partition("[permissions]")
    return (
        f'{before}version = "{version}"\nplatforms = ["{platform}"]\nwheels = [\n{names}]\n\n{table}{after}'
    )


def make_reproducible(packed: Path, path: Path) -> None:
    """Copy a zip in such a way that the same content gives the same file whenever and wherever it is packed.

    Blender's tool takes files in the order of the disk, with their times.
    """
    with zipfile.ZipFile(packed) as source, zipfile.ZipFile(path, "w") as target:
        for item in sorted(source.infolist(), key=lambda item: item.filename):
            info = zipfile.ZipInfo(item.filename, ZIP_DATE)
            info.compress_type = item.compress_type
            info.external_attr = 0o644 << 16
            target.writestr(info, source.read(item))


def downloaded(platform: str, python: str) -> list[Path]:
    """Download the wheels for one platform and Python, if they are not there yet.

    They are those that pyproject.toml pins, each by itself: what they ask for beyond that is numpy, which
    is Blender's.
    """
    folder = WHEELS / f"{platform}-{wheels.python_tag(python)}"
    pins = wheels.pins_for(platform, python, pyproject()["dependency-groups"]["extension"])
    if bootstrap.read_stamp(folder) != {"pins": pins}:
        shutil.rmtree(folder, ignore_errors=True)
        options = ["--no-deps", *wheels.pip_options(platform, python), f"--dest={folder}"]
        bootstrap.run(
            f"Downloading {len(pins)} packages for {platform}, Python {python}",
            [*PIP, "download", *PIP_OPTIONS, *options, *pins],
        )
        bootstrap.write_stamp(folder, {"pins": pins})
    return sorted(folder.glob("*.whl"))


def core_wheel() -> Path:
    """Build the core's wheel, if its sources have changed.

    Its version ends in a hash of the sources: Blender unpacks no wheel of a version that it already has, and
    a second build would otherwise run with the core of the first. It is built from a copy, since setuptools
    leaves files beside the sources, and packs those left from before.
    """
    with tempfile.TemporaryDirectory() as temporary:
        copy = Path(temporary) / "core"
        copy.mkdir()
        for name in CORE_FILES:
            source = bootstrap.ROOT / name
            if source.is_dir():
                shutil.copytree(source, copy / name, ignore=shutil.ignore_patterns("__pycache__"))
            else:
                shutil.copyfile(source, copy / name)
        sources = digest(copy)
        folder = WHEELS / "core" / sources
        if not list(folder.glob("*.whl")):
            project = copy / "pyproject.toml"
            text = project.read_text("utf-8")
            fixed = f'version = "{version()}+{sources[:8]}"'
            project.write_text(text.replace('dynamic = ["version"]', fixed), encoding="utf-8")
            command = [*PIP, "wheel", *PIP_OPTIONS, "--no-deps", "--wheel-dir", str(folder), str(copy)]
            bootstrap.run(
                "Building the wheel of the core", command, {**os.environ, "SOURCE_DATE_EPOCH": "1577836800"}
            )
    return next(folder.glob("*.whl"))


def digest(path: Path) -> str:
    """Hash of a file, or of all files in a folder with their names."""
    files = sorted(item for item in path.rglob("*") if item.is_file()) if path.is_dir() else [path]
    total = hashlib.sha256()
    for file in files:
        name = file.relative_to(path).as_posix() if path.is_dir() else ""
        with file.open("rb") as content:
            total.update(f"{name}\0{hashlib.file_digest(content, 'sha256').hexdigest()}\n".encode())
    return total.hexdigest()


def pyproject() -> dict[str, Any]:
    """Content of pyproject.toml."""
    import tomllib  # here, since an older Python must get as far as reporting that it is too old

    return tomllib.loads((bootstrap.ROOT / "pyproject.toml").read_text(encoding="utf-8"))


def pythons() -> list[str]:
    """Versions of Python that supported Blenders ship."""
    return sorted({blender["python"] for blender in pyproject()["tool"]["shapegoogle"]["blenders"].values()})


def extension_tool() -> list[str]:
    """Start of a command line for Blender's extension tool: of a bpy module, or of a real Blender.

    Raises
    ------
    SetupError
        If there is neither, and no bpy module can be installed.
    """
    if tool := _tool_of_bpy():
        return tool
    if real := shutil.which(os.environ.get("BLENDER") or "blender"):
        return [real, "--command", "extension"]
    bootstrap.run(
        "Installing Blender's bpy module", bootstrap.nox("--session", "addon-4.5", "--install-only")
    )
    if tool := _tool_of_bpy():
        return tool
    raise bootstrap.SetupError(
        f"Blender's extension tool is needed, from a bpy module (Python {' or '.join(pythons())}) or from a "
        "Blender; set BLENDER to the path of one"
    )


def _tool_of_bpy() -> list[str]:
    program = "bpy/*/scripts/addons_core/bl_pkg/cli/blender_ext.py"
    found = sorted(bootstrap.ROOT.glob(f".nox/addon-*/**/site-packages/{program}"))
    return [sys.executable, "-I", str(found[-1])] if found else []


def make_repository(zips: Sequence[Path]) -> Path:
    """Lay out a repository of extensions, to be put on a web server as it is.

    Parameters
    ----------
    zips : sequence of Path
        Of one version. Blender offers each user the one for its system and Python.

    Returns
    -------
    folder : Path
        `dist/repository`, with the zips, `index.json` for Blender and `index.html` for people.

    Raises
    ------
    SetupError
        If Blender's tool is nowhere, or finds a fault.
    """
    shutil.rmtree(REPOSITORY, ignore_errors=True)
    REPOSITORY.mkdir(parents=True)
    for path in zips:
        os.link(path, REPOSITORY / path.name)
    command = [*extension_tool(), "server-generate", "--repo-dir", str(REPOSITORY), "--html"]
    bootstrap.run("Writing the index of the repository", command)
    return REPOSITORY


def parse_arguments(arguments: Sequence[str] | None) -> tuple[list[tuple[str, str]], bool]:
    """List the platforms and Pythons to build for, and say whether to make a repository."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0], allow_abbrev=False)
    which = parser.add_mutually_exclusive_group()
    which.add_argument(
        "--platform", nargs="+", choices=list(wheels.TAGS), help="this machine's when left out"
    )
    which.add_argument("--all", action="store_true", help="all platforms")
    parser.add_argument(
        "--python", nargs="+", choices=pythons(), help="Python of the Blenders; both when left out"
    )
    parser.add_argument(
        "--repository", action="store_true", help="make a repository for a web server of the zips"
    )
    options = parser.parse_args(arguments)
    platforms = list(wheels.TAGS) if options.all else options.platform or [wheels.this_platform()]
    return list(itertools.product(platforms, options.python or pythons())), options.repository


def main(arguments: Sequence[str] | None = None) -> int:
    targets, repository = parse_arguments(arguments)
    bootstrap.enter([])
    zips = []
    for platform, python in targets:
        started = time.monotonic()
        try:
            path = build(platform, python)
        except bootstrap.SetupError as error:
            print(f"The extension for {platform}, Python {python}, cannot be built: {error}", file=sys.stderr)
            return 1
        zips.append(path)
        size = path.stat().st_size / 1e6
        print(f"{path.relative_to(bootstrap.ROOT)}: {size:.1f} MB, {time.monotonic() - started:.1f} s")
    if repository:
        try:
            folder = make_repository(zips)
        except bootstrap.SetupError as error:
            print(f"The repository cannot be made: {error}", file=sys.stderr)
            return 1
        print(f"{folder.relative_to(bootstrap.ROOT)}: {len(zips)} zips and their index")
    return 0


if __name__ == "__main__":
    sys.exit(main())
