# SPDX-License-Identifier: MIT
"""Bags of a shape: every descriptor and kind, and the definitions of the paper over detected points."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from shapegoogle_core.keypoints import DETECTORS, detect_keypoints
from shapegoogle_core.mesh import Mesh
from shapegoogle_core.model import ChannelSettings, ModelSettings
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
"""Parameters of descriptors without default ones."""


def as_working_shape(mesh: Mesh, eigenpairs: int = 40) -> WorkingShape:
    return WorkingShape(mesh, compute_spectrum(mesh, eigenpairs), Placement(np.zeros(3), 1.0))


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
