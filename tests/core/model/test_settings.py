# SPDX-License-Identifier: MIT
"""Settings survive JSON and refuse what does not exist."""

from __future__ import annotations

import json
from dataclasses import asdict, replace
from typing import Any

import numpy as np
import pytest

from shapegoogle_core.errors import ModelError
from shapegoogle_core.keypoints import DETECTORS, detect_keypoints
from shapegoogle_core.mesh import Mesh
from shapegoogle_core.model import PRESETS, ChannelSettings, ModelSettings
from shapegoogle_core.model.settings import BAGS, DESCRIPTORS
from shapegoogle_core.model.shape_bags import ChannelWords, shape_bags
from shapegoogle_core.model.working_shape import Placement, WorkingShape
from shapegoogle_core.spectral import compute_spectrum
from shapegoogle_core.words import bag_of_features, soft_words
from tests.core.conftest import Shapes

PARAMETERS: dict[str, dict[str, Any]] = {
    "hks": {"times": (0.01, 0.1)},
    "log-hks": {"times": (0.01, 0.1)},
    "si-hks": {"alpha": 2.0, "tau_start": -8.0, "tau_end": 0.0, "tau_step": 0.25, "frequencies": 3},
    "wks": {"low": 2.0, "high": 5.0, "count": 5, "sigma": 0.5},
}
"""Of descriptors that have no usual ones."""


def as_working_shape(mesh: Mesh, eigenpairs: int = 40) -> WorkingShape:
    return WorkingShape(mesh, compute_spectrum(mesh, eigenpairs), Placement(np.zeros(3), 1.0))


@pytest.mark.parametrize("name", sorted(PRESETS))
def test_presets_survive_json(name: str) -> None:
    settings = PRESETS[name]
    rebuilt = ModelSettings.from_dict(json.loads(json.dumps(asdict(settings))))
    assert json.dumps(asdict(rebuilt)) == json.dumps(asdict(settings))
    assert rebuilt.bag_size == settings.bag_size


def test_paper_preset_has_the_authors_parameters() -> None:
    """Facts of the authors' scripts: 200 eigenpairs, cotangent weights, six times, 48 words."""
    paper = PRESETS["paper"]
    (channel,) = paper.channels
    assert (paper.eigenpairs, paper.laplacian, paper.area) == (200, "cotangent", 40_000)
    assert channel.parameters["times"] == (1024.0, 1351.2, 1782.9, 2352.5, 3104.2, 4096.0)
    assert (channel.words, channel.sigma_factor, channel.pair_time) == (48, 2.0, 1024.0)
    assert paper.preprocessing is None
    assert paper.metric == "l1"


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"laplacian": "graph"}, "laplacian must be one of"),
        ({"metric": "l2"}, "metric must be"),
        ({"code_bits": 12}, "multiple of 8"),
        ({"eigenpairs": 0}, "eigenpairs must be"),
        ({"area": -1.0}, "area must be"),
        ({"projected": 0}, "projected must be"),
        ({"shrinkage": 2.0}, "shrinkage must be"),
        ({"channels": ()}, "at least one channel"),
    ],
)
def test_refuses_unknown_choices(change: dict[str, Any], message: str) -> None:
    with pytest.raises(ModelError, match=message):
        replace(PRESETS["default"], **change)


def test_other_descriptors_can_be_chosen_by_name() -> None:
    preset = PRESETS["default"]
    settings = preset.with_descriptors(["spin-images", "si-hks"])
    assert settings.channels[1] is preset.channels[2]
    assert settings.channels[0].descriptor == "spin-images"
    assert settings.channels[0].bags == preset.channels[0].bags
    assert replace(settings, channels=preset.channels) == preset
    with pytest.raises(ModelError, match=r"descriptor must be one of hks, .*mesh-hog"):
        preset.with_descriptors(["colour"])
    with pytest.raises(ModelError, match="parameters of 'wks' do not work"):
        preset.with_descriptors(["wks"])


def test_refuses_unknown_channels_and_settings() -> None:
    with pytest.raises(ModelError, match="descriptor must be one of"):
        ChannelSettings("curvature", {})
    with pytest.raises(ModelError, match="bags must be some of"):
        ChannelSettings("hks", {}, bags=("triples",))
    with pytest.raises(ModelError, match="detector must be one of hks-maxima, mesh-dog"):
        ChannelSettings("hks", {"times": (1.0,)}, bags=("plain",), detector="sift")
    with pytest.raises(ModelError, match="bags must be some of plain, plain-pairs"):
        ChannelSettings("hks", {"times": (1.0,)}, bags=("area",), detector="hks-maxima")
    for parameters in ({"times": (-1.0,)}, {"times": (1.0,), "future": 1}, {}):
        with pytest.raises(ModelError, match="parameters of 'hks' do not work"):
            ChannelSettings("hks", parameters)
    for change in ({"words": 0}, {"pair_time": -1.0}, {"sigma_factor": 0.0}):
        with pytest.raises(ModelError, match="must be"):
            ChannelSettings("hks", {"times": (1.0,)}, **change)
    values = asdict(PRESETS["paper"])
    with pytest.raises(ModelError, match="unknown settings future"):
        ModelSettings.from_dict({**values, "future": 1})
    del values["channels"]
    with pytest.raises(ModelError, match="damaged"):
        ModelSettings.from_dict(values)


