# SPDX-License-Identifier: MIT
"""Which wheels fit which Blender: platforms as its manifests name them, and what pip calls them."""

from __future__ import annotations

import platform
from collections.abc import Sequence

from lib.bootstrap import SetupError

__all__ = ["TAGS", "pins_for", "pip_options", "python_tag", "this_platform"]

# Platform tags of wheels that run wherever Blender does: it wants glibc 2.28 on Linux. On macOS it wants less
# than ONNX Runtime, which wants macOS 13.
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
    "macos-arm64": ("macosx_13_0_arm64",),
}


# What Python calls the systems, in the markers of requirements.
_SYSTEMS = {"linux": "linux", "windows": "win32", "macos": "darwin"}


def pins_for(target: str, python: str, requirements: Sequence[str]) -> list[str]:
    """Return the requirements whose markers hold on a platform, without their markers.

    pip would take the markers to be about the computer that it runs on.

    Parameters
    ----------
    target : str
        A key of `TAGS`.
    python : str
        Such as "3.11".
    requirements : sequence of str

    Returns
    -------
    pins : list of str
    """
    from packaging.requirements import Requirement  # here, since not every Python that starts a script has it

    environment = {"sys_platform": _SYSTEMS[target.partition("-")[0]], "python_version": python}
    parsed = [Requirement(text) for text in requirements]
    return [
        f"{one.name}{one.specifier}"
        for one in parsed
        if one.marker is None or one.marker.evaluate(environment)
    ]


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
