# SPDX-License-Identifier: MIT
"""Two shapes without a library: the same result as a search in a library of one shape."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest

import shapegoogle_core as sg
from benchmarks.experiments.evidence_pairs import EvidencePair, make_pairs


@pytest.fixture(scope="module")
def pairs() -> dict[str, EvidencePair]:
    return {pair.detail: pair for pair in make_pairs("deer", 1234)}


@pytest.mark.parametrize("detail", ["moved and scaled", "other pose", "a part", "the whole", "another kind"])
def test_the_result_is_that_of_a_search(tmp_path: Path, pairs: dict[str, EvidencePair], detail: str) -> None:
    pair = pairs[detail]
    match = sg.compare(pair.query, pair.candidate)
    assert match.evidence is not None
    # How much alike two animals are is another question.
    assert match.evidence.kind in (pair.kind, "nothing in common" if pair.kind == "similar" else "")
    with sg.Library.open(tmp_path / "shapes.sglib") as library:
        shape_id = library.add(pair.candidate)
        (found,) = library.query(pair.query)
    # Only a shape of a library comes from somewhere.
    assert replace(match, shape_id=shape_id, origin=found.origin) == found


def test_a_model_without_samples_gives_no_evidence(
    make_model: Callable[..., sg.ShapeModel], meshes: list[sg.Mesh]
) -> None:
    match = sg.compare(meshes[0], meshes[0], make_model())
    assert (match.distance, match.similarity, match.evidence) == (0, 1, None)
    assert 0 <= sg.compare(meshes[0], meshes[4], make_model()).similarity < 1


def test_both_arguments_are_named_in_errors(meshes: list[sg.Mesh]) -> None:
    with pytest.raises(sg.MeshError, match="'mesh_b' is an object of the type int, not a mesh"):
        sg.compare(meshes[0], 7)  # type: ignore[arg-type]


def test_a_model_may_be_given_by_its_name(meshes: list[sg.Mesh]) -> None:
    assert sg.compare(meshes[0], meshes[1], "default") == sg.compare(meshes[0], meshes[1])
    with pytest.raises(sg.ModelError, match="cannot read the model 'none'"):
        sg.compare(meshes[0], meshes[1], "none")
