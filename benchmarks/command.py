# SPDX-License-Identifier: MIT
"""The command `python -m benchmarks SUBCOMMAND …`."""

from __future__ import annotations

import argparse
import importlib
import importlib.util
import sys
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from benchmarks.errors import BenchmarkError
from shapegoogle_core.cli.command import INTERRUPTED, UNUSABLE
from shapegoogle_core.cli.text import say
from shapegoogle_core.errors import ShapeGoogleError
from shapegoogle_core.processes.launching import orderly_end

__all__ = ["COMMANDS", "Command", "check_packages", "main"]

PROGRAM = "python -m benchmarks"

DESCRIPTION = """\
Measure Shape Google, draw the figures of its documentation and train its shipped models.
Run it from the root of the repository, in an environment with the extra "benchmark":
    pip install -e '.[benchmark]'
"""


@dataclass(frozen=True)
class Command:
    """A subcommand.

    Attributes
    ----------
    name : str
    module : str
        Module that has `add_options(parser)` and `run(options)`, which returns the exit code. It is imported
        only when the subcommand is chosen; its docstring is the help text.
    summary : str
        One line for the list of subcommands.
    needs : tuple of str
        Modules that must be importable.
    """

    name: str
    module: str
    summary: str
    needs: tuple[str, ...] = ("skimage",)


COMMANDS = (
    Command(
        "retrieval",
        "benchmarks.experiments.retrieval",
        "find the null shape of transformed and re-posed queries, as in the paper; writes a report",
        ("jinja2", "joblib", "matplotlib", "platformdirs", "skimage"),
    ),
    Command(
        "kinds",
        "benchmarks.kinds.command",
        "find more of the same kind, with and without each part of the search",
        ("joblib", "platformdirs", "skimage"),
    ),
    Command(
        "kinds-picture",
        "benchmarks.kinds.picture",
        "draw what twenty things of the .blend library find",
        ("joblib", "platformdirs", "skimage", "PIL"),
    ),
    Command(
        "suggestions",
        "benchmarks.kinds.suggestions",
        "how often the first suggested folder and word are right",
        ("joblib", "platformdirs", "skimage"),
    ),
    Command(
        "published",
        "benchmarks.published.command",
        "the same on collections as they are distributed: PSB, SHREC'11, SHREC'07, TOSCA",
        ("joblib", "platformdirs", "skimage"),
    ),
    Command(
        "network",
        "benchmarks.network.command",
        "what the small network in the views adds to that",
        ("joblib", "platformdirs", "skimage"),
    ),
    Command("evidence", "benchmarks.experiments.evidence", "how often the evidence of a match is right"),
    Command(
        "unlike", "benchmarks.experiments.unlike", "how often different assets are taken for the same shape"
    ),
    Command("parts", "benchmarks.experiments.parts", "find whole shapes by parts of them"),
    Command(
        "local-heat",
        "benchmarks.experiments.local_heat",
        "find creatures by bent parts of them, by local heat alone",
    ),
    Command("keypoints", "benchmarks.experiments.keypoints", "repeatability of keypoint detectors"),
    Command("correspondence", "benchmarks.experiments.correspondence", "geodesic errors of matched vertices"),
    Command("duplicates", "benchmarks.experiments.duplicates", "recall and time of the duplicate search"),
    Command("tessellation", "benchmarks.experiments.tessellation", "the same surfaces in other triangles"),
    Command("families", "benchmarks.experiments.families", "which shapes a search shows as versions of one"),
    Command("point-clouds", "benchmarks.experiments.point_clouds", "find meshes by scans of them"),
    Command(
        "small-times",
        "benchmarks.experiments.small_times",
        "error and time of heat kernels at small times",
        ("matplotlib", "skimage"),
    ),
    Command(
        "blend-library",
        "benchmarks.experiments.blend_library",
        "index and search a folder of .blend files (needs bpy)",
        ("bpy",),
    ),
    Command(
        "large-scene",
        "benchmarks.experiments.large_scene",
        "link and index scenes of many objects (needs bpy)",
        ("bpy",),
    ),
    Command(
        "pauses",
        "benchmarks.experiments.pauses",
        "how long the window is kept from answering, and how right progress is (needs bpy)",
        ("bpy",),
    ),
    Command(
        "large-mesh",
        "benchmarks.experiments.large_mesh",
        "how long one large mesh keeps the window from answering (needs bpy)",
        ("bpy",),
    ),
    Command(
        "foretold",
        "benchmarks.experiments.foretold",
        "how right the time left is while a file of many objects is indexed (needs bpy)",
        ("bpy",),
    ),
    Command(
        "files",
        "benchmarks.experiments.files.command",
        "read model files with the product and other readers, and list where they differ",
        ("meshio", "trimesh"),
    ),
    Command(
        "speed",
        "benchmarks.speed.command",
        "times of spectra, signatures, search, indexing and the add-on",
    ),
    Command(
        "studio",
        "benchmarks.studio.command",
        "libraries in a database and the service: the same answers, clients, storing, a million shapes",
        ("joblib", "platformdirs", "psycopg", "skimage"),
    ),
    Command(
        "figures",
        "benchmarks.figures.command",
        "draw a figure of the documentation",
    ),
    Command("train", "benchmarks.training.models", "train the shipped models"),
    Command(
        "set-preprocessing",
        "benchmarks.training.preprocessing",
        "give the shipped model the preprocessing of its preset",
    ),
    Command(
        "network-weights",
        "benchmarks.network.weights",
        "write that network for the product from its published weights",
        ("onnx", "torch"),
    ),
    Command("train-views", "benchmarks.training.views", "learn to describe pictures for the shipped model"),
    Command(
        "train-background",
        "benchmarks.training.background",
        "give the shipped model the unlike shapes that tell how distinctive an agreement is",
    ),
    Command("train-ranking", "benchmarks.training.ranking", "teach the shipped model to order by kind"),
    Command("development-set", "benchmarks.training.development_set", "write shapes to develop on"),
    Command(
        "blend-meshes",
        "benchmarks.training.blend_meshes",
        "export meshes of .blend files as .ply (needs bpy)",
        ("bpy",),
    ),
)
"""All subcommands, in the order of the help text."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run a subcommand.

    Parameters
    ----------
    arguments : sequence of str, optional
        Command line without the program's name; the default is that of this process.

    Returns
    -------
    exit_code : int
        0 everything done, 1 some inputs failed, 2 wrong usage, unusable input or missing packages, 130
        interrupted.
    """
    given = sys.argv[1:] if arguments is None else list(arguments)
    chosen = next((argument for argument in given if not argument.startswith("-")), None)
    try:
        options = _parser(chosen).parse_args(given)
        with orderly_end():
            code: int = options.run(options)
    except ShapeGoogleError as error:
        say(f"{PROGRAM} {chosen}: {error}")
        return UNUSABLE
    except KeyboardInterrupt:
        say(f"{PROGRAM} {chosen}: interrupted")
        return INTERRUPTED
    return code


