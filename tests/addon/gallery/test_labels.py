# SPDX-License-Identifier: MIT
"""Texts of a match in the gallery."""

from __future__ import annotations

import importlib
from types import ModuleType
from typing import Any

import bpy
import pytest

from shapegoogle_core import Evidence
from shapegoogle_core.library.evidence import KINDS
from shapegoogle_core.library.origin import SHAPE_TYPES


@pytest.fixture
def labels(addon: ModuleType) -> Any:
    return importlib.import_module(f"{addon.__name__}.gallery.labels")


@pytest.fixture
def match(blender: ModuleType) -> Any:
    found = bpy.context.window_manager.shape_google.matches.add()
    found.name, found.object_name, found.source = "Horse", "Horse", "/assets/animals.blend"
    found.similarity, found.distance, found.size, found.vertex_count = 0.9812, 0.02, 0.978, 1234
    return found


@pytest.mark.parametrize(
    ("evidence", "label", "relation", "kind"),
    [
        (Evidence("re-posed", factor=0.978), "Re-posed", "Re-posed", "Re-posed ×0.978"),
        (Evidence("scaled", factor=2.54), "Scaled ×2.54", "Scaled ×2.54", "Scaled ×2.54"),
        (
            Evidence("part of", factor=1.1, share=0.49),
            "49 % of it",
            "The query is 49 % of it",
            "The query is 49 % of it ×1.1",
        ),
        (
            Evidence("contains", factor=1.0, share=0.2),
            "20 % of the query",
            "20 % of the query",
            "20 % of the query",
        ),
    ],
)
def test_evidence_below_a_picture_leaves_out_the_size(
    labels: Any, match: Any, evidence: Evidence, label: str, relation: str, kind: str
) -> None:
    match.size = evidence.factor
    labels.set_evidence(match, evidence)
    assert labels.below_picture(match) == f"0.98  {label}"
    size = f"1,234 vertices, size ×{evidence.factor:g}"
    assert labels.details(match) == [f"{relation}, similarity 0.98", size]
    assert match.kind == kind
    figures = f"Similarity 0.981, distance 0.0200\n{size}"
    assert labels.tooltip(match).endswith(f"\n{kind}\n{figures}")


def test_a_match_without_evidence_shows_only_its_similarity(labels: Any, match: Any) -> None:
    labels.set_evidence(match, None)
    assert labels.below_picture(match) == "0.98"
    assert labels.details(match)[0] == "Similarity 0.98"
    assert labels.tooltip(match).startswith("Horse in /assets/animals.blend\nSimilarity 0.981")


def test_a_match_that_is_being_compared_says_so(labels: Any, match: Any) -> None:
    match.evidence = labels.COMPARING
    assert labels.below_picture(match) == "0.98  Comparing …"


def test_every_kind_of_evidence_and_type_has_its_words(labels: Any) -> None:
    assert tuple(labels.KINDS) == KINDS
    assert tuple(labels.TYPES) == SHAPE_TYPES


def test_only_a_match_at_distance_zero_has_similarity_one(labels: Any, match: Any) -> None:
    match.similarity = 1.0
    assert labels.similarity_text(match) == "0.99+"
    match.distance = 0.0
    assert labels.similarity_text(match) == "1.00"
