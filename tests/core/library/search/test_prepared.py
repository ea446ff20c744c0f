# SPDX-License-Identifier: MIT
"""Queries that are prepared once."""

from __future__ import annotations

import pickle

import trimesh

import shapegoogle_core as sg
from shapegoogle_core.library.search.prepared import PreparedQueries
from shapegoogle_core.library.search.settings import EvidenceSettings


def test_a_query_is_prepared_once_although_it_is_sent_again() -> None:
    model = sg.load_model()
    box, other = (
        model.describe(trimesh.creation.box((1, 2, size)), keep_surface=True) for size in (3.0, 3.01)
    )
    queries = PreparedQueries(EvidenceSettings())
    prepared = queries.of(box)
    assert queries.of(box) is prepared
    assert queries.of(pickle.loads(pickle.dumps(box))) is prepared
    assert queries.of(other) is not prepared
    assert queries.of(other).explainer is queries.of(other).explainer


def test_without_its_surface_it_is_another_query() -> None:
    model, ball = sg.load_model(), trimesh.creation.icosphere()
    queries = PreparedQueries(EvidenceSettings())
    exact = queries.of(model.describe(ball, keep_surface=True))
    assert queries.of(model.describe(ball)) is not exact
