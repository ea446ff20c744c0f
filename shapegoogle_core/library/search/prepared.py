# SPDX-License-Identifier: MIT
"""What comparing a query with surfaces needs of the query itself, made once for verification and evidence."""

from __future__ import annotations

from functools import cached_property

import numpy as np

from shapegoogle_core.errors import LibraryError
from shapegoogle_core.library.search.evidence.kinds import Compared, Explainer
from shapegoogle_core.library.search.settings import EvidenceSettings
from shapegoogle_core.model.signature import ShapeSignature
from shapegoogle_core.registration import PreparedSample

__all__ = ["PreparedQueries", "PreparedQuery"]

# Queries that are kept: a few megabytes each. Usually the matches of the latest one are explained.
_KEPT = 4


class PreparedQuery:
    """A query with a sample, prepared as far as it was needed.

    Parameters
    ----------
    signature : ShapeSignature
        With a sample.
    settings : EvidenceSettings
    """

    def __init__(self, signature: ShapeSignature, settings: EvidenceSettings) -> None:
        if signature.sample is None:
            raise LibraryError("the query has no sample of its surface to compare; describe it again")
        self.signature, self.sample, self._settings = signature, signature.sample, settings

    @cached_property
    def prepared(self) -> PreparedSample:
        """The sample for alignments."""
        return PreparedSample(self.sample)

    @cached_property
    def explainer(self) -> Explainer:
        """The comparison that finds the kinds of matches."""
        query = Compared(self.sample, self.signature, self.signature.measures)
        return Explainer(query, self.signature.surface, self._settings, self.prepared)


class PreparedQueries:
    """The latest queries of a library: their matches are often explained in portions.

    Parameters
    ----------
    settings : EvidenceSettings
    """

    def __init__(self, settings: EvidenceSettings) -> None:
        self._settings = settings
        self._latest: tuple[PreparedQuery, ...] = ()

    def of(self, signature: ShapeSignature) -> PreparedQuery:
        """Return the prepared query of a signature, or of an equal one that was sent again.

        Parameters
        ----------
        signature : ShapeSignature
            With a sample.

        Returns
        -------
        query : PreparedQuery
        """
        for known in self._latest:
            if known.signature is signature or _are_equal(known.signature, signature):
                return known
        made = PreparedQuery(signature, self._settings)
        self._latest = (made, *self._latest)[:_KEPT]
        return made


def _are_equal(first: ShapeSignature, second: ShapeSignature) -> bool:
    """Whether two signatures are of the same shape, in all that comparing surfaces uses."""
    own, other = first.measures, second.measures
    if first.area != second.area or (own is None) != (other is None):
        return False
    if own is not None and other is not None and own.to_bytes() != other.to_bytes():
        return False
    if first.sample is None or second.sample is None or (first.surface is None) != (second.surface is None):
        return False
    pairs = [
        (getattr(first.sample, name), getattr(second.sample, name))
        for name in (
            "center",
            "unit",
            "points",
            "normals",
            "radii",
            "descriptors",
            "eigenvalues",
            "modes",
            "packed_heat",
        )
    ]
    if first.surface is not None and second.surface is not None:
        pairs += [
            (first.surface.vertices, second.surface.vertices),
            (first.surface.faces, second.surface.faces),
        ]
    return all(np.array_equal(one, other) for one, other in pairs)
