# SPDX-License-Identifier: MIT
"""What kind of match a match is, by checks of geometry whose figures are shown.

The search orders by how likely two shapes are the same. Here it is said what they have in common: whether one
is a copy of the other, moved, scaled or mirrored; the same surface of another mesh; another pose; a part.
`docs/evidence.md` lists the checks, their tolerances, and how often they are right.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from threadpoolctl import threadpool_limits

from shapegoogle_core.library.match import Match
from shapegoogle_core.library.store import Store
from shapegoogle_core.library.verification import unpack_sample
from shapegoogle_core.mesh.mesh import FloatArray
from shapegoogle_core.model import ShapeModel, ShapeSignature
from shapegoogle_core.registration import Placed, SurfaceSample, align
from shapegoogle_core.registration.fit import Fit, Frame, Surface, fit, frame_between, mirrored
from shapegoogle_core.registration.isometry import functional_map

__all__ = ["EXPLAINED", "KINDS", "Explainer", "explain_matches"]

KINDS = (
    "identical",
    "moved",
    "scaled",
    "mirrored",
    "re-meshed",
    "re-posed",
    "part of",
    "contains",
    "similar",
)
"""All kinds of evidence: what the match is, seen from the query ("part of": the query is a part of it)."""

EXPLAINED = 50
"""How many of the best matches are explained, if nothing else is asked for."""

# Lengths are shares of √area of the query.
EXACT = 1e-3
"""What 95 % of a copy's points may lie off the query's surface: mending rounds no better."""

CLOSE = 5e-3
"""The same for another mesh of the same surface."""

NEAR = 1e-2
"""How near a point lies to a surface that covers it."""

# Share of either surface that must lie on the other one if they are the same.
_WHOLE = 0.97
# Share of the smaller surface that must lie on the larger one if it is a part of it: cuts are mended.
_PART = 0.85
# Relative difference of sizes that is none.
_SAME_SIZE = 2e-3
# Agreement from which on it pays to look closer.
_PROMISING = 0.45
# Matches this far down are not worth a second look from the other side, or for a mirror image.
_UNLIKELY = 0.05
# Probability that a shape is another pose: logistic regression on generated pairs, made by
# `scripts/benchmark_evidence.py --calibrate`.
_POSE_WEIGHTS = (-6.0, -2.0, -1.0)
_POSE_OFFSET = -13.0


class Explainer:
    """Explains matches of one query.

    Parameters
    ----------
    query : ShapeSignature
        With its sample and its surface.
    """

    def __init__(self, query: ShapeSignature) -> None:
        if query.sample is None or query.surface is None:
            raise ValueError("only a query with a sample and its surface can be compared; describe its mesh")
        self._query = query
        self._sample = query.sample
        self._placed = Placed(query.sample)
        self._surface = Surface(query.surface, query.sample)

    def explain(self, match: Match, sample: SurfaceSample) -> dict[str, object]:
        """Say what kind of match a shape is.

        Parameters
        ----------
        match : Match
        sample : SurfaceSample
            Of the matching shape.

        Returns
        -------
        evidence : dict
            ``kind``, one of `KINDS`, and the figures that it rests on; see `docs/evidence.md`.
        """
        query = self._query
        same_counts = (query.vertex_count, query.face_count) == (match.vertex_count, match.face_count)
        in_place = fit(self._surface, self._sample, sample, frame_between(self._sample, sample), steps=False)
        if _is_same(in_place, CLOSE):
            kind = "identical" if same_counts and _is_same(in_place, EXACT) else "re-meshed"
            return self._congruent(kind, in_place, sample)
        laid = self._laid(match, sample)
        if laid is not None and _is_same(laid, CLOSE):
            kind = "re-meshed"
            if same_counts and _is_same(laid, EXACT):
                kind = "moved" if abs(self._factor(laid, sample) - 1) <= _SAME_SIZE else "scaled"
            return self._congruent(kind, laid, sample)
        if match.similarity >= _UNLIKELY:
            reflected = self._laid(match, mirrored(sample))
            if reflected is not None and _is_same(reflected, CLOSE):
                return self._congruent("mirrored", reflected, sample)
        if laid is not None and (part := self._part(laid, sample)) is not None:
            return part
        return self._posed(match, sample)

    def _laid(self, match: Match, sample: SurfaceSample) -> Fit | None:
        """Lay a sample over the query and fit it, if that promises anything."""
        candidate = Placed(sample)
        alignment = align(self._placed, candidate)
        frame = Frame(alignment.scale, alignment.rotation, alignment.translation).inverse()
        agreement = alignment.agreement
        if agreement < _PROMISING and match.similarity >= _UNLIKELY:
            # A part finds its whole more easily than the whole its part.
            alignment = align(candidate, self._placed)
            frame = Frame(alignment.scale, alignment.rotation, alignment.translation)
            agreement = alignment.agreement
        if agreement < _PROMISING:
            return None
        return fit(self._surface, self._sample, sample, frame)

    def _factor(self, laid: Fit, sample: SurfaceSample) -> float:
        """Size of the match relative to the query's, both as their files have them."""
        return sample.unit / (self._sample.unit * laid.frame.scale)

    def _congruent(self, kind: str, laid: Fit, sample: SurfaceSample) -> dict[str, object]:
        factor = self._factor(laid, sample)
        if abs(factor - 1) <= _SAME_SIZE:
            factor = 1.0
        return {"kind": kind, "factor": _digits(factor), "deviation": _digits(laid.deviation)}

    def _part(self, laid: Fit, sample: SurfaceSample) -> dict[str, object] | None:
        """Whether most of one surface lies on the other, and not the reverse."""
        covered = laid.covered(NEAR)
        on_query, on_match = covered >= _PART, laid.query_covered >= _PART
        if on_query == on_match:
            return None
        kind = "contains" if on_query else "part of"
        # Areas tell the share more exactly than counted points: those at a cut lie on neither.
        larger, smaller = (1.0, laid.frame.scale**2) if on_query else (laid.frame.scale**2, 1.0)
        near = laid.distances[laid.distances <= NEAR]
        return {
            "kind": kind,
            "share": _digits(min(1.0, smaller / larger)),
            "factor": _digits(self._factor(laid, sample)),
            "deviation": _digits(float(np.quantile(near, 0.95))) if len(near) else NEAR,
        }

    def _posed(self, match: Match, sample: SurfaceSample) -> dict[str, object]:
        found = functional_map(self._sample, sample)
        features = pose_features(found.spectral_difference, found.orthogonality, found.unlikeness)
        odds = float(features @ np.array(_POSE_WEIGHTS)) + _POSE_OFFSET
        probability = 1 / (1 + math.exp(-max(-50.0, min(50.0, odds))))
        return {
            "kind": "re-posed" if probability >= 0.5 else "similar",
            "probability": _digits(probability),
            "displacement": _digits(found.displacement),
            "spectral_difference": _digits(found.spectral_difference),
            "residual": _digits(found.orthogonality),
            "factor": _digits(math.sqrt(match.area / self._query.area)),
        }


