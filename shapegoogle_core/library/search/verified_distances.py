# SPDX-License-Identifier: MIT
"""Distances of bags, changed by what comparing two surfaces has found."""

from __future__ import annotations

import math

from shapegoogle_core.library.match import DISTANCE_DECIMALS
from shapegoogle_core.library.search.settings import VerificationSettings
from shapegoogle_core.model import ShapeModel
from shapegoogle_core.registration import Alignment

__all__ = ["bent_distance", "covers_whole", "lowered_distance"]

# Share of what an alignment has found, on a logarithmic scale, that is kept where local heat speaks against
# it.
_KEPT = 0.25
# Only a copy has the distance 0.
_LEAST_BENT = 10.0**-DISTANCE_DECIMALS


def lowered_distance(
    model: ShapeModel, settings: VerificationSettings, distance: float, alignment: Alignment, exact: float
) -> float:
    """Lower a distance of bags by how well the surfaces agree, and by the share that fits exactly.

    Parameters
    ----------
    model : ShapeModel
    settings : VerificationSettings
    distance : float
        Distance of the bags.
    alignment : Alignment
        From the query to the candidate.
    exact : float
        Share of the query that fits exactly.

    Returns
    -------
    distance : float
    """
    distance = model.verified_distance(distance, alignment.excess)
    distance *= math.exp(-settings.exact_gain * max(0.0, exact - settings.exact_from))
    return round(distance, DISTANCE_DECIMALS)


def covers_whole(settings: VerificationSettings, alignment: Alignment) -> bool:
    """Whether the query covers so much of a candidate that it is no part of it.

    Parameters
    ----------
    settings : VerificationSettings
    alignment : Alignment
        From the query to the candidate.

    Returns
    -------
    whole : bool
    """
    return float(alignment.candidate_axis_covered.mean()) >= settings.bent_whole


def bent_distance(
    model: ShapeModel,
    settings: VerificationSettings,
    distance: float,
    bags: float,
    exact: float,
    difference: float,
) -> float:
    """Change a verified distance by the difference of local heat.

    The distance of a difference x has the odds (x½ / x)ᵏ of the same shape; what an alignment has found
    lowers it a little, too. Where it is shorter than the verified one, it counts. A longer one takes back
    three quarters of what the alignment found, on a logarithmic scale: a relative in the query's pose can fit
    half of a bent part. It says nothing against bags, nor where the query fits exactly.

    Parameters
    ----------
    model : ShapeModel
    settings : VerificationSettings
    distance, bags : float
        Verified, and of the bags alone.
    exact : float
        Share of the query that fits exactly.
    difference : float
        From `BentPart`; infinite where it is not known.

    Returns
    -------
    distance : float
    """
    if math.isinf(difference):
        return distance
    exponent = settings.bent_exponent / model.verified_slope
    bent = float(model.verified_half * (difference / settings.bent_half) ** exponent)
    both = bent * (distance / bags) ** settings.bent_agreement if bags > 0 else bent
    if both < distance:
        return round(max(both, _LEAST_BENT), DISTANCE_DECIMALS)
    if exact >= settings.bent_exact:
        return distance
    between = math.pow(distance, _KEPT) * math.pow(bent, 1 - _KEPT)
    return max(distance, round(min(bags, between), DISTANCE_DECIMALS))
