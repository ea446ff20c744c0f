# SPDX-License-Identifier: MIT
"""JSON files and figures of `python -m benchmarks speed`."""

from __future__ import annotations

import json
import platform
from collections.abc import Sequence
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import TYPE_CHECKING, Any

from benchmarks.speed.measuring import Row

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["label", "line", "panels", "write_figure", "write_rows"]

# Packages whose versions are stored with the figures.
PACKAGES = ("numpy", "scipy", "shapegoogle-core", "lapy", "cholespy", "pyfmaps")


def line(row: Row) -> str:
    """Format a row as a line of JSON, without its lists.

    Parameters
    ----------
    row : dict

    Returns
    -------
    line : str
    """
    return json.dumps({name: value for name, value in row.items() if not isinstance(value, list)})


def write_rows(section: str, rows: Sequence[Row], folder: Path) -> Path:
    """Write `speed-SECTION.json` into a folder.

    Parameters
    ----------
    section : str
    rows : sequence of dict
    folder : Path

    Returns
    -------
    path : Path
    """
    data = {
        "python": platform.python_version(),
        "machine": platform.machine(),
        "packages": {name: found for name in PACKAGES if (found := _version(name))},
        "rows": list(rows),
    }
    path = folder / f"speed-{section}.json"
    path.write_text(json.dumps(data, indent=1) + "\n", encoding="utf-8")
    return path


def write_figure(section: str, figure: Figure, folder: Path) -> Path:
    """Write `speed-SECTION.png` into a folder.

    Parameters
    ----------
    section : str
    figure : matplotlib.figure.Figure
    folder : Path

    Returns
    -------
    path : Path
    """
    path = folder / f"speed-{section}.png"
    figure.savefig(path, dpi=120)
    return path


def panels(count: int, width: float, height: float) -> tuple[Figure, list[Any]]:
    """Make a figure of panels side by side.

    Parameters
    ----------
    count : int
    width, height : float
        Of the figure, in inches.

    Returns
    -------
    figure : matplotlib.figure.Figure
    axes : list of matplotlib.axes.Axes
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, height), layout="constrained")
    FigureCanvasAgg(figure)
    return figure, list(figure.subplots(1, count, squeeze=False)[0])


def label(axes: Any) -> None:
    """Add a grid, and a legend with each name once.

    Parameters
    ----------
    axes : matplotlib.axes.Axes
    """
    axes.grid(visible=True, which="both", alpha=0.3)
    handles, names = axes.get_legend_handles_labels()
    once = dict(zip(names, handles, strict=True))
    if once:
        axes.legend(once.values(), once.keys(), fontsize="small")


def _version(package: str) -> str | None:
    try:
        return version(package)
    except PackageNotFoundError:
        return None