def check_packages(modules: Iterable[str]) -> None:
    """Raise an error that says how to install the modules that are missing.

    Parameters
    ----------
    modules : iterable of str

    Raises
    ------
    BenchmarkError
        If one of them cannot be imported.
    """
    missing = [name for name in modules if importlib.util.find_spec(name) is None]
    if "bpy" in missing:
        raise BenchmarkError(
            f"{sys.executable} has no module bpy; run it with a Python that has Blender as a module: "
            "pip install bpy"
        )
    if missing:
        raise BenchmarkError(f"needs {', '.join(missing)}; install with: pip install -e '.[benchmark]'")


def _parser(chosen: str | None) -> argparse.ArgumentParser:
    """Build the parser; only the chosen subcommand gets its options, for which its module is imported."""
    raw = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser(prog=PROGRAM, description=DESCRIPTION, formatter_class=raw)
    subparsers = parser.add_subparsers(title="subcommands", metavar="SUBCOMMAND", required=True)
    for command in COMMANDS:
        subparser = subparsers.add_parser(command.name, help=command.summary, formatter_class=raw)
        if command.name == chosen:
            check_packages(command.needs)
            module = importlib.import_module(command.module)
            subparser.description = module.__doc__
            module.add_options(subparser)
            subparser.set_defaults(run=module.run)
    return parser
