# SPDX-License-Identifier: MIT
"""Settings survive JSON and refuse what does not exist."""

from __future__ import annotations

import json
from dataclasses import asdict, replace

import numpy as np
import pytest

from shapegoogle_core.describing import ChannelWords, Placement, WorkingShape, shape_bags
from shapegoogle_core.errors import ModelError
from shapegoogle_core.settings import BAGS, DESCRIPTORS, PRESETS, ChannelSettings, ModelSettings
from shapegoogle_core.spectrum import compute_spectrum

PARAMETERS = {
    "hks": {"times": (0.01, 0.1)},
    "log-hks": {"times": (0.01, 0.1)},
    "si-hks": {"alpha": 2.0, "tau_start": -8.0, "tau_end": 0.0, "tau_step": 0.25, "frequencies": 3},
    "wks": {"low": 2.0, "high": 5.0, "count": 5, "sigma": 0.5},
}
"""Of descriptors that have no usual ones."""


@pytest.mark.parametrize("name", sorted(PRESETS))
def test_presets_survive_json(name):
    settings = PRESETS[name]
    rebuilt = ModelSettings.from_dict(json.loads(json.dumps(asdict(settings))))
    assert json.dumps(asdict(rebuilt)) == json.dumps(asdict(settings))
    assert rebuilt.bag_size == settings.bag_size


def test_paper_preset_has_the_authors_parameters():
    """Facts of the authors' scripts: 200 eigenpairs, cotangent weights, six times, 48 words."""
    paper = PRESETS["paper"]
    (channel,) = paper.channels
    assert (paper.eigenpairs, paper.laplacian, paper.area) == (200, "cotangent", 40_000)
    assert channel.parameters["times"] == (1024.0, 1351.2, 1782.9, 2352.5, 3104.2, 4096.0)
    assert (channel.words, channel.sigma_factor, channel.pair_time) == (48, 2.0, 1024.0)
    assert paper.mending is None
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
def test_refuses_unknown_choices(change, message):
    with pytest.raises(ModelError, match=message):
        replace(PRESETS["default"], **change)


def test_other_descriptors_can_be_chosen_by_name():
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


def test_refuses_unknown_channels_and_settings():
    with pytest.raises(ModelError, match="descriptor must be one of"):
        ChannelSettings("curvature", {})
    with pytest.raises(ModelError, match="bags must be some of"):
        ChannelSettings("hks", {}, bags=("triples",))
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
def test_every_descriptor_and_bag_works(descriptor, square_root, soft, bumpy):
    channel = ChannelSettings(
        descriptor, PARAMETERS.get(descriptor, {}), words=4, soft=soft, bags=BAGS, pair_time=0.05
    )
    settings = ModelSettings("test", (channel,), square_root=square_root, code_bits=8)
    shape = WorkingShape(bumpy, compute_spectrum(bumpy, 40), Placement(np.zeros(3), 1.0))
    descriptors = DESCRIPTORS[descriptor](shape.mesh, shape.spectrum, **channel.parameters)
    assert descriptors.shape == (len(bumpy.vertices), channel.size)
    words = ChannelWords(descriptors[[0, 100, 200, 300]], float(descriptors.std()))
    bags = shape_bags(settings, (words,), shape)
    assert bags.shape == (settings.bag_size,) == (2 * 4 + 2 * 10,)
    ends = np.cumsum(channel.bag_sizes())
    for bag in np.split(bags, ends[:-1]):
        assert (bag**2 if square_root else bag).sum() == pytest.approx(1, abs=1e-5)
