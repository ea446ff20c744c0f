# SPDX-License-Identifier: MIT
"""A real model small enough to make in a millisecond, and signatures for it."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from shapegoogle_core.mesh import Mesh
from shapegoogle_core.model import ChannelSettings, ModelSettings, ShapeModel
from shapegoogle_core.model.shape_bags import ChannelWords
from shapegoogle_core.model.signature import ShapeSignature
from shapegoogle_core.views import ViewModel, learn_views
from tests.core.conftest import make_bumpy

SignatureMaker = Callable[..., ShapeSignature]


def build_model(seed: int = 0, *, metric: str = "cosine", code_bits: int = 72) -> ShapeModel:
    """An untrained model: six words, one bag of words and one of pairs, random projection and code."""
    random = np.random.default_rng(seed)
    channel = ChannelSettings("hks", {"times": [0.01, 0.03, 0.1], "normalize": True}, words=6)
    settings = ModelSettings(
        name="tiny",
        channels=(channel,),
        preprocessing=None,
        laplacian="cotangent",
        eigenpairs=20,
        projected=16,
        metric=metric,
        code_bits=code_bits,
    )
    size = settings.bag_size
    return ShapeModel(
        settings=settings,
        vocabularies=(ChannelWords(random.uniform(0.2, 1.0, (6, 3)), sigma=0.3),),
        weights=np.ones(size, np.float32),
        mean=np.zeros(size, np.float32),
        projection=random.standard_normal((size, 16)).astype(np.float16),
        directions=random.standard_normal((code_bits, 16)).astype(np.float32),
        thresholds=(0.1 * random.standard_normal(code_bits)).astype(np.float32),
        similarity_half=0.1,
        similarity_slope=2.0,
        trained_on="nothing: random numbers for tests",
    )


@pytest.fixture(scope="session")
def model() -> ShapeModel:
    return build_model()


@pytest.fixture(scope="session")
def other_model() -> ShapeModel:
    return build_model(seed=1)


@pytest.fixture(scope="session")
def make_model() -> Callable[..., ShapeModel]:
    return build_model


@pytest.fixture(scope="session")
def make_signature(model: ShapeModel) -> SignatureMaker:
    """Signatures of made-up bags: as many different ones as seeds."""

    def make(seed: int, of: ShapeModel = model) -> ShapeSignature:
        bags = np.random.default_rng(seed).dirichlet(np.full(of.bag_size, 0.3)).astype(np.float32) ** 0.5
        return ShapeSignature(
            bags=bags, code=of.codes(bags[None])[0], area=2.5 + seed, vertex_count=100 + seed, face_count=seed
        )

    return make


@pytest.fixture(scope="session")
def meshes() -> list[Mesh]:
    """Five shapes from flat to long, far enough apart for the tiny model."""
    bumpy = [make_bumpy(2, seed=seed) for seed in range(5)]
    return [
        Mesh(mesh.vertices * [1, 1, length], mesh.faces, mesh.name)
        for mesh, length in zip(bumpy, [0.2, 0.5, 1, 2, 4], strict=True)
    ]


@pytest.fixture(scope="session")
def view_model(meshes: list[Mesh]) -> ViewModel:
    """Learnt from five shapes, with few components; any shape can be described with it."""
    return learn_views(meshes, components=(24, 12))


@pytest.fixture
def path(tmp_path: Path) -> Path:
    """Where a library can be made."""
    return tmp_path / "shapes.sglib"
