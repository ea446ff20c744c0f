# SPDX-License-Identifier: MIT
"""Finding Pythons and Blenders, and what is said of those that will not do."""

import os
import re
import sys

import pytest


def make_program(path, text):
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(f"#!/bin/sh\n{text}\n")
    path.chmod(0o755)
    return path


@pytest.fixture
def empty_machine(monkeypatch, tmp_path):
    """No Blender, and no Python but the running one."""
    monkeypatch.setenv("PATH", str(tmp_path / "bin"))
    monkeypatch.setenv("PYENV_ROOT", str(tmp_path / "pyenv"))
    monkeypatch.delenv("BLENDER", raising=False)
    return tmp_path


def test_the_running_python_is_taken_without_a_search(blenders, environment, empty_machine):
    assert blenders.find_python(environment.python_version()) == sys.executable


@pytest.mark.skipif(os.name == "nt", reason="the programs are shell scripts")
def test_a_python_is_found_only_if_it_runs_and_is_what_its_name_says(blenders, empty_machine):
    assert blenders.find_python("3.99") is None
    make_program(empty_machine / "bin" / "python3.99", "echo 'command not found' >&2; exit 127")
    assert blenders.find_python("3.99") is None, "as the files that pyenv has on PATH"
    make_program(empty_machine / "pyenv" / "versions" / "3.99.1" / "bin" / "python3.99", "echo 3.98")
    assert blenders.find_python("3.99") is None
    right = make_program(empty_machine / "pyenv" / "versions" / "3.99.0" / "bin" / "python3.99", "echo 3.99")
    assert blenders.find_python("3.99") == str(right)


def test_without_its_python_a_bpy_is_refused_with_the_version_it_needs(blenders, environment, monkeypatch):
    monkeypatch.setattr(blenders, "find_python", lambda version: None)
    with pytest.raises(environment.SetupError, match=r"bpy 5\.2\.\d+ needs Python 3\.13"):
        blenders.prepare("5.2")


def test_libraries_that_are_missing_are_named_where_they_cannot_be_installed(
    blenders, environment, monkeypatch, tmp_path
):
    monkeypatch.setattr(environment, "install_system_packages", lambda packages: False)
    monkeypatch.setattr(blenders, "import_problem", lambda python: "ImportError: libSM.so.6: cannot open")
    with pytest.raises(environment.SetupError, match=r"libSM\.so\.6.*sudo apt install .*libsm6"):
        blenders.check_import(tmp_path, "4.2")


def test_libraries_that_are_missing_are_installed_where_they_can_be(
    blenders, environment, monkeypatch, tmp_path
):
    problems = ["ImportError: libSM.so.6: cannot open shared object file", ""]
    installed = []
    monkeypatch.setattr(blenders, "import_problem", lambda python: problems.pop(0))
    monkeypatch.setattr(
        environment, "install_system_packages", lambda packages: installed.extend(packages) or True
    )
    blenders.check_import(tmp_path, "4.2")
    assert "libsm6" in installed
    assert not problems


def test_the_probe_tells_what_cannot_be_imported(blenders):
    problem = blenders.import_problem(sys.executable)  # there is no bpy in the core's environment
    assert "No module named 'bpy'" in problem


def test_no_blender_is_a_reason_of_its_own(blenders, environment, empty_machine, monkeypatch):
    with pytest.raises(environment.SetupError, match="none on PATH or in BLENDER"):
        blenders.find_real_blender()
    monkeypatch.setenv("BLENDER", str(empty_machine / "absent"))
    with pytest.raises(environment.SetupError, match=r"BLENDER=.*absent is not a program"):
        blenders.find_real_blender()


@pytest.mark.skipif(os.name == "nt", reason="the programs are shell scripts")
@pytest.mark.parametrize(
    ("answer", "reason"),
    [
        ("[[3, 4, 1], [3, 11], true]", "Blender 3.4.1, older than 4.2"),
        (None, "does not say which Python it has"),
    ],
)
def test_a_blender_that_will_not_do_is_refused(blenders, environment, empty_machine, answer, reason):
    text = f"echo 'Blender starts'; echo 'shape-google {answer}'" if answer else "echo broken"
    make_program(empty_machine / "bin" / "blender", text)
    with pytest.raises(environment.SetupError, match=re.escape(reason)):
        blenders.find_real_blender()


@pytest.mark.skipif(os.name == "nt", reason="the programs are shell scripts")
def test_a_blender_is_asked_for_its_versions(blenders, empty_machine, monkeypatch):
    text = "echo 'shape-google [[5, 0, 1], [3, 11], false]'"
    command = make_program(empty_machine / "elsewhere" / "blender", text)
    monkeypatch.setenv("BLENDER", str(command))
    found = blenders.find_real_blender()
    assert found == blenders.RealBlender(str(command), "5.0.1", "3.11", False)


def test_platforms_have_the_names_of_blenders_manifests(blenders, environment, monkeypatch):
    wheels = sys.modules["wheels"]
    for system, machine, name in [
        ("Linux", "x86_64", "linux-x64"),
        ("Windows", "AMD64", "windows-x64"),
        ("Darwin", "arm64", "macos-arm64"),
    ]:
        monkeypatch.setattr(wheels.platform, "system", lambda system=system: system)
        monkeypatch.setattr(wheels.platform, "machine", lambda machine=machine: machine)
        assert wheels.this_platform() == name
    monkeypatch.setattr(wheels.platform, "machine", lambda: "riscv64")
    with pytest.raises(environment.SetupError, match="macos-riscv64 is none of the extension's platforms"):
        wheels.this_platform()
