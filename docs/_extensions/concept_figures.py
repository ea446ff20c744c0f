# SPDX-License-Identifier: MIT
"""The figures of the page "From heat to codes", drawn by the product when the site is built."""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from sphinx.application import Sphinx

import shapegoogle_core as sg
from benchmarks.creatures import make_creature
from benchmarks.figures.shape_rows import show_shapes
from benchmarks.objects import make_object
from shapegoogle_core.mesh.mesh import FloatArray
from shapegoogle_core.rendering import value_colors, word_palette
from shapegoogle_core.views import normal_pictures, surface_points

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FOLDER = Path("concepts", "figures")
DOTS_PER_INCH = 130
# Times as shares of the area, from a detail to a limb.
TIMES = (0.003, 0.01, 0.03, 0.1)
SEED = 2011


@cache
def pose(kind: str, name: str) -> sg.Mesh:
    """Make a creature in a pose."""
    return make_creature(kind, SEED, 3_000).pose(name)


@cache
def spectrum(kind: str, name: str) -> sg.Spectrum:
    """Compute the spectrum of a creature in a pose."""
    return sg.compute_spectrum(pose(kind, name), k=100)


@cache
def words(kind: str, name: str) -> sg.VertexWords:
    """Find the words of a creature in a pose."""
    return sg.vertex_words(sg.load_model(), pose(kind, name))


SHAPES = (("horse", "rest"), ("horse", "gallop"), ("human", "walk"))


def in_poses(values: Callable[[str], FloatArray]) -> Figure:
    """Draw values at several times on a horse in two poses, in the same colours."""
    poses = ("rest", "gallop")
    shown = {name: values(name) for name in poses}
    limits = [np.quantile(shown["rest"][:, i], [0.02, 0.98]) for i in range(len(TIMES))]
    return show_shapes(
        [pose("horse", name) for name in poses for _ in TIMES],
        [f"t = {time} · area" for time in TIMES] + [""] * len(TIMES),
        [value_colors(shown[name][:, i], *limits[i]) for name in poses for i in range(len(TIMES))],
    )


def heat() -> Figure:
    """Draw heat from the nose."""
    rest = pose("horse", "rest")
    nose = int((rest.vertices @ [0.0, -1.0, 0.6]).argmax())

    def values(name: str) -> FloatArray:
        times = np.array(TIMES) * rest.area
        columns = [sg.heat_kernel(spectrum("horse", name), nose, time) for time in times]
        return np.sqrt(np.maximum(np.stack(columns, axis=1), 0))

    return in_poses(values)


def signature() -> Figure:
    """Draw heat kernel signatures."""
    times = np.array(TIMES) * pose("horse", "rest").area
    return in_poses(lambda name: np.log(sg.heat_kernel_signature(spectrum("horse", name), times)))


def geometric_words() -> Figure:
    """Draw the words of three shapes."""
    palette = word_palette(len(words(*SHAPES[0]).bag))
    return show_shapes(
        [pose(*shape) for shape in SHAPES],
        colors=[palette[words(*shape).heaviest] for shape in SHAPES],
        columns=3,
    )


def bags() -> Figure:
    """Draw the bags of the same shapes, each word in its colour."""
    import matplotlib.pyplot as plt

    count = len(words(*SHAPES[0]).bag)
    figure, grid = plt.subplots(1, len(SHAPES), figsize=(8.8, 2.4), sharey=True)
    for axes, shape in zip(grid, SHAPES, strict=True):
        axes.bar(range(count), 100 * words(*shape).bag, color=word_palette(count), width=1)
        axes.set(title=", ".join(shape), xlabel="word", xticks=[])
    grid[0].set_ylabel("share of the area in %")
    figure.tight_layout()
    return figure


def pairs() -> Figure:
    """Draw bags of pairs of words of the same shapes."""
    import matplotlib.pyplot as plt

    figure, grid = plt.subplots(1, len(SHAPES), figsize=(8.8, 3.1))
    for axes, shape in zip(grid, SHAPES, strict=True):
        time = 0.025 * pose(*shape).area
        matrix = sg.spatially_sensitive_bag(words(*shape).weights(), spectrum(*shape), time)
        axes.imshow(np.sqrt(np.maximum(matrix, 0)), cmap="viridis")
        axes.set(title=", ".join(shape), xticks=[], yticks=[])
    figure.tight_layout()
    return figure


