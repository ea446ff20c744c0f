# SPDX-License-Identifier: MIT
"""Plots as SVG that stands inside a page and takes its colours and letters from it."""

from __future__ import annotations

import io
import math
import re
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

SERIES = 6
"""How many colours there are; the page's style sheet names them --s0 … --s5."""

# Stand-ins that are replaced by the page's own colours, which differ between light and dark.
_INK, _FAINT, _GRID, _PAPER = "#010101", "#020202", "#030303", "#040404"
_SERIES = [f"#0505{number:02d}" for number in range(SERIES)]
_VARIABLES = {_INK: "--ink", _FAINT: "--faint", _GRID: "--grid", _PAPER: "--paper"} | {
    color: f"--s{number}" for number, color in enumerate(_SERIES)
}
# Lines differ in their marks as well: colours are lost on some printers and to some eyes.
_MARKS = ("o", "s", "^", "D", "v", "P")
_DASHES: tuple[str | tuple[int, tuple[float, ...]], ...] = ("-", (0, (5, 1.5)), (0, (1.2, 1.2)))

_SUPERSCRIPT = str.maketrans("0123456789", "⁰¹²³⁴⁵⁶⁷⁸⁹")

_STYLE: dict[Any, Any] = {
    "svg.fonttype": "none",
    "text.parse_math": False,  # names are not formulas
    "font.size": 9,
    "text.color": _INK,
    "axes.edgecolor": _FAINT,
    "axes.labelcolor": _INK,
    "axes.facecolor": "none",
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.color": _GRID,
    "grid.linewidth": 0.8,
    "xtick.color": _FAINT,
    "ytick.color": _FAINT,
    "xtick.labelcolor": _INK,
    "ytick.labelcolor": _INK,
    "figure.facecolor": "none",
    "lines.linewidth": 1.6,
    "lines.markersize": 4,
}


@dataclass(frozen=True)
class Plot:
    """A plot for the page.

    Attributes
    ----------
    title : str
    svg : str
        An <svg> element.
    """

    title: str
    svg: str


@dataclass(frozen=True)
class _Line:
    """One line of a plot, and the words that stand at its end."""

    label: str
    x: Sequence[float]
    y: Sequence[float]
    series: int
    dashes: int = 0
    marks: bool = True


def strength_plots(variants: Sequence[VariantResult], classes: Sequence[str]) -> list[Plot]:
    """Draw mean average precision against strength, one small plot for each class.

    Parameters
    ----------
    variants : sequence of VariantResult
        At most `SERIES`; each has the colour and the mark of its position.
    classes : sequence of str

    Returns
    -------
    plots : list of Plot
        All over the same scale.
    """
    rows = [variant.table[name] for variant in variants for name in classes if name in variant.table]
    low = _floor([value for row in rows for value in row])

    def panel(axes: Axes, name: str) -> None:
        for number, variant in enumerate(variants):
            if name in variant.table:
                row, above = variant.table[name], 3 - number / 10
                axes.plot(STRENGTHS, row, marker=_MARKS[number], color=_SERIES[number], zorder=above)
        axes.set(xlim=(0.8, 5.2), ylim=(low - 2, 102), xticks=STRENGTHS)

    return [
        Plot(
            name.replace("_", " "),
            _draw(f"strength-{name}", (2.7, 1.9), lambda axes, name=name: panel(axes, name)),  # type: ignore[misc]
        )
        for name in classes
    ]


def precision_recall_plot(variants: Sequence[VariantResult]) -> Plot | None:
    """Draw precision against recall; None if no variant has a curve."""
    lines = [
        _Line(variant.name, *_columns(variant.precision_recall), number, marks=False)
        for number, variant in enumerate(variants)
        if variant.precision_recall
    ]

    def panel(axes: Axes) -> None:
        axes.set(xlim=(0, 1), ylim=(0, 1.02), xlabel="recall", ylabel="precision")
        _plot_lines(axes, lines, key=True)

    return Plot("Precision and recall", _draw("precision-recall", (4.4, 3.3), panel)) if lines else None


