# SPDX-License-Identifier: MIT
"""A library of shapes whose relation to one query is known, and their evidence."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from benchmarks.experiments.evidence_pairs import EvidencePair, make_pairs
from shapegoogle_core import Library, Match
from shapegoogle_core.library.evidence import Evidence


def kept(match: Match) -> Evidence:
    """Evidence of a match that has some."""
    assert match.evidence is not None, match.name
    return match.evidence


@pytest.fixture(scope="session")
def pairs() -> list[EvidencePair]:
    return make_pairs("deer", 1234)


@pytest.fixture(scope="session")
def answers(
    tmp_path_factory: pytest.TempPathFactory, pairs: list[EvidencePair]
) -> Iterator[tuple[Library, dict[str, Evidence]]]:
    """All candidates of one query in a library, and the evidence of each."""
    path: Path = tmp_path_factory.mktemp("evidence") / "shapes.sglib"
    query = pairs[0].query
    with Library.open(path) as library:
        for pair in pairs:
            if pair.query is query:
                library.add(pair.candidate, pair.detail)
        yield library, {match.name: kept(match) for match in library.query(query, top=20, explain=20)}
