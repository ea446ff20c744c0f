# SPDX-License-Identifier: MIT
"""Samples of candidates: in the order of the matches, with those that are missing."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.creatures import make_creature
from shapegoogle_core.library.match import Match
from shapegoogle_core.library.search.surfaces import Surfaces, candidate_supports, prepared_candidates
from shapegoogle_core.registration import (
    PreparedSample,
    SampleSettings,
    SurfaceSample,
    sample_surface,
    supports,
)
from shapegoogle_core.spectral import compute_spectrum


def in_memory(samples: dict[int, SurfaceSample]) -> Surfaces:
    """Samples in memory, as `Surfaces`."""
    return lambda shape_ids: ((one, samples[one]) for one in shape_ids if one in samples)


@pytest.fixture(scope="module")
def samples() -> dict[int, SurfaceSample]:
    found = {}
    for shape_id, kind in enumerate(("horse", "human", "crab"), start=1):
        mesh = make_creature(kind, 101, vertex_count=500).rest
        found[shape_id] = sample_surface(mesh, compute_spectrum(mesh, k=20), SampleSettings(80, 40))
    return found


def match(shape_id: int) -> Match:
    return Match(f"shape {shape_id}", "", "", 0.5, 0.5, shape_id, 1, 1, 1.0)


@pytest.mark.parametrize(
    "shape_ids", [[], [7], [1, 2, 3], [3, 1], [7, 3, 8, 9, 1, 10], [2, 7], [7, 8, 2], [5, 1, 5]]
)
def test_every_match_comes_once_and_in_its_place(
    samples: dict[int, SurfaceSample], shape_ids: list[int]
) -> None:
    matches = [match(shape_id) for shape_id in shape_ids]
    pairs = list(prepared_candidates(in_memory(samples), matches))
    assert [pair[0] for pair in pairs] == matches
    for found, prepared in pairs:
        if found.shape_id in samples:
            assert prepared is not None
            assert prepared.sample is samples[found.shape_id]
        else:
            assert prepared is None


def test_supports_are_those_of_each_shape_at_its_scales(samples: dict[int, SurfaceSample]) -> None:
    query = PreparedSample(samples[1], (1.0, 0.8, 0.6))
    found = candidate_supports(in_memory(samples), query, {3: [0, 2], 7: [1], 1: range(3)})
    assert set(found) == {1, 3}
    for shape_id, scales in ((3, [0, 2]), (1, [0, 1, 2])):
        asked = np.zeros((1, 3), bool)
        asked[0, scales] = True
        np.testing.assert_array_equal(found[shape_id], supports(query, [samples[shape_id]], asked)[0])
