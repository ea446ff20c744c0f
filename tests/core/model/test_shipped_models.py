# SPDX-License-Identifier: MIT
"""The shipped models: their identifiers and what they say of fixed meshes must never change unnoticed.

Libraries are tied to the identifier of their model, and signatures in them are compared with new ones. The
values in `golden_signatures.json` of "paper" and "default-0" are those from before the code was ordered by
pipeline stage; "default-0" is the default model as libraries have it that were made before preprocessing
became independent of triangles.
"""

from __future__ import annotations

import json
from dataclasses import replace
from importlib import resources
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from shapegoogle_core.mesh import Mesh
from shapegoogle_core.model import PRESETS, ShapeModel, load_model
from shapegoogle_core.model.settings import ModelSettings

MODELS = ("default", "default-0", "paper")
GOLDEN: dict[str, Any] = json.loads(
    Path(__file__).with_name("golden_signatures.json").read_text(encoding="utf-8")
)
CASES = [(name, shape) for name in MODELS for shape in GOLDEN[name]["shapes"]]


def shipped_model(name: str) -> ShapeModel:
    if name != "default-0":
        return load_model(name)
    model = load_model("default")
    assert model.settings.preprocessing is not None
    earlier = replace(model.settings.preprocessing, longest_edge=0.0)
    return replace(model, settings=replace(model.settings, preprocessing=earlier))


@pytest.fixture(scope="module")
def meshes(shapes: Any) -> dict[str, Mesh]:
    return {
        "bumpy 0": shapes.bumpy(3, 0),
        "bumpy 1": shapes.bumpy(4, 1),
        "rectangle": shapes.rectangle(2.0, 1.0, 30),
        "points": Mesh(shapes.bumpy(4, 2).vertices, name="points"),
    }


@pytest.mark.parametrize("name", ["default", "paper"])
def test_identifiers_are_those_that_libraries_know(name: str) -> None:
    model = load_model(name)
    assert model.identifier == GOLDEN[name]["identifier"]
    assert ShapeModel.from_bytes(model.to_bytes()).identifier == model.identifier


@pytest.mark.parametrize(("name", "shape"), CASES)
def test_signatures_are_those_that_libraries_hold(name: str, shape: str, meshes: dict[str, Mesh]) -> None:
    """Up to what another processor rounds differently."""
    model, expected = shipped_model(name), GOLDEN[name]["shapes"][shape]
    signature = model.describe(meshes[shape])
    bits = np.unpackbits(signature.code ^ np.frombuffer(bytes.fromhex(expected["code"]), np.uint8))
    assert bits.sum() <= 2
    assert signature.area == pytest.approx(expected["area"], rel=1e-9)
    vector = model.embed(signature.bags[None])[0]
    np.testing.assert_allclose(vector[: len(expected["vector"])], expected["vector"], atol=2e-4)
    if "unit" in expected:
        sample = signature.sample
        assert sample is not None
        assert signature.local_code is not None
        assert sample.unit == pytest.approx(expected["unit"], rel=1e-6)
        np.testing.assert_allclose(sample.eigenvalues[:4], expected["eigenvalues"], rtol=1e-4)
        np.testing.assert_allclose(
            sample.descriptors.mean(axis=0)[::4], expected["descriptors"], rtol=1e-2, atol=1e-2
        )
        assert np.unpackbits(signature.local_code).sum() == pytest.approx(expected["local_words"], abs=3)


@pytest.mark.parametrize("name", ["default", "paper"])
def test_shipped_models_are_small_and_have_the_settings_of_their_presets(name: str) -> None:
    shipped = resources.files("shapegoogle_core") / "model" / "shipped" / f"{name}.npz"
    assert len(shipped.read_bytes()) <= 4_000_000
    model = load_model(name)
    current = json.loads(json.dumps(PRESETS[name].to_dict()))
    assert json.loads(json.dumps(model.settings.to_dict())) == current, "train the shipped models again"
    assert model.name == name
    assert len(model.identifier) == 16


def test_models_from_before_the_longest_edge_keep_their_preprocessing() -> None:
    settings = shipped_model("default-0").settings
    described = settings.to_dict()
    assert "longest_edge" not in described["mending"]
    assert ModelSettings.from_dict(json.loads(json.dumps(described))) == settings


def test_models_from_before_there_were_samples_keep_their_identifier() -> None:
    """The settings of the paper's model have none of what was added later."""
    paper = load_model("paper")
    assert "sample" not in paper.settings.to_dict()
    assert paper.identifier == "219c13ef2a931c4c"
