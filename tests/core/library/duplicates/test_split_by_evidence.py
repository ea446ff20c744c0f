# SPDX-License-Identifier: MIT
"""Groups of duplicates are split by the evidence of their members."""

from __future__ import annotations

import pytest

from benchmarks.experiments.evidence_pairs import EvidencePair
from shapegoogle_core import Library
from shapegoogle_core.library.evidence import Evidence


def test_duplicates_are_grouped_by_kind(answers: tuple[Library, dict[str, Evidence]]) -> None:
    library, _ = answers
    groups = {group.kind: [member.name for member in group.members] for group in library.duplicates(0.5)}
    first = "a copy"
    assert groups["identical"] == [first, "other order of vertices and faces"]
    assert groups["moved"] == [first, "moved"]
    assert groups["scaled"] == [first, "moved and scaled"]
    assert groups["mirrored"] == [first, "reflected and moved"]
    assert set(groups["re-meshed"]) == {first, "other mesh, moved", "other mesh in place"}
    assert set(groups["re-posed"]) >= {first, "other pose"}


def test_exact_copies_are_recognised_without_alignment(
    answers: tuple[Library, dict[str, Evidence]], pairs: list[EvidencePair]
) -> None:
    library, _ = answers
    groups = library.duplicates(0.5, explained=0)
    kinds = {group.kind: group for group in groups}
    assert {"identical", "moved", "scaled", "mirrored", "not compared"} <= set(kinds)
    assert not {"re-meshed", "re-posed"} & set(kinds)
    scaled = next(pair for pair in pairs if pair.kind == "scaled")
    assert kinds["scaled"].members[1].scale == pytest.approx(scaled.factor, rel=1e-3)
    savings = [group.saved_faces for group in groups]
    assert savings == sorted(savings, reverse=True)
