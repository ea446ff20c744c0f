# SPDX-License-Identifier: MIT
"""Pictures of the queries with the worst ranks: the query, its null shape and the first match."""

from __future__ import annotations

import base64
import io
from collections.abc import Iterator
from dataclasses import dataclass

from PIL import Image

from benchmarks.protocol.collection import BenchmarkShape, Collection
from benchmarks.protocol.results import QueryOutcome, VariantResult
from shapegoogle_core.errors import MeshError
from shapegoogle_core.mesh import Mesh
from shapegoogle_core.mesh.mesh import FloatArray
from shapegoogle_core.rendering import canonical_view, render

__all__ = ["Failure", "worst_failures", "worst_outcomes"]

_PIXELS = 300
"""Twice as many as the page shows, for high-resolution screens and printing."""
_COLORS = 48


@dataclass(frozen=True)
class Failure:
    """A query that did not find its shape first.

    Attributes
    ----------
    outcome : QueryOutcome
    query, relevant, first : str
        PNGs as data URLs; empty where a shape could not be drawn.
    """

    outcome: QueryOutcome
    query: str
    relevant: str
    first: str


def worst_outcomes(variant: VariantResult, count: int) -> list[QueryOutcome]:
    """Find the queries with the worst ranks.

    Parameters
    ----------
    variant : VariantResult
    count : int

    Returns
    -------
    outcomes : list of QueryOutcome
        Worst first, weak transformations before strong ones; only queries that did not fail and whose shape
        did not come first.
    """
    missed = [outcome for outcome in variant.outcomes if outcome.rank > 1 and not outcome.failed]
    return sorted(missed, key=lambda outcome: (-outcome.rank, outcome.strength, outcome.query))[:count]


def worst_failures(variant: VariantResult, collection: Collection, count: int = 24) -> Iterator[Failure]:
    """Draw the queries with the worst ranks.

    A query is drawn from the same direction as its null shape, so that the two can be compared.

    Parameters
    ----------
    variant : VariantResult
    collection : Collection
        The measured collection.
    count : int

    Yields
    ------
    failure : Failure
    """
    queries = {shape.name: shape for shape in collection.queries}
    album = _Album({shape.name: shape for shape in collection.database})
    for outcome in worst_outcomes(variant, count):
        query = _read(queries.get(outcome.query))
        view = album.view(outcome.relevant)
        yield Failure(
            outcome,
            "" if query is None else _picture(query, canonical_view(query) if view is None else view),
            album.picture(outcome.relevant),
            album.picture(outcome.first),
        )


class _Album:
    """Pictures of database shapes, each drawn once, because a shape is often first for many queries."""

    def __init__(self, shapes: dict[str, BenchmarkShape]) -> None:
        self._shapes = shapes
        self._drawn: dict[str, tuple[str, FloatArray | None]] = {}

    def picture(self, name: str) -> str:
        return self._draw(name)[0]

    def view(self, name: str) -> FloatArray | None:
        return self._draw(name)[1]

    def _draw(self, name: str) -> tuple[str, FloatArray | None]:
        if name not in self._drawn:
            mesh = _read(self._shapes.get(name))
            view = None if mesh is None else canonical_view(mesh)
            self._drawn[name] = ("" if mesh is None else _picture(mesh, view), view)
        return self._drawn[name]


def _read(shape: BenchmarkShape | None) -> Mesh | None:
    """Read a shape; None if it cannot be read, which the report then shows in its place."""
    if shape is None:
        return None
    try:
        mesh = shape.mesh()
    except MeshError:
        return None
    return mesh if len(mesh.vertices) else None


def _picture(mesh: Mesh, view: FloatArray | None) -> str:
    image = render(mesh, size=(_PIXELS, _PIXELS), background=None, view=view)
    with io.BytesIO() as file:
        small = image.quantize(_COLORS, method=Image.Quantize.FASTOCTREE)
        small.save(file, "PNG", optimize=True)
        return "data:image/png;base64," + base64.b64encode(file.getvalue()).decode("ascii")
