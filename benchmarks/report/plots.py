# SPDX-License-Identifier: MIT
"""Plots of the report, as SVG files in matplotlib's own style."""

from __future__ import annotations

import base64
import io
import math
import textwrap
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator, FuncFormatter, NullLocator

from benchmarks.protocol.metrics import STRENGTHS
from benchmarks.protocol.results import VariantResult

__all__ = [
    "SERIES",
    "Plot",
    "bit_plots",
    "precision_recall_plot",
    "roc_plot",
    "strength_plots",
    "vocabulary_plots",
]

# Series differ in markers too: some printers and some readers do not distinguish colours.
_MARKERS = ("o", "s", "^", "D", "v", "P")
_DASHES = ("-", "--", ":")

SERIES = tuple(
    zip((mpl.colors.to_hex(f"C{number}") for number in range(len(_MARKERS))), "●■▲◆▼✚", strict=True)
)
"""Colour and marker of each series, the marker as a character."""

_BACKGROUND = "#f4f5f7"
"""Readable on light and on dark pages."""

_SUPERSCRIPT = str.maketrans("0123456789", "⁰¹²³⁴⁵⁶⁷⁸⁹")

_STYLE: dict[Any, Any] = {
    "svg.fonttype": "none",  # text stays text
    "text.parse_math": False,  # names are not formulas
    "font.size": 9,
    "figure.facecolor": _BACKGROUND,
    "axes.facecolor": _BACKGROUND,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.linewidth": 0.5,
    "legend.frameon": False,
    "lines.markersize": 4,
}


@dataclass(frozen=True)
class Plot:
    """A plot of the report.

    Attributes
    ----------
    title : str
    svg : str
        An SVG file.
    """

    title: str
    svg: str

    @property
    def source(self) -> str:
        """The file as a data URL, for an image element."""
        return "data:image/svg+xml;base64," + base64.b64encode(self.svg.encode()).decode("ascii")


@dataclass(frozen=True)
class _Line:
    """One line of a plot and its label in the legend."""

    label: str
    x: Sequence[float]
    y: Sequence[float]
    series: int
    markers: bool = True


def strength_plots(variants: Sequence[VariantResult], classes: Sequence[str]) -> list[Plot]:
    """Plot mean average precision against strength, one small plot for each class.

    Parameters
    ----------
    variants : sequence of VariantResult
        At most as many as `SERIES`; each has the colour and the marker of its position.
    classes : sequence of str

    Returns
    -------
    plots : list of Plot
        All with the same scale, without legends.
    """
    rows = [variant.table[name] for variant in variants for name in classes if name in variant.table]
    low = _floor([value for row in rows for value in row])

    def plot(name: str) -> Plot:
        def draw(axes: Axes) -> None:
            for number, variant in enumerate(variants):
                if name in variant.table:
                    _draw_line(axes, _Line(variant.name, STRENGTHS, variant.table[name], number))
            axes.set(xlim=(0.8, 5.2), ylim=(low - 2, 102), xticks=STRENGTHS)

        return _plot(name.replace("_", " "), (2.7, 1.9), draw)

    return [plot(name) for name in classes]


def precision_recall_plot(variants: Sequence[VariantResult]) -> Plot | None:
    """Plot precision against recall.

    Parameters
    ----------
    variants : sequence of VariantResult
        At most as many as `SERIES`.

    Returns
    -------
    plot : Plot or None
        None if no variant has a curve.
    """
    lines = [
        _Line(variant.name, *_columns(variant.precision_recall), number, markers=False)
        for number, variant in enumerate(variants)
        if variant.precision_recall
    ]

    def draw(axes: Axes) -> None:
        for line in lines:
            _draw_line(axes, line)
        axes.set(xlim=(0, 1), ylim=(0, 1.02), xlabel="recall", ylabel="precision")
        _add_legend(axes)

    return _plot("Precision and recall", (6, 3.3), draw) if lines else None


def roc_plot(variants: Sequence[VariantResult]) -> Plot | None:
    """Plot the receiver operating characteristic on a logarithmic axis, with its equal error rate.

    Parameters
    ----------
    variants : sequence of VariantResult
        At most as many as `SERIES`.

    Returns
    -------
    plot : Plot or None
        None if no variant has a curve.
    """
    drawn = [(number, variant) for number, variant in enumerate(variants) if len(variant.roc) > 1]
    if not drawn:
        return None
    positive = [x for _, variant in drawn for x, _ in variant.roc if x > 0]
    least = 10 ** math.floor(math.log10(min(positive)))
    low = _floor([100 * y for _, variant in drawn for x, y in variant.roc if x >= 10 * least]) / 100

    def draw(axes: Axes) -> None:
        axes.set_xscale("log")
        axes.set(xlim=(least, 1), ylim=(low, 1 + 0.02 * (1 - low)))
        axes.set(xlabel="false positive rate", ylabel="true positive rate")
        rates = np.geomspace(least, 1, 200)
        axes.plot(rates, 1 - rates, color="gray", lw=0.8, ls=":", scalex=False, scaley=False)
        axes.xaxis.set_major_formatter(FuncFormatter(_decimal))
        axes.xaxis.set_minor_locator(NullLocator())
        for number, variant in drawn:
            x, y = _columns(variant.roc)
            rate = variant.equal_error_rate
            label = variant.name if math.isnan(rate) else f"{variant.name} ({100 * rate:.2g}\u00a0%)"
            _draw_line(axes, _Line(label, np.maximum(x, least).tolist(), y, number, markers=False))
            if rate > 0 and 1 - rate >= low:
                axes.plot(rate, 1 - rate, color=SERIES[number][0], marker=_MARKERS[number], ms=7, mec="white")
        _add_legend(axes)

    return _plot("ROC, with equal error rates", (6, 3.3), draw)


