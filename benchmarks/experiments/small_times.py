# SPDX-License-Identifier: MIT
"""Compare heat kernels from resolvents with truncated spectra and with full decompositions.

    python -m benchmarks small-times [--sizes N ...] [--dense N] [--repeats N] [--plot FILE]

Prints the tables of docs/measurements/small_times.md: seconds of processor time, and the largest relative
error of K_t(x, x) over all vertices of a procedural creature, at times from a quarter of the mean area of a
vertex on, two per octave. The truth is the full decomposition, for meshes of at most --dense vertices.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import TypeVar

import matplotlib as mpl
import numpy as np
import scipy.linalg
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, NullLocator
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

import shapegoogle_core as sg
from benchmarks.creatures import make_creature
from shapegoogle_core.cli.arguments import number_from
from shapegoogle_core.preprocessing import repair
from shapegoogle_core.spectral import operator_spectrum

Array = NDArray[np.float64]

T = TypeVar("T")

__all__ = ["add_options", "run"]

KIND, SEED = "dog", 100
EIGENPAIRS = (100, 300, 500)
# In mean areas of a vertex; the last is beyond the reach of 100 eigenpairs of a mesh of 10,000 vertices.
TIMES = [2.0 ** (half / 2) for half in range(-4, 18)]
RESOLVENTS, COLUMN, DENSE = "resolvents", "one column", "full decomposition"


@dataclass
class Measured:
    """Measurements on one mesh.

    Attributes
    ----------
    vertices : int
    seconds : dict of str to float
        By method.
    errors : dict of str to (t,) array
        By method, the largest relative error at each of `TIMES`.
    """

    vertices: int
    seconds: dict[str, float] = field(default_factory=dict)
    errors: dict[str, Array] = field(default_factory=dict)


def timed(work: Callable[[], T]) -> tuple[T, float]:
    """Call a function; return its result and the seconds of processor time."""
    started = time.process_time()
    result = work()
    return result, time.process_time() - started


def measure(size: int, repeats: int, dense: bool) -> Measured:
    """Compute the signature of a creature with each method in turn, and take the median times."""
    mesh = repair(make_creature(KIND, SEED, size).rest)
    operator = sg.build_operator(mesh)
    n = len(mesh.vertices)
    times = np.array(TIMES) * mesh.area / n

    def truncated(k: int) -> Array:
        return sg.heat_kernel_signature(operator_spectrum(operator, k), times)

    ways: dict[str, Callable[[], Array]] = {
        RESOLVENTS: lambda: sg.heat_kernel_signature(operator, times, method="rational"),
        COLUMN: lambda: sg.heat_kernel(operator, 0, times[len(times) // 2], method="rational"),
        **{f"k = {k}": lambda k=k: truncated(k) for k in EIGENPAIRS if k < n // 2},  # type: ignore[misc]
    }
    measured = Measured(n)
    values: dict[str, Array] = {}
    seconds: dict[str, list[float]] = {name: [] for name in ways}
    for _ in range(repeats):
        for name, work in ways.items():
            values[name], took = timed(work)
            seconds[name].append(took)
    measured.seconds = {name: float(np.median(took)) for name, took in seconds.items()}
    if dense:
        stiffness, mass = operator.stiffness.toarray(), operator.mass.toarray()
        pairs, measured.seconds[DENSE] = timed(lambda: scipy.linalg.eigh(stiffness, mass, overwrite_a=True))
        truth = pairs[1] ** 2 @ np.exp(-np.outer(np.maximum(pairs[0], 0), times))
        measured.errors = {
            name: np.abs(values[name] / truth - 1).max(axis=0) for name in values if name != COLUMN
        }
    return measured


def print_tables(results: list[Measured]) -> None:
    """Print the seconds on all meshes, and the errors on the largest with a full decomposition."""
    names = [RESOLVENTS, COLUMN, *(f"k = {k}" for k in EIGENPAIRS), DENSE]
    print("| vertices | " + " | ".join(names) + " |")
    print("|---" * (len(names) + 1) + "|")
    for result in results:
        cells = [f"{result.seconds[name]:.2f}" if name in result.seconds else "–" for name in names]
        print(f"| {result.vertices:,} | " + " | ".join(cells) + " |")
    known = [result for result in results if result.errors]
    if known:
        errors = known[-1].errors
        print(f"\n{known[-1].vertices:,} vertices: largest error")
        print("| t / vertex area | " + " | ".join(errors) + " |")
        print("|---" * (len(errors) + 1) + "|")
        for index in range(0, len(TIMES), 2):
            cells = [f"{values[index]:.1e}" for values in errors.values()]
            print(f"| {TIMES[index]:g} | " + " | ".join(cells) + " |")


def plot(results: list[Measured], path: Path) -> None:
    """Plot errors against times, and seconds against vertices."""
    mpl.rcParams.update({"font.size": 10, "axes.spines.top": False, "axes.spines.right": False})
    figure = Figure(figsize=(10, 4), layout="constrained")
    left, right = figure.subplots(1, 2)
    names = [*(f"k = {k}" for k in EIGENPAIRS), DENSE, RESOLVENTS]
    colors = dict(zip(names, ["#a6bddb", "#67a9cf", "#1c7099", "#888888", "#d9480f"], strict=True))
    known = [result for result in results if result.errors]
    if known:
        for name, errors in known[-1].errors.items():
            left.loglog(TIMES, errors, color=colors[name], label=name, linewidth=2)
        left.set_ylim(bottom=1e-7)
        left.axhline(0.01, color="#444444", linewidth=0.8, linestyle=":")
        left.text(TIMES[-1], 0.012, "1 %", ha="right", va="bottom", color="#444444")
        left.set(xlabel="t / mean area of a vertex", ylabel="largest relative error of K_t(x, x)")
        left.set_title(f"{known[-1].vertices:,} vertices", loc="left")
        left.legend(frameon=False, loc="lower left")
    for name in names:
        points = [(result.vertices, result.seconds[name]) for result in results if name in result.seconds]
        if points:
            right.loglog(*zip(*points, strict=True), "o-", color=colors[name], label=name, linewidth=2)
    right.set(xlabel="vertices", ylabel="seconds of processor time")
    right.set_title(f"K_t(x, x) of all vertices at {len(TIMES)} times", loc="left")
    right.set_xticks([result.vertices for result in results])
    right.xaxis.set_minor_locator(NullLocator())
    right.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:,.0f}"))
    right.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    right.legend(frameon=False, loc="upper left")
    figure.savefig(path, dpi=110)


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of the subcommand.

    Parameters
    ----------
    parser : argparse.ArgumentParser
    """
    parser.add_argument(
        "--sizes",
        type=number_from(1),
        nargs="+",
        default=[1000, 2000, 5000, 10000],
        metavar="N",
        help="numbers of vertices (%(default)s)",
    )
    parser.add_argument(
        "--dense", type=int, default=5000, metavar="N", help="largest full decomposition (%(default)s)"
    )
    parser.add_argument(
        "--repeats", type=number_from(1), default=3, metavar="N", help="repetitions (%(default)s)"
    )
    parser.add_argument("--plot", type=Path, metavar="FILE", help="write the figure, such as a .png")


def run(options: argparse.Namespace) -> int:
    """Measure all sizes, print the tables and draw the figure.

    Parameters
    ----------
    options : argparse.Namespace
        As from `add_options`.

    Returns
    -------
    exit_code : int
    """
    results = []
    for size in sorted(options.sizes):
        with threadpool_limits(1):  # so that processor times are comparable
            results.append(measure(size, options.repeats, size <= options.dense))
        print(f"{size} vertices measured", file=sys.stderr, flush=True)
    print_tables(results)
    if options.plot is not None:
        plot(results, options.plot)
    return 0
