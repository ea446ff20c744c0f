# SPDX-License-Identifier: MIT
"""Request for what a view of a query beside a match shows: both surfaces and the distances between them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree
from threadpoolctl import threadpool_limits

from shapegoogle_core.errors import LibraryError, MeshError
from shapegoogle_core.library.evidence import SIZED_BY_AREA
from shapegoogle_core.library.match import Match
from shapegoogle_core.library.placement import Placement
from shapegoogle_core.mesh import Mesh, read_mesh
from shapegoogle_core.mesh.mesh import FloatArray
from shapegoogle_core.model import ShapeSignature
from shapegoogle_core.preprocessing.repair import repair
from shapegoogle_core.preprocessing.resampling import simplify
from shapegoogle_core.registration import SurfaceSample
from shapegoogle_core.registration.fit.best_fit import best_fit
from shapegoogle_core.registration.fit.nearest import TriangleTree
from shapegoogle_core.rendering import read_preview
from shapegoogle_core.worker.requests import open_library

__all__ = ["ComparedSurface", "SurfaceComparison", "compare_surfaces"]

# Vertices of a surface that is shown.
_SHOWN = 4_000
# Of larger meshes the preprocessed surface is compared, which differs from them by less than can be seen.
_MOST_FACES = 300_000


@dataclass(frozen=True, eq=False)
class ComparedSurface:
    """One of two surfaces that are compared.

    Attributes
    ----------
    vertices : (n, 3) array of float32
        In the coordinates of the query, from its centre.
    faces : (m, 3) array of int32
        None for points.
    distances : (n,) array of float32
        Of the vertices from the other surface, in units of the query.
    origin : {"mesh", "preview", "sample"}
        What is shown: the mesh itself, its preview, or points of it.
    """

    vertices: NDArray[np.float32]
    faces: NDArray[np.int32]
    distances: NDArray[np.float32]
    origin: str


@dataclass(frozen=True, eq=False)
class SurfaceComparison:
    """A query and a match in the position in which they lie on each other best.

    Attributes
    ----------
    query, match : ComparedSurface
        The match is at the size of the query: divided by `Match.relative_size`.
    size : float
        Square root of the query's area: its size, in its units.
    up_axis : int
        Axis of the query that points up: 1 or 2.
    typical, most : float
        Median and 95th percentile of the distances of both.
    """

    query: ComparedSurface
    match: ComparedSurface
    size: float
    up_axis: int
    typical: float
    most: float


def compare_surfaces(
    path: Path,
    signatures: Sequence[ShapeSignature],
    match: Match,
    mesh: Mesh | None = None,
    queries: Sequence[Mesh] = (),
    stored: Sequence[int] = (),
) -> SurfaceComparison:
    """Lay a match on the query, and measure how far apart their surfaces are.

    Parameters
    ----------
    path : Path
        The library.
    signatures : sequence of ShapeSignature
        See `Answer`; of several examples the one nearest to the match is shown.
    match : Match
    mesh : Mesh, optional
        Mesh of the match at its placement, where it is at hand. Otherwise a mesh file is read, if it is
        still there, and of other shapes the preview is shown.
    queries : sequence of Mesh, optional
        Meshes of the first of the examples, as they were given; else their preprocessed surfaces are shown.
    stored : sequence of int, optional
        Ids of the last of the examples, which are shapes of the library.

    Returns
    -------
    comparison : SurfaceComparison

    Raises
    ------
    LibraryError
        If the library cannot be read, or the match is no longer in it or has no surface to compare.
    """
    library = open_library(path)
    other = library.signature(match.shape_id)
    usable = [place for place, signature in enumerate(signatures) if signature.sample is not None]
    if not usable or other.sample is None:
        raise LibraryError(
            f"{match.name!r} cannot be compared: the model of the library keeps no surfaces; index with "
            "another model"
        )
    distances = library.model.distances(other.bags, np.stack([signatures[place].bags for place in usable]))
    place = usable[int(np.argmin(distances))]
    query = signatures[place]
    sample = query.sample
    assert sample is not None  # it is usable
    number = place - (len(signatures) - len(stored))
    given = queries[place] if place < len(queries) else None
    if given is None or len(given.faces) > _MOST_FACES:
        given = query.surface
    own, own_origin = _surface(given, library.preview(stored[number]) if number >= 0 else None, sample)
    placed = _placed_by(match, library.placements(match.shape_id))
    other_sample = other.sample.placed(placed)
    if mesh is not None and len(mesh.vertices):
        theirs, origin = mesh, "mesh"
    else:
        theirs, origin = _surface(_file_mesh(match), library.preview(match.shape_id), other.sample)
        theirs = Mesh(theirs.vertices @ placed[:3, :3].T + placed[:3, 3], theirs.faces)
    kind = "similar" if match.evidence is None else match.evidence.kind
    size = None
    if kind in SIZED_BY_AREA:
        # A fit makes another pose, or another thing, smaller or larger than it is.
        size = other_sample.unit / (sample.unit * match.relative_size(query.area))
    # On matrices of this size a second BLAS thread only doubles the processor time.
    with threadpool_limits(1, user_api="blas"):
        frame = best_fit(sample, query.surface, other_sample, reflected=kind == "mirrored", scale=size)
    laid = frame.apply((theirs.vertices - other_sample.center) / other_sample.unit) * sample.unit
    there = Mesh(laid + sample.center, theirs.faces)
    # For each the other as it was read; what is shown of them may be simpler.
    shown, shown_other = _simple(own), _simple(there)
    apart = _distances(shown, there), _distances(shown_other, own)
    center = (own.vertices.min(axis=0) + own.vertices.max(axis=0)) / 2
    both = np.concatenate(apart)
    return SurfaceComparison(
        _compared(shown, center, apart[0], own_origin),
        _compared(shown_other, center, apart[1], origin),
        size=float(np.sqrt(query.area)),
        up_axis=2,
        typical=float(np.median(both)),
        most=float(np.quantile(both, 0.95)),
    )


def _surface(mesh: Mesh | None, preview: bytes | None, sample: SurfaceSample) -> tuple[Mesh, str]:
    if mesh is not None and len(mesh.vertices):
        return mesh, "mesh"
    if preview is not None:
        return read_preview(preview).mesh, "preview"
    points = sample.center + sample.unit * sample.points
    return Mesh(points, np.empty((0, 3), np.int32)), "sample"


def _placed_by(match: Match, placements: Sequence[Placement]) -> FloatArray:
    """Return what carries the shape as it is stored, at its first placement, to that of the match."""
    if match.placement is None or not placements:
        return np.eye(4)
    return np.asarray(match.placement.matrix @ np.linalg.inv(placements[0].matrix))


def _file_mesh(match: Match) -> Mesh | None:
    """Read the file of a match, if it is there and the core can read it as the one shape that it was."""
    path = Path(match.source)
    if match.object_name or not match.source or not path.is_file():
        return None
    try:
        mesh = read_mesh(path)
    except MeshError:  # a format of Blender, or changed meanwhile: its preview shows it as it was
        return None
    return mesh if len(mesh.vertices) == match.vertex_count else None


def _simple(mesh: Mesh) -> Mesh:
    if mesh.is_point_cloud or len(mesh.vertices) <= _SHOWN:
        return mesh
    small = simplify(repair(mesh), _SHOWN)
    return small if len(small.faces) else mesh


def _distances(mesh: Mesh, other: Mesh) -> NDArray[np.float32]:
    points = mesh.vertices
    if other.is_point_cloud:
        away, _ = cKDTree(other.vertices).query(points)
        return np.asarray(away, np.float32)
    nearest, _ = TriangleTree(other.vertices[other.faces]).nearest(points)
    return np.asarray(np.linalg.norm(points - nearest, axis=1), np.float32)


def _compared(
    mesh: Mesh, center: NDArray[np.float64], distances: NDArray[np.float32], origin: str
) -> ComparedSurface:
    return ComparedSurface(
        (mesh.vertices - center).astype(np.float32), mesh.faces.astype(np.int32), distances, origin
    )
