# SPDX-License-Identifier: MIT
"""The built zip in every Blender at hand: installed into an empty user folder, used, switched off and on."""

from __future__ import annotations

import os
import subprocess
from pathlib import Path
from typing import Any

import pytest

SCRIPT = Path(__file__).with_name("install_and_use.py")
ON, OFF = [True, True, True], [False, False, False]


@pytest.fixture(scope="module")
def report(host: Any, extension: Any) -> Any:
    return host.report(SCRIPT, extension)


def test_it_can_be_installed_disabled_and_enabled_again(report: Any) -> None:
    assert report["before"] == OFF
    assert report["installed"] == ON, report["output"]
    assert report["disabled"] == OFF
    assert report["enabled_again"] == ON


@pytest.mark.parametrize("when", ["painted", "painted_again"])
def test_an_operator_works(report: Any, when: Any) -> None:
    painted = report[when]
    assert painted["result"] == ["FINISHED"], report["output"]
    assert painted["ranges"], "a float attribute was written"
    assert all(low < high for low, high in painted["ranges"].values())


def test_the_core_describes_a_shape(report: Any) -> None:
    assert report["described"] > 0


def test_packages_come_from_the_extension_but_numpy_from_blender(report: Any, host: Any) -> None:
    origins = {name: Path(path) for name, path in report["origins"].items()}
    assert host.user_folder / "extensions" not in origins.pop("numpy").parents
    assert [
        name for name, path in origins.items() if host.user_folder / "extensions" not in path.parents
    ] == []


def test_it_writes_nothing_beside_itself(report: Any) -> None:
    assert not report["wrote_beside_itself"]


def test_blender_complains_of_nothing(report: Any) -> None:
    lines = report["output"].splitlines()
    assert [line for line in lines if "Traceback" in line or "Error" in line] == []


def test_it_is_there_after_a_restart_as_a_command(report: Any, host: Any) -> None:
    if not host.is_real:
        pytest.skip("Blender as a Python module has no command line")
    assert report["enabled_again"] == ON
    command = (host.command[0], "--command", "shape_google")
    output = host.run("--help", command=command)
    assert "usage: " in output
    assert "index" in output


def test_the_zip_for_another_python_is_refused_with_both_pythons(
    host: Any, extensions: Any, tmp_path: Path
) -> None:
    if not host.is_real:
        pytest.skip("Blender as a Python module has no command line")
    (other,) = (tag for tag in extensions if tag != host.python_tag)
    install = ("--command", "extension", "install-file", "--repo", "user_default", "--enable")
    result = subprocess.run(
        [host.command[0], *install, extensions[other]],
        env={**os.environ, **host.variables, "BLENDER_USER_RESOURCES": str(tmp_path)},
        capture_output=True,
        text=True,
        errors="replace",
        timeout=300,
        check=False,
    )
    pythons = [f"3.{tag.removeprefix('cp3')}" for tag in (host.python_tag, other)]
    sentence = "This Python version ({}) isn't compatible with ({})".format(*pythons)
    assert sentence in result.stdout + result.stderr
