# SPDX-License-Identifier: MIT
"""Fixtures of these tests."""

from __future__ import annotations

from typing import Any

import bpy
import pytest


@pytest.fixture
def shown(blender: Any) -> Any:
    settings = bpy.context.window_manager.shape_google_duplicates
    settings.groups.clear()
    settings.scope, settings.similar, settings.min_similarity = "SCENE", False, 0.95
    return settings
