# SPDX-License-Identifier: MIT
"""Signatures are grouped by the similarity that a model gives them."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from shapegoogle_core.library.duplicates.similar import distance_at, group_similar
from shapegoogle_core.model import ShapeModel, ShapeSignature

SignatureMaker = Callable[..., ShapeSignature]


def test_distance_at_is_the_inverse_of_similarity(model: ShapeModel) -> None:
    similarities = np.array([0.01, 0.5, 0.95, 1.0])
    distances = np.array([distance_at(model, s) for s in similarities])
    np.testing.assert_allclose(model.similarity(distances), similarities)


def test_signatures_without_a_library_are_grouped_alike(
    model: ShapeModel, make_signature: SignatureMaker
) -> None:
    first, stranger = make_signature(3), make_signature(8)
    noise = np.random.default_rng(0).standard_normal(model.bag_size).astype(np.float32)
    bags = first.bags + 0.02 * noise
    near = ShapeSignature(bags, model.codes(bags[None])[0], 1.0, 100, 200)
    assert group_similar(model, []) == []
    ((leader, member),) = group_similar(model, [stranger, first, near], 0.9)
    assert (leader, member[0]) == ((1, 1.0), 2)
    assert member[1] == pytest.approx(
        model.similarity(model.distances(first.bags, near.bags[None]))[0], abs=1e-3
    )