def roc_plot(variants: Sequence[VariantResult]) -> Plot | None:
    """Draw the receiver operating characteristic over a logarithmic axis, with its equal error rate.

    Parameters
    ----------
    variants : sequence of VariantResult
        At most `SERIES`.

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
    lines = []
    for number, variant in drawn:
        x, y = _columns(variant.roc)
        rate = variant.equal_error_rate
        label = variant.name if math.isnan(rate) else f"{variant.name} ({100 * rate:.2g}\u00a0%)"
        lines.append(_Line(label, np.maximum(x, least).tolist(), y, number, marks=False))
    low = _floor([100 * y for _, variant in drawn for x, y in variant.roc if x >= 10 * least]) / 100

    def panel(axes: Axes) -> None:
        axes.set_xscale("log")
        axes.set(xlim=(least, 1), ylim=(low, 1 + 0.02 * (1 - low)))
        axes.set(xlabel="false positive rate", ylabel="true positive rate")
        rates = np.geomspace(least, 1, 200)
        axes.plot(rates, 1 - rates, color=_FAINT, lw=0.8, ls=":", scalex=False, scaley=False)
        axes.xaxis.set_major_formatter(FuncFormatter(_decimal))
        axes.xaxis.set_minor_locator(NullLocator())
        _plot_lines(axes, lines, key=True)
        for number, variant in drawn:
            rate = variant.equal_error_rate
            if rate > 0 and 1 - rate >= low:
                mark: dict[str, Any] = {"marker": _MARKS[number], "ms": 7, "mec": _PAPER}
                axes.plot(rate, 1 - rate, color=_SERIES[number], zorder=5 - number / 10, **mark)

    return Plot("ROC, with equal error rates", _draw("roc", (4.4, 3.3), panel))


def _decimal(value: float, _position: int | None = None) -> str:
    """Write a power of ten: 1, 0.1, 0.01, 10⁻³."""
    exponent = round(math.log10(value))
    return f"{value:g}" if exponent > -3 else f"10⁻{str(-exponent).translate(_SUPERSCRIPT)}"


def vocabulary_plots(variants: Sequence[VariantResult]) -> list[Plot]:
    """Draw mean average precision against the number of words, a plot for each descriptor and preparation.

    Parameters
    ----------
    variants : sequence of VariantResult
        Those of family "bags" with several "words" are drawn, a line for each "bag".

    Returns
    -------
    plots : list of Plot
    """
    return _growth_plots(
        [variant for variant in variants if variant.family == "bags"], "words", "bag", "words"
    )


def bit_plots(variants: Sequence[VariantResult]) -> list[Plot]:
    """Draw mean average precision against the number of bits, a plot for each descriptor and preparation.

    Parameters
    ----------
    variants : sequence of VariantResult
        Those of family "codes" with several "bits" are drawn, a line for each "projection"; and a level for
        the bag that they stand for, where it was measured.

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
    return _growth_plots(codes, "bits", "projection", "bits", levels)


def _group(variant: VariantResult, *more: str) -> tuple[str, ...]:
    """Return what a plot's variants have in common."""
    return tuple(str(variant.parameters.get(key, "")) for key in ("descriptor", "preparation", *more))


def _growth_plots(
    variants: Sequence[VariantResult],
    along: str,
    line: str,
    unit: str,
    levels: dict[tuple[str, ...], float] | None = None,
) -> list[Plot]:
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
    everything = [
        value for lines in groups.values() for points in lines.values() for value in points.values()
    ]
    low = _floor(everything)
    # A kind of line has the same colour in all plots.
    kinds = list(dict.fromkeys(kind for lines in groups.values() for kind in lines))
    plots = []
    for group, lines in groups.items():
        drawn = [
            _Line(
                kind,
                sorted(points),
                [points[x] for x in sorted(points)],
                kinds.index(kind) % SERIES,
                dashes=kinds.index(kind) // SERIES,
            )
            for kind, points in lines.items()
        ]
        level = (levels or {}).get(group)

        def panel(axes: Axes, drawn: list[_Line] = drawn, level: float | None = level) -> None:
            sizes = sorted({x for line in drawn for x in line.x})
            axes.set_xscale("log", base=2)
            axes.xaxis.set_major_locator(FixedLocator(_apart(sizes)))
            axes.xaxis.set_minor_locator(NullLocator())
            axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:.0f}"))
            axes.set(ylim=(low - 2, 102), xlabel=unit, ylabel="mAP")
            if level is not None:
                axes.axhline(level, color=_FAINT, lw=1, ls=(0, (1, 1.5)))
                drawn = [*drawn, _Line("the bag itself", [sizes[-1]], [level], -1, marks=False)]
            _plot_lines(axes, drawn)

        title = " · ".join(part for part in group if part)
        plots.append(Plot(title, _draw(f"{along}-{'-'.join(group)}", (4.2, 2.8), panel)))
    return plots


def _apart(sizes: Sequence[float]) -> list[float]:
    """Leave out ticks whose numbers would touch: all but the first within half an octave."""
    kept: list[float] = []
    for size in sizes:
        if not kept or size >= kept[-1] * math.sqrt(2):
            kept.append(size)
    return kept


def _columns(points: Sequence[Sequence[float]]) -> tuple[list[float], list[float]]:
    return [x for x, _ in points], [y for _, y in points]


def _floor(values: Sequence[float]) -> float:
    """Where a scale up to 100 starts so that small differences show: a multiple of 10 below all values."""
    finite = [value for value in values if not math.isnan(value)]
    return float(min(10 * math.floor(min(finite, default=0) / 10), 90))


