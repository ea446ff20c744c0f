# SPDX-License-Identifier: MIT
"""The paper's variants: what is learnt, that rows are what their names say, and what the cache saves."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from benchmarks.errors import BenchmarkError
from benchmarks.protocol.collection import Collection
from benchmarks.protocol.learning import CreatureVersion, FileVersion, training_versions
from benchmarks.protocol.matching import Matched, Variant
from benchmarks.protocol.workshop import Workshop
from benchmarks.variants import bag_variants
from benchmarks.variants.bag_variants import BagGroup, Descriptor, Preparation, bag_group
from benchmarks.variants.model_variants import ModelGroup
from benchmarks.variants.variants import choose_variants, paper_variants
from shapegoogle_core.errors import MeshError
from shapegoogle_core.keypoints import DETECTORS
from shapegoogle_core.mesh import Mesh
from shapegoogle_core.mesh.mesh import FloatArray
from shapegoogle_core.model import PRESETS, ModelSettings
from shapegoogle_core.model.settings import DESCRIPTORS
from shapegoogle_core.model.shape_bags import counted_points
from shapegoogle_core.model.working_shape import Placement, WorkingShape, working_shape
from shapegoogle_core.spectral import Spectrum
from shapegoogle_core.words import bag_of_features, soft_words, spatially_sensitive_bag
from tests.benchmarks.conftest import relevant_columns

PREPARATION = Preparation(
    "small",
    ModelSettings(
        "small", PRESETS["paper"].channels, preprocessing=None, laplacian="cotangent", eigenpairs=30
    ),
)
DESCRIPTOR = Descriptor("HKS", "hks", {"times": [0.01, 0.02, 0.04, 0.08]}, 0.02)

pytestmark = pytest.mark.filterwarnings("ignore:Number of distinct clusters")


def row(bag: str, words: int = 6, **parameters: str | int | float) -> Variant:
    return Variant(f"{bag} {words} {parameters}", "bags", {"bag": bag, "words": words, **parameters})


@pytest.fixture
def group(lumps: Path, monkeypatch: pytest.MonkeyPatch) -> BagGroup:
    def few(*_: object) -> tuple[CreatureVersion | FileVersion, ...]:
        return training_versions(lumps / "nulls", individuals=0)

    monkeypatch.setattr(bag_variants, "training_versions", few)
    monkeypatch.setattr(bag_variants, "MOST_BITS", 32)
    monkeypatch.setattr(bag_variants, "_PAIRS", 50)
    rows = [row(bag) for bag in ("bag of features", "spatially sensitive bag")]
    rows += [row(f"{bag}, by area") for bag in ("bag of features", "spatially sensitive bag")]
    rows += [
        row("bag of features", detector="harris-3d"),
        row("spatially sensitive bag", detector="mesh-dog"),
    ]
    rows += [row("bag of features, tf-idf", 12), row("spatially sensitive bag, tf-idf")]
    for projection in ("eigenvectors", "random"):
        rows += [row("spatially sensitive bag", bits=bits, projection=projection) for bits in (16, 32)]
    return bag_group(PREPARATION, DESCRIPTOR, tuple(rows), individuals=0)


def match(group: BagGroup, workshop: Workshop, collection: Collection) -> dict[str, Matched]:
    found = group.match(workshop, collection.queries, collection.database)
    return {entry.variant.name: entry for entry in found}


def test_rows_are_what_their_names_say(group: BagGroup, workshop: Workshop, collection: Collection) -> None:
    found = match(group, workshop, collection)
    vocabularies = group._learn(workshop).task.vocabularies
    words, points = {}, {}
    for shape in (collection.queries[1], collection.database[3]):
        prepared = working_shape(PREPARATION.settings, shape.mesh())
        values = DESCRIPTORS["hks"](prepared.mesh, prepared.spectrum, **DESCRIPTOR.parameters)
        theta = soft_words(values, vocabularies[6]["centers"], float(vocabularies[6]["sigma"]))
        words[shape.name] = (theta, prepared.spectrum)
        for detector in ("harris-3d", "mesh-dog"):
            points[detector, len(words) - 1] = counted_points(prepared.mesh, prepared.spectrum, detector)

    def distance(bag: Callable[[FloatArray, Spectrum], FloatArray]) -> float:
        first, second = (bag(*entry) for entry in words.values())
        return float(np.abs(first - second).sum())

    expected = {
        "bag of features": distance(lambda theta, _: bag_of_features(theta)),
        "bag of features, by area": distance(lambda theta, s: bag_of_features(theta, s.mass)),
        # Off the diagonal an entry counts for both its halves, so L1 is that of the full matrix.
        "spatially sensitive bag": distance(
            lambda theta, s: spatially_sensitive_bag(theta, s, 0.02, area_weighted=False)
        ),
        "spatially sensitive bag, by area": distance(
            lambda theta, s: spatially_sensitive_bag(theta, s, 0.02)
        ),
    }
    for bag, value in expected.items():
        assert found[row(bag).name].distances[1, 3] == pytest.approx(value, rel=1e-4)
    bags = [theta[points["harris-3d", index]].mean(axis=0) for index, (theta, _) in enumerate(words.values())]
    value = float(np.abs(bags[0] - bags[1]).sum())
    at_corners = found[row("bag of features", detector="harris-3d").name]
    assert at_corners.distances[1, 3] == pytest.approx(value, rel=1e-4)
    bags = [
        spatially_sensitive_bag(theta[chosen], spectrum.at(chosen), 0.02, area_weighted=False)
        for index, (theta, spectrum) in enumerate(words.values())
        for chosen in [points["mesh-dog", index]]
    ]
    value = float(np.abs(bags[0] - bags[1]).sum())
    between = found[row("spatially sensitive bag", detector="mesh-dog").name]
    assert between.distances[1, 3] == pytest.approx(value, rel=1e-4)
    assert found[row("bag of features").name].bytes_per_shape == 4 * 6
    assert 0 < found[row("bag of features").name].describe_seconds < 10
    assert found[row("spatially sensitive bag").name].bytes_per_shape == 4 * 21


def test_a_change_of_size_is_none(group: BagGroup, workshop: Workshop, collection: Collection) -> None:
    for entry in match(group, workshop, collection).values():
        own = entry.distances[np.arange(6), relevant_columns(collection)]
        assert own.max() < 1e-4


def test_a_short_code_is_the_beginning_of_a_long_one(
    group: BagGroup, workshop: Workshop, collection: Collection
) -> None:
    found = match(group, workshop, collection)
    for projection in ("eigenvectors", "random"):
        short, long = (
            found[row("spatially sensitive bag", bits=bits, projection=projection).name] for bits in (16, 32)
        )
        assert (short.distances <= long.distances).all()
        assert (long.distances <= short.distances + 16).all()
        assert (short.bytes_per_shape, long.bytes_per_shape) == (2, 4)


def test_a_second_run_computes_nothing(
    group: BagGroup, workshop: Workshop, collection: Collection, monkeypatch: pytest.MonkeyPatch
) -> None:
    first = match(group, workshop, collection)

    def refuse(workshop: Workshop, function: object, items: list[object], title: str) -> list[object]:
        assert not items, "it was computed before"
        return []

    monkeypatch.setattr(Workshop, "run", refuse)
    again = match(group, workshop, collection)
    for name, entry in first.items():
        np.testing.assert_array_equal(entry.distances, again[name].distances)


def test_words_that_all_shapes_have_weigh_nothing(
    group: BagGroup, workshop: Workshop, collection: Collection
) -> None:
    plain = bag_group(PREPARATION, DESCRIPTOR, (row("bag of features, tf-idf", 1),))
    assert match(plain, workshop, collection) == {}
    (problem,) = workshop.problems
    assert problem.kind == "note"
    assert "tf-idf weighs none" in problem.reason


def test_idf_of_hand_made_bags() -> None:
    # Four shapes; word 0 on all, word 1 on two, word 2 on one.
    hard = np.array([[0.5, 0.5, 0], [0.5, 0, 0.5], [0.3, 0.7, 0], [1, 0, 0]], np.float32)
    words = bag_variants._document_weights(hard, pairs=False)
    np.testing.assert_allclose(words, np.log([1, 2, 4]), rtol=1e-6)
    # As pairs, an entry below a third is no occurrence.
    pairs = bag_variants._document_weights(hard, pairs=True)
    np.testing.assert_allclose(pairs, np.log([4 / 3, 2, 4]), rtol=1e-6)


def test_the_table_is_complete() -> None:
    variants = [variant for group in paper_variants() for variant in group.variants]
    names = {variant.name for variant in variants}
    assert len(names) == len(variants)
    for descriptor in ("HKS", "SI-HKS"):
        for words in (4, 8, 16, 32, 48, 64, 128):
            for bag in ("bag of features", "spatially sensitive bag"):
                assert {f"{descriptor} · {bag}{w} · {words} words" for w in ("", ", tf-idf")} <= names
        for bits in (16, 32, 64, 128, 256, 512):
            assert {f"{descriptor} · {bits}-bit codes · {p}" for p in ("eigenvectors", "random")} <= names
    assert {"Shape-DNA", "D2 distribution", "WKS · bag of features · 48 words"} <= names
    assert "HKS · spatially sensitive bag · 48 words · preprocessed" in names
    for detector in DETECTORS:
        for bag in ("bag of features", "spatially sensitive bag"):
            assert f"HKS · {bag} at {detector} · 48 words · preprocessed" in names
    assert {"diffusion distances · preprocessed", "GPS distances", "moments"} <= names


def test_every_descriptor_has_its_row() -> None:
    rows = {
        group.descriptor.kind
        for group in paper_variants()
        if isinstance(group, BagGroup) and group.preparation.name == "preprocessed"
        for variant in group.variants
        if variant.name == f"{group.descriptor.name} · bag of features, by area · 48 words · preprocessed"
        and variant.headline
    }
    assert rows == set(DESCRIPTORS)


def test_choosing_rows() -> None:
    (group,) = choose_variants("hks*sensitive bag · 48 words", ["paper"])
    assert [variant.name for variant in group.variants] == ["HKS · spatially sensitive bag · 48 words"]
    chosen = choose_variants("models", ["paper", "default"])
    assert [group.model.name for group in chosen if isinstance(group, ModelGroup)] == ["paper", "default"]
    assert len(choose_variants("all", ["paper"])) == len(paper_variants()) + 1
    with pytest.raises(BenchmarkError, match="no variant is called 'zernike'"):
        choose_variants("zernike", ["paper"])


def placed(spectrum: Spectrum) -> WorkingShape:
    """A shape of this spectrum, whose mesh nobody looks at."""
    return WorkingShape(Mesh(np.zeros((len(spectrum.mass), 3))), spectrum, Placement(np.zeros(3), 1.0))


def test_a_soup_without_waves_has_the_values_of_what_the_spectrum_leaves_out() -> None:
    energies = {"low": 1.0, "high": 2.0, "count": 4, "sigma": 0.5}
    descriptor = Descriptor("WKS", "wks", energies, 0.02, without_waves=4 * (-10.0,))
    soup = placed(Spectrum(np.zeros(3), np.eye(3), np.ones(3)))
    np.testing.assert_array_equal(descriptor.values(soup, "soup"), np.full((3, 4), -10.0))
    # The third vertex lies on a part that no eigenvector reaches.
    vectors = np.vstack([np.linalg.qr(np.array([[1.0, 1, 0], [1, 0, 1], [1, 2, 5]]))[0][:2], np.zeros(3)])
    partly = placed(Spectrum(np.array([0.0, 5.0, 6.0]), vectors, np.ones(3)))
    np.testing.assert_array_equal(descriptor.values(partly, "partly")[2], np.full(4, -10.0))


def test_a_shape_without_the_descriptor_is_told() -> None:
    point = placed(Spectrum(np.array([0.0, 1.0]), np.eye(2), np.ones(2)))
    energies = {"low": 1.0, "high": 2.0, "count": 4, "sigma": 0.5}
    with pytest.raises(MeshError, match=r"'point' has no WKS: .* two positive eigenvalues"):
        Descriptor("WKS", "wks", energies, 0.02).values(point, "point")
