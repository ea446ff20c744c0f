# SPDX-License-Identifier: MIT
"""Reference pages written from the code: public names by topic, and the commands with their options."""

from __future__ import annotations

import argparse
import ast
import importlib
import textwrap
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from sphinx.application import Sphinx

import shapegoogle_core as sg
from benchmarks import command as benchmarks_command
from shapegoogle_core.cli.parser import build_parser

# Titles of the pages, by the package that names come from, in the order of the pipeline. A package that is
# not listed gets a page under its own name.
TOPICS = {
    "mesh": "Meshes",
    "preprocessing": "Preprocessing",
    "laplacian": "Laplacians",
    "spectral": "Spectra and heat kernels",
    "descriptors": "Descriptors",
    "keypoints": "Keypoints",
    "words": "Words, bags and codes",
    "model": "Models",
    "correspondence": "Correspondence",
    "library": "Libraries and search",
    "indexing": "Indexing",
    "errors": "Errors and warnings",
}
API = Path("reference", "api")
COMMANDS = Path("reference", "commands.rst")


def heading(text: str, line: str) -> str:
    """Write a heading of reStructuredText."""
    return f"{text}\n{line * len(text)}\n\n"


# -- public names -------------------------------------------------------------------------------------------


def names_by_package() -> dict[str, list[str]]:
    """Group the public names of the package by the packages that they come from."""
    stub = Path(sg.__file__).with_name("__init__.pyi").read_text(encoding="utf-8")
    groups: dict[str, list[str]] = defaultdict(list)
    for node in ast.parse(stub).body:
        if isinstance(node, ast.ImportFrom):
            groups[str(node.module).split(".")[1]] += [alias.name for alias in node.names]
    order = [*TOPICS, *sorted(set(groups) - set(TOPICS))]
    return {package: groups[package] for package in order if package in groups}


def topic_page(package: str, names: list[str]) -> str:
    """Write the page of one topic: a table of its names, then each with its whole docstring."""
    summary = " ".join(
        (importlib.import_module(f"shapegoogle_core.{package}").__doc__ or "").split("\n\n")[0].split()
    )
    text = heading(TOPICS.get(package, package.capitalize()), "=") + f"{summary}\n\n"
    text += ".. currentmodule:: shapegoogle_core\n\n.. autosummary::\n   :nosignatures:\n\n"
    text += "".join(f"   {name}\n" for name in sorted(names, key=str.lower)) + "\n"
    for name in sorted(names, key=str.lower):
        is_class = isinstance(getattr(sg, name), type)
        text += heading(name, "-")
        text += f".. auto{'class' if is_class else 'function'}:: {name}\n"
        text += (
            "   :members:\n   :inherited-members: BaseEstimator, Exception, Warning\n\n" if is_class else "\n"
        )
    return text


def api_pages() -> Iterator[tuple[Path, str]]:
    """Write the pages of the Python package, and the list of them."""
    groups = names_by_package()
    text = heading("Python", "=")
    text += "Every name below is used as ``import shapegoogle_core as sg``, then ``sg.name``. "
    text += "Functions that take a mesh also take a tuple ``(vertices, faces)`` or an object that has them, "
    text += "such as a mesh of trimesh.\n\n.. toctree::\n   :maxdepth: 2\n\n"
    text += "".join(f"   {package}\n" for package in groups)
    yield API / "index.rst", text
    for package, names in groups.items():
        yield API / f"{package}.rst", topic_page(package, names)


# -- commands -----------------------------------------------------------------------------------------------


def option_text(parser: argparse.ArgumentParser, action: argparse.Action) -> str:
    """Write one option or argument of a command."""
    shown = parser.formatter_class(prog="")._format_args(action, (action.dest or "").upper())
    names = [f"{name} {shown}".strip() for name in action.option_strings] or [shown]
    explained = " ".join(str(parser._get_formatter()._expand_help(action)).split()) if action.help else ""
    return f".. option:: {', '.join(names)}\n\n" + textwrap.indent(literal_safe(explained), "   ") + "\n\n"


def literal_safe(text: str) -> str:
    """Escape what reStructuredText would take for markup; keep code in backticks as code."""
    parts = text.split("`")
    for place in range(0, len(parts), 2):
        for character in "\\*_|":
            parts[place] = parts[place].replace(character, f"\\{character}")
    return "``".join(parts)


def command_section(name: str, parser: argparse.ArgumentParser) -> str:
    """Write the section of one command."""
    text = heading(name, "-") + f".. program:: {parser.prog}\n\n{literal_safe(parser.description or '')}\n\n"
    usage = parser.format_usage().removeprefix("usage: ")
    text += ".. code-block:: none\n\n" + textwrap.indent(textwrap.dedent(usage), "   ") + "\n"
    for action in parser._actions:
        if action.help != argparse.SUPPRESS and action.dest != "help":
            text += option_text(parser, action)
    details = (parser.epilog or "").strip()
    if details:
        text += ".. code-block:: none\n\n" + textwrap.indent(details, "   ") + "\n\n"
    return text


def commands_page() -> str:
    """Write the page of all commands."""
    parser = build_parser()
    subparsers = next(each for each in parser._actions if isinstance(each, argparse._SubParsersAction))
    text = heading("Commands", "=")
    text += (
        "``shapegoogle COMMAND`` works on libraries and mesh files. ``blender --command shape_google`` with "
        "the same commands reads .blend files, too. ``python -m shapegoogle_core`` is the same.\n\n"
    )
    text += "".join(command_section(f"shapegoogle {name}", each) for name, each in subparsers.choices.items())
    text += heading("python -m benchmarks", "-")
    text += (
        "Measures the search, draws figures and trains the shipped models. It is part of the repository, not "
        "of the package. Each subcommand has ``--help``.\n\n"
    )
    for command in benchmarks_command.COMMANDS:
        text += f"``{command.name}``\n   {literal_safe(command.summary)}\n\n"
    return text


# -- writing ------------------------------------------------------------------------------------------------


def write_pages(app: Sphinx) -> None:
    """Write all pages before Sphinx looks for sources; unchanged ones are left alone."""
    for path, text in [*api_pages(), (COMMANDS, commands_page())]:
        target = Path(app.srcdir) / path
        target.parent.mkdir(parents=True, exist_ok=True)
        if not target.exists() or target.read_text(encoding="utf-8") != text:
            target.write_text(text, encoding="utf-8")


def keep_bars(app: Sphinx, what: str, name: str, item: object, options: object, lines: list[str]) -> None:
    """Escape the bars of absolute values in a docstring, which would mean substitutions."""
    lines[:] = [
        line if line.lstrip().startswith((">>>", "...")) else line.replace("|", "\\|") for line in lines
    ]


def is_foreign(app: Sphinx, what: str, name: str, item: object, skip: bool, options: object) -> bool | None:
    """Leave out what estimators inherit from scikit-learn."""
    return True if str(getattr(item, "__module__", "")).startswith("sklearn") else None


def setup(app: Sphinx) -> dict[str, Any]:
    """Connect to the start of a build and to the reading of docstrings."""
    app.connect("builder-inited", write_pages)
    app.connect("autodoc-process-docstring", keep_bars)
    app.connect("autodoc-skip-member", is_foreign)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
