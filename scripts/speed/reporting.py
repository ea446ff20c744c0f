# SPDX-License-Identifier: MIT
"""The table, the JSON file and the plots of `benchmark_speed.py`."""

from __future__ import annotations

import json
import platform
from collections.abc import Sequence
from dataclasses import asdict
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from speed.measuring import Row

__all__ = ["table", "write_report"]

# Whose versions belong to the numbers.
PACKAGES = ("numpy", "scipy", "shapegoogle-core", "lapy", "cholespy", "pyfmaps")


def table(rows: Sequence[Row]) -> str:
    """Lay the rows out in columns; a ratio above 1 is slower than the first contestant."""
    lines = [
        f"{'section':9}{'task':22}{'size':>9}  {'contestant':24}{'s':>9}{'CPU s':>9}{'ratio':>8}{'error':>10}"
    ]
    for row in rows:
        error = "" if row.error is None else f"{row.error:.1e}"
        lines.append(
            f"{row.section:9}{row.task:22}{row.size:9,}  {row.contestant:24}"
            f"{row.seconds:9.3f}{row.cpu_seconds:9.3f}{row.ratio:8.2f}{error:>10}"
        )
    return "\n".join(lines)


def write_report(rows: Sequence[Row], folder: Path) -> list[Path]:
    """Write `speed.json`, and `speed-SECTION.png` for each section.

    Parameters
    ----------
    rows : sequence of Row
    folder : Path
        Is made if there is none.

    Returns
    -------
    paths : list of Path
        What was written.
    """
    folder.mkdir(parents=True, exist_ok=True)
    data = {
        "python": platform.python_version(),
        "machine": platform.machine(),
        "packages": {name: found for name in PACKAGES if (found := _version(name))},
        "rows": [asdict(row) for row in rows],
    }
    written = [folder / "speed.json"]
    written[0].write_text(json.dumps(data, indent=1) + "\n", encoding="utf-8")
    for section in dict.fromkeys(row.section for row in rows):
        written.append(folder / f"speed-{section}.png")
        _plot([row for row in rows if row.section == section], written[-1])
    return written


def _version(package: str) -> str | None:
    try:
        return version(package)
    except PackageNotFoundError:
        return None


def _plot(rows: Sequence[Row], path: Path) -> None:
    """Draw processor time over size, a panel for each task and a line for each contestant."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    tasks = list(dict.fromkeys(row.task for row in rows))
    figure = Figure(figsize=(5.5 * len(tasks), 4.2), layout="constrained")
    panels = figure.subplots(1, len(tasks), squeeze=False)[0]
    for panel, task in zip(panels, tasks, strict=True):
        members = [row for row in rows if row.task == task]
        for name in dict.fromkeys(row.contestant for row in members):
            line = sorted((row.size, row.cpu_seconds) for row in members if row.contestant == name)
            panel.loglog(*zip(*line, strict=True), marker="o", label=name)
        panel.set(title=task, xlabel="size", ylabel="processor time, s")
        panel.grid(visible=True, which="both", alpha=0.3)
        panel.legend()
    FigureCanvasAgg(figure)
    figure.savefig(path)
