# SPDX-License-Identifier: MIT
"""Which wheels fit which Blender: platforms as its manifests name them, and what pip calls them."""

from __future__ import annotations

import platform

from lib.bootstrap import SetupError

__all__ = ["TAGS", "pip_options", "python_tag", "this_platform"]

# Platform tags of wheels that run wherever Blender does: it wants glibc 2.28 on Linux; scipy wants macOS 12.
TAGS = {
    "linux-x64": (
        "manylinux_2_28_x86_64",
        "manylinux_2_27_x86_64",
        "manylinux_2_24_x86_64",
        "manylinux_2_17_x86_64",
        "manylinux2014_x86_64",
        "manylinux_2_12_x86_64",
        "manylinux_2_5_x86_64",
    ),
    "windows-x64": ("win_amd64",),
    "macos-arm64": ("macosx_12_0_arm64",),
}


def python_tag(python: str) -> str:
    """Return the tag of wheels for a Python.

    Parameters
    ----------
    python : str
        Such as "3.11".

    Returns
    -------
    tag : str
        Such as "cp311".
    """
    return f"cp{python.replace('.', '')}"


def pip_options(target: str, python: str) -> list[str]:
    """Return pip's options for wheels that fit a Blender.

    Parameters
    ----------
    target : str
        A key of `TAGS`, as Blender's manifests name it.
    python : str
        Such as "3.11".

    Returns
    -------
    options : list of str
    """
    tags = [f"--platform={tag}" for tag in TAGS[target]]
    return ["--only-binary=:all:", "--implementation=cp", f"--python-version={python}", *tags]


def this_platform() -> str:
    """Name of the platform that this runs on, as Blender's manifests name it.

    Returns
    -------
    name : str
        A key of `TAGS`.

    Raises
    ------
    SetupError
        If no extension can be built for it.
    """
    system = {"darwin": "macos"}.get(platform.system().lower(), platform.system().lower())
    machine = {"x86_64": "x64", "amd64": "x64", "aarch64": "arm64"}.get(platform.machine().lower())
    name = f"{system}-{machine or platform.machine().lower()}"
    if name not in TAGS:
        raise SetupError(f"{name} is none of the extension's platforms: {', '.join(TAGS)}")
    return name
