# SPDX-License-Identifier: MIT
"""Settings survive JSON and refuse what does not exist."""

from __future__ import annotations

import json
from dataclasses import asdict, replace
from typing import Any

import pytest

from shapegoogle_core.errors import ModelError
from shapegoogle_core.model import PRESETS, ChannelSettings, ModelSettings


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


def test_a_detector_is_kept_and_none_leaves_no_trace() -> None:
    paper = PRESETS["paper"]
    assert all("detector" not in channel for channel in paper.to_dict()["channels"])
    (channel,) = paper.channels
    chosen = replace(paper, channels=(replace(channel, detector="harris-3d"),))
    stored = json.loads(json.dumps(chosen.to_dict()))
    assert stored["channels"][0]["detector"] == "harris-3d"
    assert ModelSettings.from_dict(stored).channels[0].detector == "harris-3d"
    assert ModelSettings.from_dict(json.loads(json.dumps(paper.to_dict()))).channels[0].detector is None


def test_errors_name_what_is_missing_or_unknown() -> None:
    with pytest.raises(
        ModelError, match="'wks' do not work: it needs low, high, count, sigma, which have no"
    ):
        ChannelSettings("wks", {})
    with pytest.raises(ModelError, match="'hks' do not work: it has no foo, only times, multiply_by_time"):
        ChannelSettings("hks", {"foo": 1})
    with pytest.raises(ModelError, match="'spin-images' do not work: they must be numbers"):
        ChannelSettings("spin-images", {"radius": "a"})
    with pytest.raises(ModelError, match="damaged: channels, name, preprocessing is missing; copy or train"):
        ModelSettings.from_dict({})