def vocabulary_plots(variants: Sequence[VariantResult]) -> list[Plot]:
    """Plot mean average precision against the number of words, for each descriptor and preparation.

    Parameters
    ----------
    variants : sequence of VariantResult
        Those of family "bags" with several "words" are drawn, a line for each "bag".

    Returns
    -------
    plots : list of Plot
    """
    bags = [variant for variant in variants if variant.family == "bags"]
    return _growth_plots(bags, "words", "bag")


def bit_plots(variants: Sequence[VariantResult]) -> list[Plot]:
    """Plot mean average precision against the number of bits, for each descriptor and preparation.

    Parameters
    ----------
    variants : sequence of VariantResult
        Those of family "codes" with several "bits" are drawn, a line for each "projection"; and a horizontal
        line for the bag that is encoded, where it was measured.

    Returns
    -------
    plots : list of Plot
    """
    bags = {
        _group(variant, "bag", "words"): variant.average for variant in variants if variant.family == "bags"
    }
    codes = [variant for variant in variants if variant.family == "codes"]
    levels = {
        _group(variant): bags[_group(variant, "bag", "words")]
        for variant in codes
        if _group(variant, "bag", "words") in bags
    }
    return _growth_plots(codes, "bits", "projection", levels)


def _group(variant: VariantResult, *more: str) -> tuple[str, ...]:
    """Return the parameters that the variants of one plot have in common."""
    return tuple(str(variant.parameters.get(key, "")) for key in ("descriptor", "preparation", *more))


def _growth_plots(
    variants: Sequence[VariantResult],
    along: str,
    line: str,
    levels: dict[tuple[str, ...], float] | None = None,
) -> list[Plot]:
    """Plot mean average precision against the parameter `along`, a line for each value of `line`."""
    groups: dict[tuple[str, ...], dict[str, dict[float, float]]] = {}
    for variant in variants:
        size = variant.parameters.get(along)
        if "descriptor" not in variant.parameters or "model" in variant.parameters:
            continue  # whole models mix descriptors
        if isinstance(size, int | float) and size > 0 and not math.isnan(variant.average):
            lines = groups.setdefault(_group(variant), {})
            lines.setdefault(str(variant.parameters.get(line, "")), {})[size] = variant.average
    groups = {
        group: lines for group, lines in groups.items() if max(len(points) for points in lines.values()) > 1
    }
    low = _floor(
        [value for lines in groups.values() for points in lines.values() for value in points.values()]
    )
    # The same kind of line has the same colour in all plots.
    kinds = list(dict.fromkeys(kind for lines in groups.values() for kind in lines))

    def plot(group: tuple[str, ...]) -> Plot:
        def draw(axes: Axes) -> None:
            sizes = sorted({size for points in groups[group].values() for size in points})
            for kind, points in groups[group].items():
                x = sorted(points)
                _draw_line(axes, _Line(kind, x, [points[size] for size in x], kinds.index(kind)))
            if levels is not None and group in levels:
                axes.axhline(levels[group], color="dimgray", lw=1.2, ls=":", label="the bag itself")
            axes.set_xscale("log", base=2)
            axes.xaxis.set_major_locator(FixedLocator(_apart(sizes)))
            axes.xaxis.set_minor_locator(NullLocator())
            axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:.0f}"))
            axes.set(ylim=(low - 2, 102), xlabel=along, ylabel="mAP")
            _add_legend(axes)

        return _plot(" · ".join(part for part in group if part), (5.2, 2.8), draw)

    return [plot(group) for group in groups]


def _apart(sizes: Sequence[float]) -> list[float]:
    """Leave out ticks whose numbers would touch: all but the first within half an octave."""
    kept: list[float] = []
    for size in sizes:
        if not kept or size >= kept[-1] * math.sqrt(2):
            kept.append(size)
    return kept


def _decimal(value: float, _position: int | None = None) -> str:
    """Write a power of ten: 1, 0.1, 0.01, 10⁻³."""
    exponent = round(math.log10(value))
    return f"{value:g}" if exponent > -3 else f"10⁻{str(-exponent).translate(_SUPERSCRIPT)}"


def _columns(points: Sequence[Sequence[float]]) -> tuple[list[float], list[float]]:
    return [x for x, _ in points], [y for _, y in points]


def _floor(values: Sequence[float]) -> float:
    """Choose the start of a scale to 100: a multiple of 10 below all values, so that differences show."""
    finite = [value for value in values if not math.isnan(value)]
    return float(min(10 * math.floor(min(finite, default=0) / 10), 90))


def _draw_line(axes: Axes, line: _Line) -> None:
    """Draw a line; earlier series, which matter more, are on top."""
    cycle, number = divmod(line.series, len(SERIES))
    axes.plot(
        line.x,
        line.y,
        label=textwrap.fill(line.label, 26, break_on_hyphens=False),
        color=SERIES[number][0],
        marker=_MARKERS[number] if line.markers else "",
        linestyle=_DASHES[cycle % len(_DASHES)],
        zorder=3 - line.series / 10,
    )


def _add_legend(axes: Axes) -> None:
    """Add the legend to the right of the axes."""
    axes.figure.legend(*axes.get_legend_handles_labels(), loc="outside right upper", fontsize="small")


def _plot(title: str, size: tuple[float, float], draw: Callable[[Axes], None]) -> Plot:
    """Make a plot of this size in inches."""
    # The salt makes the file the same every time.
    with mpl.rc_context({**_STYLE, "svg.hashsalt": title}), io.StringIO() as file:
        figure = Figure(size, layout="constrained")
        draw(figure.add_subplot())
        figure.savefig(file, format="svg", metadata={"Date": None})
        return Plot(title, file.getvalue())