@pytest.mark.parametrize("descriptor", sorted(DESCRIPTORS))
@pytest.mark.parametrize("square_root", [True, False])
@pytest.mark.parametrize("soft", [True, False])
def test_every_descriptor_and_bag_works(descriptor: str, square_root: bool, soft: bool, bumpy: Mesh) -> None:
    channel = ChannelSettings(
        descriptor, PARAMETERS.get(descriptor, {}), words=4, soft=soft, bags=BAGS, pair_time=0.05
    )
    settings = ModelSettings("test", (channel,), square_root=square_root, code_bits=8)
    shape = as_working_shape(bumpy)
    spectrum = shape.spectrum
    descriptors = DESCRIPTORS[descriptor](shape.mesh, spectrum, **channel.parameters)
    assert descriptors.shape == (len(bumpy.vertices), channel.size)
    words = ChannelWords(descriptors[[0, 100, 200, 300]], float(descriptors.std()))
    bags = shape_bags(settings, (words,), shape)
    assert bags.shape == (settings.bag_size,) == (2 * 4 + 2 * 10,)
    ends = np.cumsum(channel.bag_sizes())
    for bag in np.split(bags, ends[:-1]):
        assert (bag**2 if square_root else bag).sum() == pytest.approx(1, abs=1e-5)


@pytest.mark.parametrize("detector", DETECTORS)
def test_bags_of_detected_points_are_sums_over_them(detector: str, bumpy: Mesh) -> None:
    """Equations 13 and 15 written out, over the points X' of algorithm 2."""
    channel = ChannelSettings(
        "hks", PARAMETERS["hks"], words=4, bags=("plain", "plain-pairs"), pair_time=0.05, detector=detector
    )
    settings = ModelSettings("test", (channel,), square_root=False, code_bits=8)
    shape = as_working_shape(bumpy)
    spectrum = shape.spectrum
    descriptors = DESCRIPTORS["hks"](shape.mesh, spectrum, **PARAMETERS["hks"])
    words = ChannelWords(descriptors[[0, 100, 200, 300]], float(descriptors.std()))
    plain, pairs = np.split(shape_bags(settings, (words,), shape), [4])

    points = detect_keypoints(bumpy, spectrum, detector).indices
    assert 1 < len(points) < 50
    theta = soft_words(descriptors, words.centers, words.sigma)[points]
    assert plain == pytest.approx(theta.mean(axis=0), abs=1e-6)
    expected = np.zeros((4, 4))
    decay = np.exp(-0.05 * spectrum.eigenvalues)
    for i, x in enumerate(points):
        for j, y in enumerate(points):
            kernel = (decay * spectrum.eigenvectors[x] * spectrum.eigenvectors[y]).sum()
            expected += np.outer(theta[i], theta[j]) * kernel
    expected *= (2 - np.eye(4)) / expected.sum()
    assert pairs == pytest.approx(expected[np.triu_indices(4)], abs=1e-6)


def test_where_nothing_stands_out_all_vertices_count(shapes: type[Shapes]) -> None:
    channel = ChannelSettings(
        "hks", PARAMETERS["hks"], words=2, bags=("plain",), pair_time=0.05, detector="hks-maxima"
    )
    settings = ModelSettings("test", (channel,), square_root=False, code_bits=8)
    shape = as_working_shape(shapes.sphere(3))
    descriptors = DESCRIPTORS["hks"](shape.mesh, shape.spectrum, **PARAMETERS["hks"])
    words = ChannelWords(descriptors[[0, 100]], 1.0)
    expected = bag_of_features(soft_words(descriptors, words.centers, words.sigma))
    assert shape_bags(settings, (words,), shape) == pytest.approx(expected)


def test_a_detector_is_kept_and_none_leaves_no_trace() -> None:
    paper = PRESETS["paper"]
    assert all("detector" not in channel for channel in paper.to_dict()["channels"])
    (channel,) = paper.channels
    chosen = replace(paper, channels=(replace(channel, detector="harris-3d"),))
    stored = json.loads(json.dumps(chosen.to_dict()))
    assert stored["channels"][0]["detector"] == "harris-3d"
    assert ModelSettings.from_dict(stored).channels[0].detector == "harris-3d"
    assert ModelSettings.from_dict(json.loads(json.dumps(paper.to_dict()))).channels[0].detector is None
