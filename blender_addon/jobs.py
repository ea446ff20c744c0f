# SPDX-License-Identifier: GPL-3.0-or-later
"""Work beside Blender's window: background `blender -b` runs with progress and cancel, and one worker process."""

from __future__ import annotations

__all__ = ["stop_all"]


def stop_all() -> None:
    """End all background work."""
