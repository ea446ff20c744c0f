# SPDX-License-Identifier: MIT
"""Files for publishing and hosting agree with the project; `scripts/check_release.py` checks their form."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

import check_release
import nox
import pytest
from lib.bootstrap import SetupError

import noxfile
import shapegoogle_core as sg

ROOT = Path(__file__).resolve().parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
RECIPE = (ROOT / "packaging" / "conda" / "recipe.yaml").read_text(encoding="utf-8")
WORKFLOWS = {path.name: path.read_text("utf-8") for path in (ROOT / ".github" / "workflows").glob("*.yml")}


def test_the_recipe_is_of_this_version_and_needs_what_the_project_needs() -> None:
    assert f'version: "{sg.__version__}"' in RECIPE
    run = RECIPE.partition("  run:\n")[2].partition("\n\n")[0]
    needed = [line.strip().removeprefix("- ").replace(" ", "") for line in run.splitlines()][1:]
    # Of a package with an exact version any later one will do: the pin is for Blender.
    assert needed == [requirement.replace("==", ">=") for requirement in PROJECT["project"]["dependencies"]]


@pytest.mark.parametrize(
    ("title", "citation", "tags", "problem"),
    [
        ("0.2.0 (unreleased)", "", [], None),
        ("0.2.0 (2027-01-31)", "date-released: 2027-01-31", ["v0.2.0"], None),
        ("0.2.0 (unreleased)", "", ["v0.2.0"], "is tagged"),
        ("0.2.0 (2027-01-31)", 'date-released: "2027-01-30"', [], "needs 'date-released: 2027-01-31'"),
        ("0.1.0 (2027-01-31)", "date-released: 2027-01-31", [], "begins with '0.1.0"),
    ],
)
def test_a_tagged_version_has_its_date(
    title: str, citation: str, tags: list[str], problem: str | None
) -> None:
    changelog = f"# Changelog\n\n## {title}\n\n## 0.1.0 (2026-12-01)\n"
    if problem is None:
        assert check_release.changelog_title("0.2.0", changelog, citation, tags) == title
    else:
        with pytest.raises(SetupError, match=re.escape(problem)):
            check_release.changelog_title("0.2.0", changelog, citation, tags)


def test_the_hosted_tests_run_on_all_systems_pythons_and_blenders() -> None:
    tests = WORKFLOWS["tests.yml"]
    assert tests.count("system: [ubuntu-latest, windows-latest, macos-latest]") == 2
    for version in ("3.11", "3.12", "3.13"):
        assert f"Programming Language :: Python :: {version}" in PROJECT["project"]["classifiers"]
        assert f'"{version}"' in tests
    (listed,) = re.findall(r"blender: \[(.+)\]", tests)
    assert re.findall(r'"([\d.]+)"', listed) == list(PROJECT["tool"]["shapegoogle"]["blenders"])
    newer = {series for series, known in noxfile.BLENDERS.items() if known["python"] != "3.11"}
    assert set(re.findall(r'- blender: "([\d.]+)"\n\s+python: "3\.13"', tests)) == newer


def test_workflows_run_commands_of_the_repository() -> None:
    commands = re.findall(r"- run: (.+)", "\n".join(WORKFLOWS.values()))
    files = {word for command in commands for word in command.split() if re.search(r"\.py$|^\.ci/", word)}
    assert files == {"scripts/test.py", "scripts/build_extension.py", "scripts/check_release.py", ".ci/run"}
    assert all((ROOT / file).is_file() for file in files)
    sessions = nox.registry.get()
    for series in PROJECT["tool"]["shapegoogle"]["blenders"]:
        assert f"addon-{series}" in sessions


def test_hooks_run_the_commands_of_the_session_checks() -> None:
    hooks = (ROOT / ".pre-commit-config.yaml").read_text(encoding="utf-8")
    source = (
        (ROOT / "noxfile.py").read_text(encoding="utf-8").partition("def checks(")[2].partition("\n\n")[0]
    )
    for tool in ("ruff", "mypy"):
        assert f'"{tool}"' in source
        assert f"entry: python -m {tool}" in hooks


def test_the_model_files_have_a_licence_line() -> None:
    folder = ROOT / "shapegoogle_core" / "model" / "shipped"
    text = (folder / "LICENSE.txt").read_text(encoding="utf-8")
    assert "SPDX-License-Identifier: CC0-1.0" in text
    assert all(path.name in text for path in folder.glob("*.npz"))
    assert "model/shipped/*" in PROJECT["tool"]["setuptools"]["package-data"]["shapegoogle_core"]
    assert f"    - {(folder / 'LICENSE.txt').relative_to(ROOT).as_posix()}\n" in RECIPE
