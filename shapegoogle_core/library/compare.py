# SPDX-License-Identifier: MIT
"""Comparison of two shapes without a library."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
from threadpoolctl import threadpool_limits

from shapegoogle_core.library.match import DISTANCE_DECIMALS, Match
from shapegoogle_core.library.origin import UNKNOWN
from shapegoogle_core.library.search.evidence.figures import BagFigures, PairFigures, with_kind
from shapegoogle_core.library.search.evidence.kinds import Compared
from shapegoogle_core.library.search.fusion import list_distances
from shapegoogle_core.library.search.prepared import PreparedQuery
from shapegoogle_core.library.search.query import FARTHEST, Query, QuerySamples
from shapegoogle_core.library.search.settings import SearchSettings
from shapegoogle_core.library.search.traits.distances import TraitDistances
from shapegoogle_core.library.search.verify import Sharing, Verifier, known_alignment
from shapegoogle_core.library.storage.signatures import round_bags
from shapegoogle_core.mesh import MeshLike, as_mesh
from shapegoogle_core.model import ShapeModel
from shapegoogle_core.model.loading import as_model
from shapegoogle_core.model.signature import ShapeSignature
from shapegoogle_core.registration import SHARED_SCALES, SurfaceSample

__all__ = ["compare"]


def compare(mesh_a: MeshLike, mesh_b: MeshLike, model: ShapeModel | str | Path | None = None) -> Match:
    """Compare two shapes: how likely they are the same shape, and what they have in common.

    The method is that of a search in a library with `mesh_b` as its only shape. Both shapes are described by
    bags of geometric words, whose distance and similarity are those of the model (Bronstein et al. 2011,
    sections 4 to 5). Where the bags are uncertain, the surfaces are aligned, and the distance is lowered by
    how well they fit (geometric verification, see `shapegoogle_core.library.search.verify`). The evidence
    comes from comparing the surfaces, see `Evidence`.

    Parameters
    ----------
    mesh_a : MeshLike
        The query: a `Mesh`, a tuple ``(vertices, faces)``, or an object with ``.vertices`` and ``.faces``.
    mesh_b : MeshLike
        The shape that it is compared with.
    model : ShapeModel, str or Path, optional
        Model that describes both, or its name or path as for `load_model`; the shipped one by default.

    Returns
    -------
    match : Match
        `mesh_b` as a match of the query `mesh_a`, with its distance, similarity and evidence. The evidence is
        None if the model takes no samples of surfaces.

    Raises
    ------
    MeshError
        If one of the shapes is not a mesh, or the model cannot describe it.
    ModelError
        If the model cannot be loaded.

    See Also
    --------
    Library.query : The same comparison with the shapes of a library.

    References
    ----------
    A. M. Bronstein, M. M. Bronstein, L. J. Guibas, M. Ovsjanikov: Shape Google: geometric words and
    expressions for invariant shape retrieval. ACM Transactions on Graphics 30(1), 2011.

    Examples
    --------
    >>> import trimesh
    >>> import shapegoogle_core as sg
    >>> box = trimesh.creation.box((1, 2, 3))
    >>> match = sg.compare((box.vertices, box.faces), (2 * box.vertices, box.faces))
    >>> match.evidence.kind, match.evidence.factor
    ('scaled', 2.0)
    """
    model = as_model(model)
    settings = SearchSettings()
    first, second = as_mesh(mesh_a, "mesh_a"), as_mesh(mesh_b, "mesh_b")
    signature, other = model.describe(first, keep_surface=True), model.describe(second)
    query = Query(model, [signature])
    bags = round_bags(other.bags)[None]
    embedded = model.embed(bags)
    distances = query.distances(model.comparable(bags, embedded))
    typical = query.typical_distances(model.background_distances(bags, embedded))
    usual = None if typical is None else float(typical[0])
    match = Match(
        name=second.name,
        source="",
        object_name="",
        distance=float(distances[0]),
        similarity=float(model.similarity(distances, typical)[0]),
        shape_id=0,
        vertex_count=other.vertex_count,
        face_count=other.face_count,
        area=other.area,
        origin=UNKNOWN.completed(""),
        bag_distance=float(distances[0]),
        typical_distance=usual,
    )
    if signature.sample is None or other.sample is None:
        return _with_kind_distance(model, match, signature, other)
    # To the precision of a library, so that the results are the same.
    sample = SurfaceSample.from_bytes(other.sample.to_bytes())
    verifier = Verifier(
        lambda shape_ids: iter([(shape_id, sample) for shape_id in shape_ids]), model, settings.verification
    )
    prepared = PreparedQuery(signature, settings.evidence)
    if verifier.is_needed(match, several=False, cut=signature.sample.is_cut):
        scales = {} if model.local_words is None else {match.shape_id: range(len(SHARED_SCALES))}
        samples = QuerySamples([prepared.prepared], lambda _: {})
        (match,) = verifier.verify(samples, [match], lambda: Sharing(scales, []))
    match = _with_kind_distance(model, match, signature, other)
    # On matrices of this size a second BLAS thread only doubles the processor time.
    with threadpool_limits(1, user_api="blas"):
        certain = settings.verification.enough(several=False, cut=signature.sample.is_cut)
        pair = PairFigures(model, settings, prepared, certain)
        compared = Compared(sample, match, other.measures)
        distance = float(model.distances(signature.bags, bags)[0])
        figures = BagFigures(distance, usual, float(distances[0]), usual)
        known = known_alignment(match, signature.sample)
        (position,) = pair.positions([compared], [figures], [known])
        similarity, evidence = pair.figures(compared, figures, position)
        evidence = with_kind(evidence, similarity, match.likeness)
        return replace(match, similarity=similarity, evidence=evidence)


def _with_kind_distance(
    model: ShapeModel, match: Match, signature: ShapeSignature, other: ShapeSignature
) -> Match:
    """Give a match its likeness, and the distance that a search sorts it by."""
    if not TraitDistances.possible(model) or model.ranking is None:
        return match
    traits = TraitDistances(model)
    kind = traits.kind_distances(traits.of([signature]), 0, traits.of([other]))
    distances = list_distances(model, model.ranking, kind, [match])
    return replace(
        match,
        distance=float(np.round(min(distances[0], FARTHEST), DISTANCE_DECIMALS)),
        likeness=float(model.ranking.likeness(kind)[0]),
    )
