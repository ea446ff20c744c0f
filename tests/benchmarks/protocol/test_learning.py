# SPDX-License-Identifier: MIT
"""Training shapes of the variants: each shape as it is and transformed, from seeds."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

import numpy as np
import pytest

from benchmarks.creatures import CREATURE_KINDS
from benchmarks.protocol.learning import FileVersion, training_versions
from shapegoogle_core.errors import MeshError
from shapegoogle_core.model.augmentation import TRANSFORMATIONS


def test_every_creature_comes_as_it_is_and_transformed() -> None:
    versions = training_versions(individuals=2)
    assert len(versions) == 2 * 4 * len(CREATURE_KINDS)
    assert set(Counter(version.label for version in versions).values()) == {4}
    assert Counter(version.transformation for version in versions)["null"] == 2 * len(CREATURE_KINDS)
    kinds = {version.transformation for version in versions}
    assert kinds == {"null", "isometry", *TRANSFORMATIONS} - {"scale"}
    assert len({version.key for version in versions}) == len(versions)


def test_the_seed_decides() -> None:
    assert training_versions(seed=1, individuals=1) == training_versions(seed=1, individuals=1)
    assert training_versions(seed=1, individuals=1) != training_versions(seed=2, individuals=1)


def test_a_creature_is_posed_and_transformed() -> None:
    pytest.importorskip("skimage")
    null, *others = (version for version in training_versions(individuals=1) if version.label == "human-0")
    assert np.isfinite(null.mesh().vertices).all()
    for version in others:
        assert len(version.mesh().faces) > 100
        assert not np.array_equal(version.mesh().vertices, null.mesh().vertices)


def test_files_of_one_shape(tmp_path: Path, lumps: Path) -> None:
    content = (lumps / "nulls" / "null0.off").read_bytes()
    names = ["chair.off", "fox-pose0.off", "fox-pose1.off", "people/anna.off", "people/anna2.off"]
    for name in names:
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_bytes(content)
    versions = [v for v in training_versions(tmp_path, individuals=0) if isinstance(v, FileVersion)]
    assert Counter(version.label for version in versions) == {"chair": 4, "fox": 5, "people": 5}
    for version in versions:
        assert len(version.mesh().faces) > 10


def test_a_missing_folder(tmp_path: Path) -> None:
    with pytest.raises(MeshError, match="does not exist"):
        training_versions(tmp_path / "nowhere")
