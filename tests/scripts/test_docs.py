# SPDX-License-Identifier: MIT
"""The documentation: its links, the names it mentions, and its examples."""

from __future__ import annotations

import dataclasses
import importlib
import importlib.util
import re
import shlex
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from fractions import Fraction
from functools import partial
from pathlib import Path

import numpy as np
import pytest
import trimesh
from lib import bootstrap

import shapegoogle_core as sg
from benchmarks import command as benchmarks_command
from shapegoogle_core import model
from shapegoogle_core.cli import parser as core_parser
from shapegoogle_core.correspondence import SurfaceSettings
from shapegoogle_core.descriptors import DESCRIPTORS
from shapegoogle_core.keypoints import DETECTORS
from shapegoogle_core.laplacian import LAPLACIANS

ROOT = Path(__file__).resolve().parents[2]
MEASUREMENTS = ROOT / "docs" / "measurements"
# Pages of the site that its build writes from the code and the examples.
GENERATED = {
    ROOT / "docs" / name
    for name in (
        "gallery/index.rst",
        "reference/api/index.rst",
        "reference/commands.rst",
        "reference/addresses.rst",
    )
}
PAGES = [
    *(
        ROOT / name
        for name in ("README.md", "CONTRIBUTING.md", "CHANGELOG.md", "PUBLISHING.md", "SECURITY.md")
    ),
    *sorted(path for path in (ROOT / "docs").rglob("*.md") if not {"_build", "gallery"} & {*path.parts}),
]
# Code runs in Blender, where tests/addon/test_manual.py runs it.
IN_BLENDER = "docs/blender/index.md"
# The changelog also names what is gone.
TODAY = [page for page in PAGES if page.name != "CHANGELOG.md"]
OF_BLENDER = {"Edit › Preferences › Get Extensions", "Install from Disk…"}
PACKAGES = ("shapegoogle_core", "benchmarks", "blender_addon", "scripts", "tests", "docs")
# Paths are relative to one of these folders.
ROOTS = (ROOT, ROOT / "shapegoogle_core", ROOT / "shapegoogle_core" / "library")
SHAPEGOOGLE, BENCHMARKS = ("shapegoogle",), ("python", "-m", "benchmarks")
PROGRAMS = (SHAPEGOOGLE, BENCHMARKS)


class ParsedError(Exception):
    """Raised by a script once it has parsed its options, in place of what it does."""


@dataclass(frozen=True)
class CodeBlock:
    """A fenced block of a page.

    Attributes
    ----------
    language : str
        What follows the opening fence; may be empty.
    text : str
    line : int
        Number of its first line.
    """

    language: str
    text: str
    line: int


def name_of(page: Path) -> str:
    return page.relative_to(ROOT).as_posix()


def code_blocks(page: Path) -> list[CodeBlock]:
    text = page.read_text(encoding="utf-8")
    return [
        CodeBlock(match[1], match[2], text.count("\n", 0, match.start()) + 2)
        for match in re.finditer(r"^```(\w*)\n(.*?)^```$", text, re.DOTALL | re.MULTILINE)
    ]


def prose(page: Path) -> str:
    return re.sub(r"^```.*?^```$", "", page.read_text(encoding="utf-8"), flags=re.DOTALL | re.MULTILINE)


def code_spans(page: Path) -> list[str]:
    """Code in the lines of a page, in single backticks."""
    return [" ".join(span.split()) for span in re.findall(r"`([^`]+)`", prose(page))]


def anchors(page: Path) -> set[str]:
    """Anchors of the headings of a page, as GitHub makes them."""
    found: set[str] = set()
    for title in re.findall(r"^#+ +(.+)$", prose(page), re.MULTILINE):
        slug = re.sub(r"[^\w\- ]", "", title.strip().lower()).replace(" ", "-")
        number = 0
        while (anchor := f"{slug}-{number}" if number else slug) in found:
            number += 1
        found.add(anchor)
    return found


def commands(page: Path) -> Iterator[tuple[list[str], int]]:
    """Words of each command in the code blocks of a page that this repository parses, with its line."""
    for block in code_blocks(page):
        if block.language == "python":
            continue
        for offset, line in enumerate(block.text.replace("\\\n", "  ").splitlines()):
            words = shlex.split(re.sub(r"[][]", "", line), comments=True)
            stops = [index for index, word in enumerate(words) if word in ("|", ">", "&&")]
            words = words[: min(stops, default=len(words))]
            if any(tuple(words[: len(program)]) == program for program in PROGRAMS) or (
                words[:1] == ["python3"] and words[1].startswith("scripts/")
            ):
                # A placeholder for a number
                yield ["1" if word == "N" else word for word in words], block.line + offset