def pose_features(spectral_difference: float, orthogonality: float, unlikeness: float) -> FloatArray:
    """Take logarithms of the figures of an `Isometry` that the probability of another pose is made of."""
    return np.log(np.maximum([spectral_difference, orthogonality, unlikeness], 1e-3))


def explain_matches(
    store: Store, model: ShapeModel, query: ShapeSignature, matches: Sequence[Match], count: int = EXPLAINED
) -> list[Match]:
    """Add evidence to the best matches.

    Parameters
    ----------
    store : Store
    model : ShapeModel
    query : ShapeSignature
        With its sample and surface; without them nothing can be checked.
    matches : sequence of Match
        Best first.
    count : int, optional
        How many of them.

    Returns
    -------
    matches : list of Match
        All of them, in their order.
    """
    if query.sample is None or query.surface is None or count < 1:
        return list(matches)
    samples = store.samples([match.shape_id for match in matches[:count]])
    # On matrices of this size a second BLAS thread only doubles the processor time.
    with threadpool_limits(1, user_api="blas"):
        explainer = Explainer(query)
        explained = []
        for match in matches[:count]:
            data = samples.get(match.shape_id)
            evidence: Mapping[str, object] | None = None
            if data is not None:
                evidence = explainer.explain(match, unpack_sample(store, model, match.shape_id, data))
            explained.append(replace(match, evidence=evidence))
    return [*explained, *matches[count:]]


def _is_same(laid: Fit, tolerance: float) -> bool:
    return laid.deviation <= tolerance and laid.query_covered >= _WHOLE


def _digits(value: float) -> float:
    """Round to four significant digits: more would be noise."""
    return float(f"{value:.4g}")
