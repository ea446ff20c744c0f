# SPDX-License-Identifier: MIT
"""Keypoint detection: points of a shape that are found again in its other versions (paper, section 3.1)."""

from shapegoogle_core.keypoints.detection import Keypoints, detect_keypoints
from shapegoogle_core.keypoints.persistence import persistent_maxima
from shapegoogle_core.keypoints.registry import DETECTORS

__all__ = ["DETECTORS", "Keypoints", "detect_keypoints", "persistent_maxima"]