def check_script(words: list[str], monkeypatch: pytest.MonkeyPatch) -> None:
    """Let a script of the repository parse its options."""
    path = ROOT / words[1]
    spec = importlib.util.spec_from_file_location(f"documented_{path.stem}", path)
    assert spec is not None
    assert spec.loader is not None
    script = importlib.util.module_from_spec(spec)
    monkeypatch.setitem(sys.modules, spec.name, script)
    spec.loader.exec_module(script)

    def stop(extras: list[str]) -> None:
        raise ParsedError

    monkeypatch.setattr(bootstrap, "enter", stop)
    with pytest.raises(ParsedError):
        script.main(words[2:])
    for word in words[2:]:
        assert "/" not in word or (ROOT / word.partition("::")[0]).exists(), word


@pytest.fixture
def parse(monkeypatch: pytest.MonkeyPatch) -> Callable[[list[str]], int]:
    """Function that parses a command line of this repository without running it."""
    idle = tuple(dataclasses.replace(each, run=lambda options: 0) for each in core_parser.COMMANDS)
    monkeypatch.setattr(core_parser, "COMMANDS", idle)
    # Options are parsed whether or not Blender and the other packages are installed.
    monkeypatch.setattr(benchmarks_command, "check_packages", lambda modules: None)

    def run(words: list[str]) -> int:
        if tuple(words[:1]) == SHAPEGOOGLE:
            return core_parser.main(words[1:])
        modules = {each.name: each.module for each in benchmarks_command.COMMANDS}
        if words[3] in modules:
            module = importlib.import_module(modules[words[3]])
            monkeypatch.setattr(module, "run", lambda options: 0)
        return benchmarks_command.main(words[3:])

    return run


@pytest.mark.parametrize("page", PAGES, ids=name_of)
def test_links_lead_somewhere(page: Path) -> None:
    broken = []
    for target in re.findall(r"\]\(([^)\s]+)\)", prose(page)):
        if re.match(r"[a-z]+:", target):
            continue
        path, _, anchor = target.partition("#")
        linked = (page.parent / path).resolve() if path else page
        if linked in GENERATED:
            continue
        if not linked.exists() or (anchor and anchor not in anchors(linked)):
            broken.append(target)
    assert not broken


@pytest.mark.parametrize("page", TODAY, ids=name_of)
def test_paths_and_names_exist(page: Path) -> None:
    missing = []
    for span in code_spans(page):
        first, slash, _ = span.partition("/")
        is_path = re.fullmatch(r"[\w./-]+", span) and slash
        if (
            is_path
            and (first in PACKAGES or span.endswith((".py", "/")))
            and not any((root / span).exists() for root in ROOTS)
        ):
            missing.append(span)
        if match := re.match(r"(?:sg|shapegoogle_core)((?:\.\w+)+)", span):
            # A module, or a name in one; submodules are imported on the way.
            item: object = sg
            dotted = "shapegoogle_core"
            for part in match[1][1:].split("."):
                dotted += f".{part}"
                if hasattr(item, "__path__") and importlib.util.find_spec(dotted) is not None:
                    importlib.import_module(dotted)
                item = getattr(item, part, None)
            if item is None:
                missing.append(span)
        elif (match := re.match(r"([A-Z]\w+)\.([a-z]\w+)", span)) and not (ROOT / span).exists():
            owner = getattr(sg, match[1], None) or getattr(model, match[1], None)
            known = owner is not None and (
                hasattr(owner, match[2]) or match[2] in getattr(owner, "__annotations__", {})
            )
            if not known:
                missing.append(span)
    assert not missing


def table_names(page: str) -> set[str]:
    """Names in backticks in the first column of the tables of a page."""
    rows = re.findall(r"^\| `([\w-]+)` \|", (ROOT / "docs" / page).read_text(encoding="utf-8"), re.MULTILINE)
    return set(rows)


def test_tables_name_every_operator_descriptor_and_detector() -> None:
    assert table_names("concepts/operators.md") == {*LAPLACIANS}
    assert table_names("concepts/descriptors.md") == {*DESCRIPTORS.own}
    assert table_names("concepts/keypoints.md") == {*DETECTORS.own}


def test_settings_of_the_search_have_the_documented_values() -> None:
    text = (MEASUREMENTS / "search.md").read_text(encoding="utf-8")
    rows = re.findall(r"^(?:\| |- \*\*)(`[^|]+?) (?:\||=) ([\d., /]+?)(?: \||\.\*\*)", text, re.MULTILINE)
    values = {
        name: float(Fraction(value))
        for names, row in rows
        for name, value in zip(re.findall(r"`(\w+)`", names), row.split(", "), strict=True)
    }
    assert "certain" in values
    groups = dataclasses.asdict(sg.SearchSettings()).values()
    defaults = {name: value for group in groups for name, value in group.items()}
    assert values == {name: defaults[name] for name in values}


