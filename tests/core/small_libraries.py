# SPDX-License-Identifier: MIT
"""A small real model, folders of small meshes, and libraries of them: fixtures for indexing and commands."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest

from shapegoogle_core.indexing import ShapeReader, describe_shape, find_meshes
from shapegoogle_core.indexing.files import examine
from shapegoogle_core.library import Library
from shapegoogle_core.model import ChannelSettings, ModelSettings, ShapeModel
from shapegoogle_core.model.shape_bags import ChannelWords


def build_model(seed: int = 0) -> ShapeModel:
    """An untrained model: six words, one bag of words and one of pairs, random projection and code."""
    random = np.random.default_rng(seed)
    settings = ModelSettings(
        name="tiny",
        channels=(ChannelSettings("hks", {"times": [0.01, 0.03, 0.1], "normalize": True}, words=6),),
        preprocessing=None,
        laplacian="cotangent",
        eigenpairs=20,
        projected=16,
        code_bits=64,
    )
    size = settings.bag_size
    return ShapeModel(
        settings=settings,
        vocabularies=(ChannelWords(random.uniform(0.2, 1.0, (6, 3)), sigma=0.3),),
        weights=np.ones(size, np.float32),
        mean=np.zeros(size, np.float32),
        projection=random.standard_normal((size, 16)).astype(np.float16),
        directions=random.standard_normal((64, 16)).astype(np.float32),
        thresholds=np.zeros(64, np.float32),
        similarity_half=0.1,
        similarity_slope=2.0,
        trained_on="nothing: random numbers for tests",
    )


@pytest.fixture(scope="session")
def model() -> ShapeModel:
    return build_model()


@pytest.fixture(scope="session")
def model_file(model: ShapeModel, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("model") / "tiny.npz"
    model.save(path)
    return path


@pytest.fixture
def folder(tmp_path: Path, make_mesh: Callable[..., Path]) -> Path:
    """Three sound meshes in two folders."""
    make_mesh(tmp_path / "meshes" / "apple.off", seed=1)
    make_mesh(tmp_path / "meshes" / "pear.obj", seed=2)
    make_mesh(tmp_path / "meshes" / "more" / "plum.stl", seed=3)
    return tmp_path / "meshes"


@pytest.fixture
def indexed(library: Library, folder: Path) -> Library:
    """A library that knows `folder`, made without the time that worker processes take to start."""
    for path in find_meshes([folder]):
        state, (found,) = examine(path), ShapeReader().read(path).shapes
        shape = describe_shape(found, library.model)
        library.replace_source(
            path, size=state.size, mtime_ns=state.mtime_ns, sha256=state.sha256, shapes=[shape]
        )
    return library


@pytest.fixture
def library_file(tmp_path: Path) -> Path:
    return tmp_path / "shapes.sglib"


@pytest.fixture
def library(library_file: Path, model: ShapeModel) -> Iterator[Library]:
    with Library.open(library_file, model) as opened:
        yield opened
