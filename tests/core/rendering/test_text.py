# SPDX-License-Identifier: MIT
"""Texts for people."""

from __future__ import annotations

import pytest

from shapegoogle_core import Evidence
from shapegoogle_core.rendering.text import evidence_text


@pytest.mark.parametrize(
    ("evidence", "text"),
    [
        (None, ""),
        (Evidence("identical", factor=1.0), "identical"),
        (Evidence("scaled", factor=2.54), "scaled ×2.54"),
        (Evidence("part of", share=0.493, factor=1.0), "the query is 49 % of it"),
        (Evidence("contains", share=0.3, factor=0.5), "30 % of the query ×0.5"),
        (Evidence("similar", factor=3.0), "similar"),
    ],
)
def test_evidence_in_words(evidence: Evidence | None, text: str) -> None:
    assert evidence_text(evidence) == text