def codes() -> Figure:
    """Draw the codes of shapes in two poses, and how many bits differ."""
    import matplotlib.pyplot as plt

    shapes = [
        ("horse", "rest"),
        ("horse", "gallop"),
        ("human", "rest"),
        ("human", "run"),
        ("octopus", "rest"),
        ("octopus", "curl"),
    ]
    model = sg.load_model()
    bits = np.stack([np.unpackbits(model.describe(pose(*shape)).code) for shape in shapes])
    distances = (bits[:, None] != bits[None]).sum(axis=2)
    labels = [", ".join(shape) for shape in shapes]
    figure, (left, right) = plt.subplots(1, 2, figsize=(8.8, 2.8), width_ratios=(2.2, 1))
    left.imshow(bits[:, :96], cmap="Greys", aspect="auto", interpolation="nearest")
    left.set(yticks=range(len(labels)), yticklabels=labels, xticks=[], title="the first 96 bits")
    right.imshow(distances, cmap="viridis")
    for (row, column), distance in np.ndenumerate(distances):
        light = distance > distances.max() / 2
        right.text(
            column, row, str(distance), ha="center", va="center", fontsize=7, color="k" if light else "w"
        )
    right.set(xticks=[], yticks=[], title=f"different bits of {bits.shape[1]}")
    figure.tight_layout()
    return figure


def views() -> Figure:
    """Draw the normals of a teapot from the twelve directions."""
    import matplotlib.pyplot as plt

    points, normals = surface_points(make_object("teapot", seed=1), 30_000)
    pictures = normal_pictures(points, normals, 128)
    figure, grid = plt.subplots(2, len(pictures) // 2, figsize=(8.8, 3))
    for axes, picture in zip(grid.flat, pictures, strict=True):
        seen = picture.any(axis=-1, keepdims=True)
        axes.imshow(np.where(seen, (picture + 1) / 2, 1), interpolation="nearest")
        axes.axis("off")
    figure.tight_layout()
    return figure


def ranking() -> Figure:
    """Draw a query and its matches."""
    shapes = {f"{kind}, {name}": pose(kind, name) for kind, name in SHAPES}
    for seed, kind in enumerate(("deer", "dog", "octopus", "lizard")):
        shapes[kind] = make_creature(kind, seed, 2_000).rest
    query = make_creature("horse", SEED, 1_500).pose("rear")
    with tempfile.TemporaryDirectory() as folder, sg.Library.open(Path(folder, "figure.sglib")) as library:
        for name, shape in shapes.items():
            library.add(shape, name=name)
        matches = library.query(query, top=4)
    captions = [
        f"{match.name}\nsimilarity {match.similarity:.2f}\n{match.evidence.kind if match.evidence else ''}"
        for match in matches
    ]
    return show_shapes([query, *(shapes[match.name] for match in matches)], ["query", *captions], columns=5)


FIGURES: dict[str, Callable[[], Figure]] = {
    "heat": heat,
    "signature": signature,
    "words": geometric_words,
    "bags": bags,
    "pairs": pairs,
    "codes": codes,
    "views": views,
    "ranking": ranking,
}


def draw_figures(app: Sphinx) -> None:
    """Draw the figures that are older than the code."""
    import matplotlib as mpl
    import matplotlib.pyplot as plt

    folder = Path(app.srcdir) / FOLDER
    folder.mkdir(exist_ok=True)
    sources = [*Path(sg.__file__).parent.rglob("*.py"), Path(__file__)]
    newest = max(path.stat().st_mtime for path in sources)
    mpl.use("agg")
    for name, draw in FIGURES.items():
        target = folder / f"{name}.png"
        if not target.exists() or target.stat().st_mtime < newest:
            figure = draw()
            figure.savefig(target, dpi=DOTS_PER_INCH, bbox_inches="tight")
            plt.close(figure)


def setup(app: Sphinx) -> dict[str, Any]:
    """Connect to the start of a build."""
    app.connect("builder-inited", draw_figures)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
