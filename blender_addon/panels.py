# SPDX-License-Identifier: GPL-3.0-or-later
"""The sidebar tab "Shape Google"."""

from __future__ import annotations

import bpy

__all__ = ["register", "unregister"]

register, unregister = bpy.utils.register_classes_factory(())
