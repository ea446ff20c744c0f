# SPDX-License-Identifier: MIT
"""Feature detection: points of a shape that are found again (paper, section 3.1)."""

from shapegoogle_core.keypoints.detection import DETECTORS, Keypoints, detect_keypoints
from shapegoogle_core.keypoints.persistence import persistent_maxima

__all__ = ["DETECTORS", "Keypoints", "detect_keypoints", "persistent_maxima"]
