# SPDX-License-Identifier: MIT
"""Find creatures by parts of them in another pose, by local heat alone. An experiment, not the product.

    python -m benchmarks local-heat [--individuals N] [--queries N] [--points N] [--jobs N]

The heat kernel K_t(x, x) at a short time t depends on the surface up to a few √t around x. So a part keeps
its values but near the cut, and bending changes them little. They are measured without smoothing, which would
change thin limbs of a whole and of its part differently, and without closing holes.

Each point of the query is compared with the most similar point of a whole, at several sizes of the query, by
log 4πt K_t and the radius of the medial ball. A point near the cut is compared at the times that do not feel
it. What differs by chance is learnt from other creatures. Whether
neighbours stay neighbours is not checked.

Prints how often the right one of all wholes differs least from a third and from half of it in another pose,
and how often it is among the first few.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache

import numpy as np
from numpy.typing import NDArray
from scipy.sparse.csgraph import dijkstra
from scipy.spatial import cKDTree

from benchmarks.creatures import CREATURE_KINDS, make_creature
from benchmarks.experiments.evidence_pairs import cut
from benchmarks.parallel import map_in_processes
from shapegoogle_core import Mesh, load_model
from shapegoogle_core.cli.arguments import number_from
from shapegoogle_core.cli.text import say, table
from shapegoogle_core.descriptors import heat_kernel_signature
from shapegoogle_core.mesh.connectivity import boundary_vertices, edge_graph
from shapegoogle_core.mesh.drawing import draw_points
from shapegoogle_core.mesh.measures import face_areas, vertex_normals
from shapegoogle_core.model.settings import ModelSettings
from shapegoogle_core.model.working_shape import working_shape
from shapegoogle_core.registration import farthest_points
from shapegoogle_core.registration.medial import medial_radii
from shapegoogle_core.spectral import Spectrum

__all__ = ["add_options", "run"]

Floats = NDArray[np.float64]

FIRST_SEED, FIRST_TRAINING_SEED, TRAINING_SEEDS = 8_000, 7_000, 2
SHARES = {"a third missing": 2 / 3, "half missing": 1 / 2}
TOP = (1, 5, 12, 40)
# Times as shares of the area, half an octave apart. A hundred eigenpairs do not represent shorter ones. The
# first few are compared; a part has the value of its whole at a longer time of its own.
TIMES = 4e-3 * 2.0 ** (np.arange(11) / 2)
COMPARED = 7
# Sizes of a part, as shares of its own: down to a third of the area of its whole.
SIZES = 1.05 ** -np.arange(12.0)
# A cut is not felt at time t if it is farther away than this many √t.
REACH = 2.0
FEWEST_TIMES, FEWEST_POINTS, MOST_DIFFERENT = 3, 24, 2.0
# Margin where there is no boundary; in any unit farther than heat is compared.
FARTHEST = 1e6
# Points of a surface that those of the samples are chosen from.
CLOUD = 4_000
SMALLEST_RADIUS, LARGEST_RADIUS = 0.01, 0.5
# Wholes compared together, so that their matrices stay in the processor's cache.
AT_ONCE = 8
# Outliers are cut off before a covariance is learnt; the share of its diagonal that is added.
OUTLIERS, RIDGE = (3, 97), 0.01


@dataclass(frozen=True, eq=False)
class Heat:
    """Local heat at points of a surface, evenly spread. Lengths are in units of √area.

    Attributes
    ----------
    values : (k, t) array
        log 4πt K_t(x, x) at `TIMES`.
    radii : (k,) array
        Logarithms of the radii of the medial balls.
    margins : (k,) array
        Distances to the open boundary along edges.
    places : (k, 3) array
        In the coordinates of the mesh.
    unit : float
        √area in the unit of the mesh.
    """

    values: Floats
    radii: Floats
    margins: Floats
    places: Floats
    unit: float

    def features(self, size: float, points: int) -> tuple[Floats, Floats]:
        """Radius and values that the first points would have at another size, and their margins."""
        place = np.arange(COMPARED) - 4 * np.log2(size)
        before = np.clip(place.astype(int), 0, len(TIMES) - 2)
        share = np.clip(place - before, 0, 1)
        values = self.values[:points, before] * (1 - share) + self.values[:points, before + 1] * share
        return np.column_stack([self.radii[:points] + np.log(size), values]), size * self.margins[:points]


@cache
def _settings() -> ModelSettings:
    settings = load_model().settings
    assert settings.preprocessing is not None
    return replace(settings, preprocessing=replace(settings.preprocessing, close_holes=0.0, smoothing=0.0))


def measure(mesh: Mesh, points: int) -> Heat:
    """Measure the local heat of a surface."""
    shape = working_shape(_settings(), mesh)
    surface, unit = shape.mesh, float(np.sqrt(shape.mesh.area))
    # Points anywhere on the faces: a part and its whole would have many vertices in common.
    faces, corners = draw_points(face_areas(surface), CLOUD, np.random.default_rng(0))
    vertices, weights = surface.faces[faces].astype(np.int64), corners[:, :, None]
    cloud = (surface.vertices[vertices] * weights).sum(axis=1) / unit
    chosen = farthest_points(cloud - cloud.mean(axis=0), min(points, CLOUD))
    vertices, weights = vertices[chosen], weights[chosen]

    def at_points(values: Floats) -> Floats:
        return np.asarray((values[vertices] * weights).sum(axis=1))

    normals = at_points(vertex_normals(surface))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    radii = medial_radii(cloud[chosen], normals, cloud, LARGEST_RADIUS)
    spectrum = shape.spectrum
    functions = Spectrum(spectrum.eigenvalues, at_points(spectrum.eigenvectors), spectrum.mass)
    heat = heat_kernel_signature(functions, list(TIMES * unit**2)) * unit**2
    return Heat(
        np.log(4 * np.pi * TIMES * heat),
        np.log(np.maximum(np.abs(radii), SMALLEST_RADIUS)),
        at_points(_margins(surface)[:, None])[:, 0] / unit,
        at_points(shape.placement.restore(surface).vertices),
        unit / shape.placement.scale,
    )


def _margins(mesh: Mesh) -> Floats:
    """Distance of each vertex from the open boundary, along edges."""
    ends = np.flatnonzero(boundary_vertices(mesh))
    if len(ends) == 0:
        return np.full(len(mesh.vertices), FARTHEST)
    return np.asarray(dijkstra(edge_graph(mesh), directed=False, indices=ends, min_only=True))


def _part(kind: str, seed: int, share: float) -> Mesh:
    random = np.random.default_rng([seed, len(kind), round(100 * share)])
    return cut(make_creature(kind, seed).pose(1), random.normal(size=3), share)


def whole_of(job: tuple[str, int, int]) -> Heat:
    """Measure a creature: its kind, its seed, and the number of points."""
    kind, seed, points = job
    return measure(make_creature(kind, seed).pose(0), points)


def part_of(job: tuple[str, int, float, int]) -> Heat:
    """Measure a part of a creature in another pose: kind, seed, share of the area, number of points."""
    kind, seed, share, points = job
    return measure(_part(kind, seed, share), points)


def residuals_of(job: tuple[str, int, float, int]) -> tuple[Floats, Floats]:
    """Compare a part's points with the nearest ones of its whole, at the size at which they differ least."""
    kind, seed, share, points = job
    creature = make_creature(kind, seed)
    rest, posed = creature.pose(0), creature.pose(1)
    whole, part = measure(rest, points), measure(_part(kind, seed, share), points)
    same = cKDTree(posed.vertices).query(part.places)[1]
    nearest = cKDTree(whole.places).query(rest.vertices[same])[1]
    among, _ = whole.features(1.0, points)
    found = []
    for size in part.unit / whole.unit * np.linspace(0.9, 1.1, 21):
        own, margins = part.features(size, points)
        differences = own - among[nearest]
        certain = margins > REACH * np.sqrt(TIMES[COMPARED // 2])
        found.append((float(np.median(np.abs(differences[certain, 1:]))), differences, margins))
    _, differences, margins = min(found, key=lambda each: each[0])
    return differences, margins


def learn_whitening(residuals: Sequence[tuple[Floats, Floats]]) -> Floats:
    """Learn the matrix that gives differences of the same point unit covariance.

    With the covariance L Lᵀ, z = L⁻¹ x has it. L is triangular, so the first m entries of z depend only on
    the first m features, and whiten these.
    """
    differences = np.concatenate([each for each, _ in residuals])
    margins = np.concatenate([each for _, each in residuals])
    low, high = np.percentile(differences, OUTLIERS, axis=0)
    clipped = np.clip(differences, low, high)
    needed = np.concatenate([[0.0], REACH * np.sqrt(TIMES[:COMPARED])])
    needed = np.maximum(needed, needed[FEWEST_TIMES])
    covariance = np.empty((len(needed),) * 2)
    for row, column in np.ndindex(covariance.shape):
        known = margins > max(needed[row], needed[column])
        covariance[row, column] = (clipped[known, row] * clipped[known, column]).mean()
    covariance += RIDGE * np.diag(np.diag(covariance))
    return np.asarray(np.linalg.inv(np.linalg.cholesky(covariance)).T)


def differences_from(
    query: Heat, wholes: Sequence[NDArray[np.float32]], whitening: Floats, points: int
) -> Floats:
    """Difference of a query from each of some whitened wholes, at the size at which it is least."""
    found = []
    for start in range(0, len(wholes), AT_ONCE):
        some = wholes[start : start + AT_ONCE]
        totals = [_differences_at(query, size, some, whitening, points) for size in SIZES]
        found.append(np.min(totals, axis=0))
    return np.concatenate(found)


def _differences_at(
    query: Heat, size: float, wholes: Sequence[NDArray[np.float32]], whitening: Floats, points: int
) -> Floats:
    features, margins = query.features(size, points)
    whitened = (features @ whitening).astype(np.float32)
    known = (REACH * np.sqrt(TIMES[:COMPARED]) < margins[:, None]).sum(axis=1)
    count = int((known >= FEWEST_TIMES).sum())
    if count < FEWEST_POINTS:
        return np.full(len(wholes), np.inf)
    together, sums = np.concatenate(wholes), np.zeros(len(wholes))
    for times in np.unique(known[known >= FEWEST_TIMES]).tolist():
        own, others = whitened[known == times, : times + 1], together[:, : times + 1]
        products = own @ others.T
        products -= (others**2).sum(axis=1) / 2
        nearest = products.reshape(len(own), len(wholes), -1).max(axis=2)
        squares = (own**2).sum(axis=1)[:, None] - 2 * nearest
        sums += np.sqrt(squares.clip(min=0) / (times + 1)).clip(max=MOST_DIFFERENT).sum(axis=0)
    return sums / count


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of the subcommand.

    Parameters
    ----------
    parser : argparse.ArgumentParser
    """
    for name, default, text in (
        ("--individuals", 12, "of each of 31 kinds (12: 372 wholes)"),
        ("--queries", 62, "creatures that are cut and bent (62)"),
        ("--points", 1_200, "of each whole (1,200)"),
        ("--query-points", 192, "of each part (192)"),
        ("--jobs", 2, "worker processes (2)"),
    ):
        parser.add_argument(name, type=number_from(1), default=default, metavar="N", help=text)


def run(options: argparse.Namespace) -> int:
    """Measure wholes and parts, compare them and print the table.

    Parameters
    ----------
    options : argparse.Namespace
        As from `add_options`.

    Returns
    -------
    exit_code : int
    """
    seeds = range(FIRST_TRAINING_SEED, FIRST_TRAINING_SEED + TRAINING_SEEDS)
    learnt = [
        (kind, seed, share, options.points)
        for kind in CREATURE_KINDS
        for seed in seeds
        for share in SHARES.values()
    ]
    whitening = learn_whitening(map_in_processes(residuals_of, learnt, options.jobs, "to learn from"))
    names = [(kind, FIRST_SEED + number) for number in range(options.individuals) for kind in CREATURE_KINDS]
    jobs = [(kind, seed, options.points) for kind, seed in names]
    wholes = []
    for heat in map_in_processes(whole_of, jobs, options.jobs, "creatures"):
        features, _ = heat.features(1.0, options.points)
        wholes.append((features @ whitening).astype(np.float32))
    rows = [["", "MRR", *(f"first {top}" for top in TOP)]]
    for sort, share in SHARES.items():
        asked = [(kind, seed, share, options.query_points) for kind, seed in names[: options.queries]]
        ranks = []
        for right, part in enumerate(map_in_processes(part_of, asked, options.jobs, sort)):
            found = differences_from(part, wholes, whitening, options.query_points)
            ranks.append(1 + int((found < found[right]).sum()))
        places = np.array(ranks)
        rows.append([sort, f"{(1 / places).mean():.3f}", *(f"{(places <= top).mean():.0%}" for top in TOP)])
    say(f"{len(wholes):,} wholes, {min(options.queries, len(names))} queries of each sort")
    for line in table(rows, "<" + ">" * (1 + len(TOP))):
        say(line)
    return 0
