# SPDX-License-Identifier: MIT
"""Augmentation: the transformation classes of SHREC 2010, and bending, to train on and to test with.

The paper's section 6.1 names eleven classes. Ten of them are made here from any mesh. The eleventh, isometry,
is other poses of the same shape, which cannot be made from one mesh; `bend` comes near.
"""

from shapegoogle_core.model.augmentation.bending import bend, edge_length_changes
from shapegoogle_core.model.augmentation.classes import TRANSFORMATIONS, scale_factor, transform

__all__ = ["TRANSFORMATIONS", "bend", "edge_length_changes", "scale_factor", "transform"]
