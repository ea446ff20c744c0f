# SPDX-License-Identifier: MIT
# ruff: noqa: F811  (fixtures are imported, and requested by their names)
"""Small benchmarks: lumpy ellipsoids, an untrained model, and tasks that misbehave."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from benchmarks.protocol.cache import BenchmarkCache
from benchmarks.protocol.collection import Collection, LabelledCollection, database_shape, generated_queries
from benchmarks.protocol.workshop import Workshop
from shapegoogle_core.mesh import read_mesh
from shapegoogle_core.model import ChannelSettings, ModelSettings, ShapeModel
from shapegoogle_core.model.shape_bags import ChannelWords
from tests.core.conftest import bumpy, data_folder, make_mesh, shapes  # noqa: F401


def relevant_columns(collection: Collection) -> list[int]:
    """Index into the database of the shape that each query should find."""
    columns = {shape.name: column for column, shape in enumerate(collection.database)}
    return [columns[query.relevant] for query in collection.queries]


@pytest.fixture(scope="session")
def lumps(tmp_path_factory: pytest.TempPathFactory, make_mesh: Callable[..., Path]) -> Path:
    """A folder of three null shapes, two unrelated ones and a labelled collection."""
    folder = tmp_path_factory.mktemp("lumps")
    for seed in range(3):
        make_mesh(folder / "nulls" / f"null{seed}.off", seed)
        make_mesh(folder / "labelled" / "one" / f"{seed}.off", 7)
        make_mesh(folder / "labelled" / "two" / f"{seed}.off", 8)
    for seed in (3, 4):
        make_mesh(folder / "negatives" / f"other{seed}.off", seed)
    return folder


@pytest.fixture(scope="session")
def collection(lumps: Path) -> Collection:
    """Three null shapes and two others; each null shape queried at two sizes."""
    nulls = [database_shape(path, "null") for path in sorted((lumps / "nulls").iterdir())]
    negatives = [database_shape(path, "negative") for path in sorted((lumps / "negatives").iterdir())]
    queries = [query for query in generated_queries(nulls, ["scale"]) if query.strength < 3]
    return Collection("lumps", (*nulls, *negatives), tuple(queries))


@pytest.fixture(scope="session")
def labelled(lumps: Path) -> LabelledCollection:
    paths = sorted((lumps / "labelled").rglob("*.off"))
    shapes = [database_shape(path, "null", f"{path.parent.name}{path.stem}") for path in paths]
    return LabelledCollection("two kinds", tuple(shapes), tuple(path.parent.name for path in paths))


@pytest.fixture
def cache(tmp_path: Path) -> BenchmarkCache:
    return BenchmarkCache(tmp_path / "cache")


@pytest.fixture
def workshop(cache: BenchmarkCache) -> Workshop:
    """Works in this process."""
    return Workshop(cache, jobs=0, progress=lambda items, _title, _total: items)


@pytest.fixture(scope="session")
def tiny_model(lumps: Path) -> ShapeModel:
    """A model that learnt nothing but the mean of the lumps: six words, random projection and code."""
    random = np.random.default_rng(0)
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
    model = ShapeModel(
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
    bags = [model.describe(read_mesh(path)).bags for path in sorted(lumps.glob("n*/*.off"))]
    return replace(model, mean=np.mean(bags, axis=0, dtype=np.float32))
