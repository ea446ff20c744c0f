# SPDX-License-Identifier: MIT
"""Evidence as a value and as JSON."""

from __future__ import annotations

import json
from typing import get_args

import pytest

from shapegoogle_core import Evidence
from shapegoogle_core.library.evidence import KINDS, EvidenceKind


def test_the_kinds_are_those_of_the_type() -> None:
    assert get_args(EvidenceKind) == KINDS


@pytest.mark.parametrize(
    ("evidence", "record"),
    [
        (
            Evidence("identical", factor=1.0, deviation=0.0),
            {"kind": "identical", "factor": 1.0, "deviation": 0.0},
        ),
        (
            Evidence("part of", factor=1.01, deviation=0.002, share=0.49),
            {"kind": "part of", "share": 0.49, "factor": 1.01, "deviation": 0.002},
        ),
        (
            Evidence(
                "re-posed",
                factor=1.0,
                displacement=0.1,
                probability=0.9,
                spectral_difference=0.02,
                residual=0.3,
            ),
            {
                "kind": "re-posed",
                "probability": 0.9,
                "displacement": 0.1,
                "spectral_difference": 0.02,
                "residual": 0.3,
                "factor": 1.0,
            },
        ),
        (
            Evidence("similar", factor=2.0, spectral_difference=0.5),
            {"kind": "similar", "spectral_difference": 0.5, "factor": 2.0},
        ),
    ],
)
def test_json_has_the_figures_that_apply_in_a_fixed_order(
    evidence: Evidence, record: dict[str, object]
) -> None:
    assert json.dumps(evidence.to_json()) == json.dumps(record)