def test_labels_in_the_manual_are_those_of_the_add_on() -> None:
    source = "\n".join(path.read_text(encoding="utf-8") for path in (ROOT / "blender_addon").rglob("*.py"))
    manual = re.sub(r"\*\*.+?\*\*", "", prose(ROOT / IN_BLENDER), flags=re.DOTALL)
    labels = {" ".join(label.split()) for label in re.findall(r"\*([A-Z][^*]+)\*", manual)}
    assert "Find Similar" in labels
    assert {label for label in labels - OF_BLENDER if f'"{label}"' not in source} == set()


def test_every_equation_of_the_paper_has_its_function() -> None:
    text = (ROOT / "docs" / "reference" / "equations.md").read_text(encoding="utf-8")
    rows = [
        row.strip("| ").split(" | ") for row in re.findall(r"^\| (?:algorithm )?\d.*", text, re.MULTILINE)
    ]
    numbered = {number for first, *_ in rows for number in first.split(", ") if "." not in number}
    assert numbered >= {*map(str, range(1, 22)), "algorithm 1", "algorithm 2"}
    # That the functions exist is checked for every page above.
    assert all("`" in row[-1] for row in rows)


def test_pages_that_the_code_refers_to_exist() -> None:
    sources = [path for package in PACKAGES for path in (ROOT / package).rglob("*.py")]
    pages = {
        page
        for path in sources
        for page in re.findall(r"\bdocs/[\w/]+\.(?:md|png)", path.read_text(encoding="utf-8"))
    }
    assert pages
    assert {page for page in pages if not (ROOT / page).is_file()} == set()


def test_every_page_of_measurements_is_listed() -> None:
    listed = set(re.findall(r"\]\(([\w]+\.md)\)", (MEASUREMENTS / "README.md").read_text(encoding="utf-8")))
    assert listed == {page.name for page in MEASUREMENTS.glob("*.md")} - {"README.md"}


@pytest.mark.parametrize("page", PAGES, ids=name_of)
def test_python_code_compiles(page: Path) -> None:
    for block in code_blocks(page):
        if block.language == "python":
            compile("\n" * (block.line - 1) + block.text, str(page), "exec")


@pytest.mark.parametrize(
    "page",
    [
        page
        for page in PAGES
        if name_of(page) != IN_BLENDER and any(block.language == "python" for block in code_blocks(page))
    ],
    ids=name_of,
)
def test_python_code_runs(page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    sphere = trimesh.creation.icosphere(2)
    sphere.vertices[:, 0] *= 1 + 0.5 * sphere.vertices[:, 2]
    for name in ("horse.ply", "unknown.glb"):
        sphere.export(tmp_path / name)
    monkeypatch.chdir(tmp_path)
    # As on the page, but seconds quicker.
    coarse = SurfaceSettings(floor=300, budget=600, eigenpairs=60, samples=300, compared=100)
    monkeypatch.setattr(sg, "match_vertices", partial(sg.match_vertices, settings=coarse))
    mesh = sg.Mesh(np.asarray(sphere.vertices), np.asarray(sphere.faces), "horse")
    names = {
        "sg": sg,
        "mesh": mesh,
        "a": mesh,
        "b": mesh,
        "values_on_b": mesh.vertices,
        "times": np.array([0.1, 0.2]),
        "time": 0.1,
        "source": 0,
    }
    for block in code_blocks(page):
        if block.language == "python":
            exec(compile("\n" * (block.line - 1) + block.text, str(page), "exec"), names)


@pytest.mark.parametrize("page", PAGES, ids=name_of)
def test_command_lines_parse(
    page: Path,
    parse: Callable[[list[str]], int],
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    pytest.importorskip("skimage")
    pytest.importorskip("jinja2")
    for words, line in commands(page):
        if words[0] == "python3":
            check_script(words, monkeypatch)
            continue
        try:
            code = parse(words)
        except SystemExit as error:
            code = 0 if error.code is None else int(error.code)
        assert code == 0, f"line {line}: {shlex.join(words)}\n{capsys.readouterr().err}"


@pytest.mark.parametrize("page", TODAY, ids=name_of)
def test_commands_in_prose_have_the_options_named(
    page: Path, parse: Callable[[list[str]], int], capsys: pytest.CaptureFixture[str]
) -> None:
    pytest.importorskip("skimage")
    pytest.importorskip("jinja2")
    for span in code_spans(page):
        words = span.split()
        program = next((each for each in PROGRAMS if tuple(words[: len(each)]) == each), None)
        # Not a placeholder in capitals
        if program is None or not re.fullmatch("[a-z-]*[a-z]", " ".join(words[len(program) :][:1])):
            continue
        with pytest.raises(SystemExit) as caught:
            parse([*words[: len(program) + 1], "--help"])
        assert caught.value.code == 0, span
        offered = set(re.findall(r"--[a-z][\w-]*", capsys.readouterr().out))
        assert {word for word in words if word.startswith("--")} <= offered, span
