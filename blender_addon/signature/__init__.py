# SPDX-License-Identifier: GPL-3.0-or-later
"""Paint signatures, words and keypoints onto meshes."""

from . import operators, panel, properties, select_keypoints

__all__ = ["register", "unregister"]

_MODULES = (properties, operators, select_keypoints, panel)


def register() -> None:
    """Register this feature with Blender."""
    for module in _MODULES:
        module.register()


def unregister() -> None:
    """Unregister this feature."""
    for module in reversed(_MODULES):
        module.unregister()
