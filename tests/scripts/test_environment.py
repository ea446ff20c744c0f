# SPDX-License-Identifier: MIT
"""Set-up: when it installs, when it must not, and what it says when it cannot."""

import json
import re
import subprocess
import sys
from pathlib import Path

import pytest


def test_an_old_python_is_refused_with_its_version(environment):
    with pytest.raises(environment.SetupError, match=r"Python 3\.11 or newer is needed, but .* is 3\.9"):
        environment.check_python((3, 9))
    environment.check_python((3, 11))
    environment.check_python((3, 14))


def test_a_ready_environment_is_left_alone(environment, project):
    # There is no pip in it: any attempt to install would fail.
    before = sorted((project / ".venv").rglob("*"))
    environment.prepare(project, project / ".venv", ["demo"])
    environment.prepare(project, project / ".venv", ["test"])
    assert sorted((project / ".venv").rglob("*")) == before


@pytest.mark.parametrize("change", ["pyproject", "extras", "root", "python"])
def test_what_the_installation_depends_on_changes_the_stamp(environment, project, monkeypatch, change):
    before = environment.wanted_stamp(project, ["demo"])
    root, extras = project, ["demo"]
    if change == "pyproject":
        (project / "pyproject.toml").write_text('[project]\nname = "probe"\nversion = "2"\n')
    elif change == "extras":
        extras = ["demo", "test"]
    elif change == "root":
        root = project.rename(project.with_name("moved"))
    else:
        monkeypatch.setattr(sys, "version_info", (3, 99, 0, "final", 0))
    after = environment.wanted_stamp(root, extras)
    assert [key for key in before if before[key] != after[key]] == [change]


def test_requirements_and_another_python_change_the_stamp(environment, project):
    before = environment.wanted_stamp(project, [])
    other = environment.wanted_stamp(project, [], ["numpy==1.24.3"], "3.99")
    assert [key for key in before if before[key] != other[key]] == ["python", "requirements"]


def test_an_environment_for_a_python_that_does_not_run_names_it(environment, tmp_path):
    absent = str(tmp_path / "python3.13")
    with pytest.raises(environment.SetupError, match=r"python3\.13 does not run"):
        environment.prepare(environment.ROOT, tmp_path / "new", [], python=absent)
    assert not (tmp_path / "new").exists()


@pytest.mark.parametrize("content", ["", "{", "[1]", "\x00\xff"])
def test_a_damaged_stamp_counts_as_none(environment, tmp_path, content):
    (tmp_path / environment.STAMP_NAME).write_text(content, encoding="latin-1")
    assert environment.read_stamp(tmp_path) == {}
    assert environment.read_stamp(tmp_path / "absent") == {}


@pytest.mark.parametrize(
    ("content", "version"),
    [
        ("home = /usr/bin\nversion = 3.12.4\n", "3.12"),
        ("home = /usr/bin\nversion_info = 3.13.0.final.0\n", "3.13"),
        ("home = /usr/bin\n", None),
        (None, None),
    ],
)
def test_the_python_of_an_environment_is_read_from_its_settings(environment, tmp_path, content, version):
    if content is not None:
        (tmp_path / "pyvenv.cfg").write_text(content)
    assert environment.environment_version(tmp_path) == version


def remove_nothing(environment, folder):
    assert not environment.is_usable(folder), "it has no pip"


def remove_python(environment, folder):
    python = environment.interpreter(folder)
    python.unlink()
    python.symlink_to(folder / "absent")


def change_python(environment, folder):
    settings = folder / "pyvenv.cfg"
    settings.write_text(
        settings.read_text().replace(f"version = {environment.python_version()}", "version = 3.1")
    )
    assert environment.environment_version(folder) == "3.1"


@pytest.mark.parametrize("damage", [remove_nothing, remove_python, change_python])
def test_an_unusable_environment_is_mended(environment, project, damage):
    damage(environment, project / ".venv")
    assert not environment.is_usable(project / ".venv")
    environment.create(project / ".venv")
    assert environment.is_usable(project / ".venv")


def test_without_ensurepip_pip_and_root_the_missing_package_is_named(environment, project, monkeypatch):
    monkeypatch.setattr(environment, "has_module", lambda name, python: False)
    monkeypatch.setattr(environment.shutil, "which", lambda name: None)
    with pytest.raises(environment.SetupError, match=r"apt install python3\.\d+-venv"):
        environment.create(project / ".venv")


def test_a_failing_command_is_shown_with_all_its_output(environment):
    command = [
        sys.executable,
        "-c",
        "import sys; print('first'); print('second', file=sys.stderr); sys.exit(3)",
    ]
    with pytest.raises(
        environment.SetupError, match=r"(?s)Trying: exit code 3 of .*(first.*second|second.*first)"
    ):
        environment.run("Trying", command)


def test_a_command_that_does_not_exist_is_named(environment, tmp_path):
    with pytest.raises(environment.SetupError, match=r"Trying: .*absent does not start"):
        environment.run("Trying", [str(tmp_path / "absent")])


def test_enter_starts_the_script_again_inside_the_environment(project):
    probe = project / "scripts" / "probe.py"
    probe.write_text(
        "import sys, json, environment\n"
        "environment.enter(['demo'])\n"
        "print(json.dumps([sys.prefix, sys.argv[1:]]))\n"
    )
    result = subprocess.run(
        [sys.executable, str(probe), "two words", "--option"], capture_output=True, text=True, check=True
    )
    prefix, arguments = json.loads(result.stdout)
    assert Path(prefix).resolve() == (project / ".venv").resolve()
    assert arguments == ["two words", "--option"]


def test_enter_ends_with_the_output_of_pip_and_no_stamp_when_the_installation_fails(environment, project):
    # pip refuses this before it looks for any package: the test needs no network.
    (project / "pyproject.toml").write_text("[build-system]\nrequires = 3\n")
    probe = project / "scripts" / "probe.py"
    probe.write_text("import environment\nenvironment.enter([])\nprint('not reached')\n")
    result = subprocess.run([sys.executable, str(probe)], capture_output=True, text=True, check=False)
    assert result.returncode == 1
    assert re.match(r"(?s)Set-up failed: Installing .*exit code \d+ of .*pyproject\.toml", result.stderr)
    assert "not reached" not in result.stdout
    assert "Traceback" not in result.stderr
    assert environment.read_stamp(project / ".venv") == {}