def _plot_lines(axes: Axes, lines: Sequence[_Line], key: bool = False) -> None:
    """Draw lines, and each one's label right of its end, moved up or down where labels would touch.

    Curves that end in one point have their labels in a column from the top instead, as a `key`.
    """
    for line in lines:
        color = _SERIES[line.series] if line.series >= 0 else _FAINT
        mark = _MARKS[line.series] if line.marks else ""
        # Lines that were drawn first lie on top: they are the more important ones.
        axes.plot(
            line.x, line.y, marker=mark, ls=_DASHES[line.dashes % 3], color=color, zorder=3 - line.series / 10
        )
    texts = [textwrap.wrap(line.label, 26, break_on_hyphens=False) or [""] for line in lines]
    points = axes.bbox.height / mpl.rcParams["figure.dpi"] * 72
    line_height = 11 / points
    low, high = axes.get_ylim()
    ends = np.array([(np.clip(line.y[-1], low, high) - low) / (high - low) for line in lines])
    heights = np.array([len(text) * line_height for text in texts]) + 0.25 * line_height
    places = 1 - np.cumsum(heights) + heights / 2 if key else _spread(ends, heights)
    for line, text, end, place in zip(lines, texts, ends, places, strict=True):
        color = _SERIES[line.series] if line.series >= 0 else _FAINT
        if key:
            axes.plot([1.02, 1.055], [place, place], color=color, transform=axes.transAxes, clip_on=False)
        elif abs(place - end) > 0.01:
            leader: dict[str, Any] = {"lw": 0.7, "transform": axes.transAxes, "clip_on": False}
            axes.plot([1.005, 1.035], [end, place], color=color, **leader)
        axes.text(
            1.07 if key else 1.045,
            place,
            "\n".join(text),
            color=color,
            va="center",
            transform=axes.transAxes,
            linespacing=1.1,
            fontsize=8.5,
        )


def _spread(ends: np.ndarray, heights: np.ndarray) -> np.ndarray:
    """Places for labels of these heights, as near to where they belong as they can be without touching."""
    order = np.argsort(ends, kind="stable")
    places = ends[order].astype(float)
    halves = heights[order] / 2
    # Groups of touching labels, each around the mean of where its members would be.
    groups: list[list[int]] = []
    for label in range(len(places)):
        groups.append([label])
        while len(groups) > 1 and _top(groups[-2], places, halves) > _bottom(groups[-1], places, halves):
            last = groups.pop()
            groups[-1] += last
            _pack(groups[-1], ends[order], places, halves)
    spread = np.empty_like(places)
    spread[order] = places
    return spread


def _top(group: list[int], places: np.ndarray, halves: np.ndarray) -> float:
    return float(places[group[-1]] + halves[group[-1]])


def _bottom(group: list[int], places: np.ndarray, halves: np.ndarray) -> float:
    return float(places[group[0]] - halves[group[0]])


def _pack(group: list[int], ends: np.ndarray, places: np.ndarray, halves: np.ndarray) -> None:
    sizes = 2 * halves[group]
    offsets = np.cumsum(sizes) - sizes / 2
    places[group] = offsets + (ends[group] - offsets).mean()


def _draw(name: str, size: tuple[float, float], panel: Callable[[Axes], None]) -> str:
    """Draw one plot; `name` keeps the names inside the SVG apart from those of the page's other plots."""
    with mpl.rc_context({**_STYLE, "svg.hashsalt": name}), io.StringIO() as file:
        figure = Figure(size)
        panel(figure.add_subplot())
        metadata = {"Date": None, "Creator": None, "Format": None, "Type": None}
        figure.savefig(file, format="svg", bbox_inches="tight", pad_inches=0.04, metadata=metadata)
        return _for_page(file.getvalue())


def _for_page(svg: str) -> str:
    """Make matplotlib's file part of a page: without headers, fixed size, fonts and repeated names."""
    svg = svg[svg.index("<svg") :]
    svg = re.sub(r"\s*<metadata>.*?</metadata>", "", svg, flags=re.DOTALL)
    width = re.search(r'width="([\d.]+)pt"', svg)
    assert width is not None
    svg = re.sub(r' (width|height)="[\d.]+pt"', "", svg, count=2)
    svg = re.sub(r' xmlns(:xlink)?="[^"]*"| version="1.1"', "", svg)
    svg = re.sub(r' id="[\w.]+_\d+"', "", svg)
    svg = re.sub(r"font: ([\d.]+)px [^;\"]*", r"font-size: \1px", svg)
    for color, variable in _VARIABLES.items():
        svg = svg.replace(color, f"var({variable})")
    # At its natural size of 96 pixels to 72 points, smaller where the window is narrow.
    return svg.replace("<svg ", f'<svg style="width: {float(width[1]) * 4 / 3:.0f}px" role="img" ', 1)
