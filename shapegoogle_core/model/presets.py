# SPDX-License-Identifier: MIT
"""Presets: the settings that models are trained with, those of the shipped models among them."""

from __future__ import annotations

import numpy as np

from shapegoogle_core.model.settings import ChannelSettings, ModelSettings
from shapegoogle_core.registration.local_words import LocalSettings
from shapegoogle_core.registration.sample import SampleSettings

__all__ = ["PAPER_AREA", "PAPER_TIMES", "PRESETS"]

PAPER_AREA = 40_000.0
"""Area of the authors' shapes, in their unit."""

PAPER_TIMES = (1024.0, 1351.2, 1782.9, 2352.5, 3104.2, 4096.0)
"""The authors' times, for shapes of that area (paper, section 6)."""


def _octaves(first: float, last: float) -> tuple[float, ...]:
    """Return the authors' times 2^first … 2^last, two for each octave, scaled to unit area."""
    exponents = np.arange(first, last + 0.25, 0.5)
    return tuple(float(f"{2.0**exponent / PAPER_AREA:.4g}") for exponent in exponents)


_ALL_BAGS = ("area", "plain", "pairs")

PRESETS: dict[str, ModelSettings] = {
    # Chosen on procedural creatures and CC0 models that it was not trained on
    # (docs/measurements/descriptors.md).
    "default": ModelSettings(
        name="default",
        channels=(
            ChannelSettings(
                "hks",
                {"times": _octaves(5, 12), "multiply_by_time": True, "normalize": True},
                words=40,
                bags=_ALL_BAGS,
            ),
            ChannelSettings("log-hks", {"times": _octaves(2, 10)}, words=40, bags=_ALL_BAGS),
            ChannelSettings(
                "si-hks",
                {"alpha": 2.0, "tau_start": -13.0, "tau_end": 0.0, "tau_step": 0.125, "frequencies": 6},
                words=40,
                bags=_ALL_BAGS,
            ),
        ),
        eigenpairs=100,
        code_directions="rotated",
        sample=SampleSettings(),
        local=LocalSettings(),
    ),
    "paper": ModelSettings(
        name="paper",
        channels=(
            ChannelSettings(
                "hks",
                {"times": PAPER_TIMES, "multiply_by_time": True, "normalize": True},
                words=48,
                bags=("plain-pairs",),
                pair_time=1024.0,
            ),
        ),
        preprocessing=None,
        area=PAPER_AREA,
        laplacian="cotangent",
        eigenpairs=200,
        square_root=False,
        metric="l1",
        code_bits=96,
    ),
}
"""Settings of the shipped models by name: "default", and "paper" with the authors' choices."""
