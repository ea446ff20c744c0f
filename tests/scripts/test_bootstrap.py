# SPDX-License-Identifier: MIT
"""Set-up: when it installs, when it must not, and its messages when it cannot."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from lib import bootstrap

SCRIPTS = Path(__file__).resolve().parents[2] / "scripts"


@pytest.fixture
def project(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A repository of its own with a complete `.venv` without pip, so that any installation fails."""
    root = tmp_path.resolve()
    (root / "scripts" / "lib").mkdir(parents=True)
    (root / "scripts" / "lib" / "bootstrap.py").write_bytes((SCRIPTS / "lib" / "bootstrap.py").read_bytes())
    (root / "pyproject.toml").write_text('[project]\nname = "probe"\nversion = "1"\n')
    subprocess.run([sys.executable, "-m", "venv", "--without-pip", str(root / ".venv")], check=True)
    # Let `prepare` itself describe the environment, with the steps that need a network left out.
    with monkeypatch.context() as patch:
        patch.setattr(bootstrap, "run", lambda *arguments: None)
        bootstrap.prepare(root, root / ".venv", ["demo", "test"])
    return root


def test_an_old_python_is_refused_with_its_version(project: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "version_info", (3, 9, 18, "final", 0))
    with pytest.raises(bootstrap.SetupError, match=r"Python 3\.11 or newer is needed, but .* is 3\.9"):
        bootstrap.prepare(project, project / ".venv", [])


def test_a_complete_environment_is_left_alone(project: Path) -> None:
    # There is no pip in it: any attempt to install would fail.
    before = sorted((project / ".venv").rglob("*"))
    bootstrap.prepare(project, project / ".venv", ["demo"])
    bootstrap.prepare(project, project / ".venv", ["test"])
    assert sorted((project / ".venv").rglob("*")) == before


@pytest.mark.parametrize("change", ["pyproject", "extras", "root", "python", "interpreter"])
def test_a_change_installs_again(project: Path, monkeypatch: pytest.MonkeyPatch, change: str) -> None:
    root, extras = project, ["demo"]
    if change == "pyproject":
        (project / "pyproject.toml").write_text('[project]\nname = "probe"\nversion = "2"\n')
    elif change == "extras":
        extras = ["peers"]
    elif change == "root":
        root = project.rename(project.with_name("moved"))
    elif change == "python":
        monkeypatch.setattr(sys, "version_info", (3, 99, 0, "final", 0))
    else:
        python = bootstrap.python_of(project / ".venv")
        python.unlink()
        python.symlink_to(project / "absent")
    installed: list[str] = []
    monkeypatch.setattr(bootstrap, "run", lambda title, command, *rest: installed.append(title))
    bootstrap.prepare(root, root / ".venv", extras)
    assert installed[-1].startswith("Installing the package and its dependencies")
    stamp = bootstrap.read_stamp(root / ".venv")
    assert set(stamp["extras"]) == {"demo", "test", *extras}, "what was installed before stays"


@pytest.mark.parametrize("content", ["", "{", "[1]", "\x00\xff"])
def test_a_damaged_stamp_counts_as_none(tmp_path: Path, content: str) -> None:
    (tmp_path / bootstrap.STAMP).write_text(content, encoding="latin-1")
    assert bootstrap.read_stamp(tmp_path) == {}
    assert bootstrap.read_stamp(tmp_path / "absent") == {}


def test_without_ensurepip_pip_and_root_the_missing_package_is_named(
    project: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(bootstrap, "find_spec", lambda name: None)
    monkeypatch.setattr(shutil, "which", lambda name: None)
    with pytest.raises(bootstrap.SetupError, match=r"apt install python3\.\d+-venv"):
        bootstrap.prepare(project, project / "new", [])


def test_a_failing_command_is_shown_with_all_its_output() -> None:
    code = "import sys; print('first'); print('second', file=sys.stderr); sys.exit(3)"
    pattern = r"(?s)Trying: exit code 3 of .*(first.*second|second.*first)"
    with pytest.raises(bootstrap.SetupError, match=pattern):
        bootstrap.run("Trying", [sys.executable, "-c", code])


def test_a_command_that_does_not_exist_is_named(tmp_path: Path) -> None:
    with pytest.raises(bootstrap.SetupError, match=r"Trying: .*absent does not start"):
        bootstrap.run("Trying", [str(tmp_path / "absent")])


def test_enter_starts_the_script_again_inside_the_environment_with_the_repository_on_its_path(
    project: Path,
) -> None:
    (project / "beside.py").write_text("")
    probe = project / "scripts" / "probe.py"
    probe.write_text(
        "import sys, json\n"
        "from lib import bootstrap\n"
        "bootstrap.enter(['demo'])\n"
        "import beside\n"
        "print(json.dumps([sys.prefix, sys.argv[1:]]))\n"
    )
    command = [sys.executable, str(probe), "two words", "--option"]
    result = subprocess.run(command, capture_output=True, text=True, check=True)
    prefix, arguments = json.loads(result.stdout)
    assert Path(prefix).resolve() == (project / ".venv").resolve()
    assert arguments == ["two words", "--option"]


def test_enter_ends_with_the_output_of_pip_and_no_stamp_when_the_installation_fails(project: Path) -> None:
    # pip refuses this before it searches for any package: the test needs no network.
    (project / "pyproject.toml").write_text("[build-system]\nrequires = 3\n")
    probe = project / "scripts" / "probe.py"
    probe.write_text("from lib import bootstrap\nbootstrap.enter([])\nprint('not reached')\n")
    result = subprocess.run([sys.executable, str(probe)], capture_output=True, text=True, check=False)
    assert result.returncode == 1
    assert re.match(r"(?s)Set-up failed: Installing .*exit code \d+ of .*pyproject\.toml", result.stderr)
    assert "not reached" not in result.stdout
    assert "Traceback" not in result.stderr
    assert bootstrap.read_stamp(project / ".venv") == {}
