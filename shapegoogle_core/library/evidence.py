# SPDX-License-Identifier: MIT
"""`Evidence`: the kind of a match, with the figures it rests on."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Literal, get_args

__all__ = ["KINDS", "SIZED_BY_AREA", "Evidence", "EvidenceKind"]

EvidenceKind = Literal[
    "identical",
    "moved",
    "scaled",
    "mirrored",
    "re-meshed",
    "version",
    "re-posed",
    "part of",
    "contains",
    "similar",
    "same kind",
    "nothing in common",
]

KINDS: tuple[EvidenceKind, ...] = get_args(EvidenceKind)
"""All kinds of evidence, seen from the query ("part of": the query is a part of the match)."""

SIZED_BY_AREA: tuple[EvidenceKind, ...] = ("re-posed", "similar", "same kind", "nothing in common")
"""Kinds of two surfaces that do not lie on each other: their relative size is that of their areas."""


@dataclass(frozen=True)
class Evidence:
    """Relation of a match to the query, found by comparing the two surfaces.

    Figures are rounded to four significant digits. Those that do not apply to a kind are None;
    ``docs/concepts/evidence.md`` lists the checks behind each kind and their tolerances.

    Attributes
    ----------
    kind : str
        One of `KINDS`.
    share : float or None
        Area of the part divided by the area of the whole, from 0 to 1. For "part of" and "contains".
    probability : float or None
        Probability that the match is the query in another pose, from 0 to 1. For "re-posed", and for
        "similar", "same kind" and "nothing in common" where a pose was considered.
    displacement : float or None
        How far the surface moved between the two poses, in units of the square root of the area; see
        `Isometry`.
    spectral_difference : float or None
        Mean relative difference of the lowest eigenvalues of the two surfaces.
    residual : float or None
        Deviation of the functional map between the two surfaces from an orthogonal matrix.
    factor : float
        Size of the match relative to the query; 1 for the same size.
    deviation : float or None
        Distance between the aligned surfaces that 95 % of the points do not exceed, in units of the square
        root of the query's area. For copies, other meshes of the same surface, and parts.

    Examples
    --------
    >>> from shapegoogle_core import Evidence
    >>> evidence = Evidence("scaled", factor=2.54, deviation=0.0003)
    >>> evidence.factor
    2.54
    >>> evidence.to_json()
    {'kind': 'scaled', 'factor': 2.54, 'deviation': 0.0003}
    """

    kind: EvidenceKind
    share: float | None = None
    probability: float | None = None
    displacement: float | None = None
    spectral_difference: float | None = None
    residual: float | None = None
    factor: float = 1.0
    deviation: float | None = None

    def to_json(self) -> dict[str, object]:
        """Convert to the object that ``shapegoogle query --json`` prints.

        Returns
        -------
        record : dict
            ``kind``, ``factor``, and the other figures that apply.
        """
        return {name: value for name, value in asdict(self).items() if value is not None}
