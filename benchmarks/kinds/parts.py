# SPDX-License-Identifier: MIT
"""Distances within a labelled set by each part of the search alone, and by the whole search."""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from pathlib import Path

import numpy as np

from benchmarks.kinds.describing import DescribedSet
from shapegoogle_core.library.library import Library
from shapegoogle_core.library.search.traits.distances import TraitDistances, Traits
from shapegoogle_core.mesh.mesh import FloatArray
from shapegoogle_core.model import ShapeModel
from shapegoogle_core.processes.progress import progress_bar

__all__ = [
    "PARTS",
    "Part",
    "bag_distances",
    "gated_distances",
    "gradient_distances",
    "kind_distances",
    "measure_distances",
    "search_distances",
    "view_distances",
]

Part = Callable[[DescribedSet, ShapeModel], FloatArray | None]
"""Computes the distances (n, n) of a set; None where the model lacks the part."""


def bag_distances(described: DescribedSet, model: ShapeModel) -> FloatArray:
    """Compute the distances of the bags, as `ShapeModel.distances`."""
    bags = np.stack([signature.bags for signature in described.signatures])
    return np.stack([model.distances(own, bags) for own in bags])


def view_distances(described: DescribedSet, model: ShapeModel) -> FloatArray | None:
    """Compute the distances of the views, as `ViewModel.distances`."""
    views = [signature.views for signature in described.signatures if signature.views is not None]
    if model.views is None or len(views) < len(described.signatures):
        return None
    stored = np.stack([own.descriptors for own in views])
    return np.stack([model.views.distances(own, stored) for own in views])


def gradient_distances(described: DescribedSet, model: ShapeModel) -> FloatArray | None:
    """Compute the distances of the views' gradients alone, without the network."""
    views = [signature.views for signature in described.signatures if signature.views is not None]
    if model.views is None or model.views.network is None or len(views) < len(described.signatures):
        return None
    stored = np.stack([own.descriptors for own in views])
    return np.stack([model.views.part_distances(own, stored)[0] for own in views]).astype(np.float64)


def measure_distances(described: DescribedSet, model: ShapeModel) -> FloatArray | None:
    """Compute the differences of simple measures."""
    return _each(described, model, lambda compared, own, row: compared.parts(own, row, own)[3])


def kind_distances(described: DescribedSet, model: ShapeModel) -> FloatArray | None:
    """Compute the kind distances, as ``--rank kind`` sorts by."""
    return _each(described, model, lambda compared, own, row: compared.kind_distances(own, row, own))


def gated_distances(described: DescribedSet, model: ShapeModel) -> FloatArray | None:
    """Compute the distances that a search sorts by, without verification and without the walk."""
    return _each(described, model, lambda compared, own, row: compared.distances(own, row, own))


def _each(
    described: DescribedSet,
    model: ShapeModel,
    distances: Callable[[TraitDistances, Traits, int], FloatArray],
) -> FloatArray | None:
    if not TraitDistances.possible(model):
        return None
    compared = TraitDistances(model)
    own = compared.of(described.signatures)
    return np.stack([distances(compared, own, row) for row in range(len(own.ids))])


def search_distances(described: DescribedSet, model: ShapeModel) -> FloatArray:
    """Rank all shapes by the product's own search in a library of the set.

    Returns
    -------
    places : (n, n) array
        Place of each shape in the list of matches; 0 for the query itself.
    """
    count = len(described.signatures)
    places = np.zeros((count, count))
    with tempfile.TemporaryDirectory() as folder, Library.open(Path(folder, "set.sglib"), model) as library:
        rows = {
            library.add_signature(signature, name): row
            for row, (signature, name) in enumerate(zip(described.signatures, described.names, strict=True))
        }
        for row, signature in enumerate(progress_bar(described.signatures, "searching", count)):
            matches = library.query(signature, top=count, explain=0)
            order = [rows[match.shape_id] for match in matches if rows[match.shape_id] != row]
            places[row, order] = np.arange(1, count)
    return places


PARTS: dict[str, Part] = {
    "bags": bag_distances,
    "gradients": gradient_distances,
    "views": view_distances,
    "measures": measure_distances,
    "kind": kind_distances,
    "gate": gated_distances,
    "search": search_distances,
}
"""By name, in the order of the table. The query's own row and column do not matter."""
