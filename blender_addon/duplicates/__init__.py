# SPDX-License-Identifier: GPL-3.0-or-later
"""Groups of the same and of similar shapes, to select and to link."""

from . import follow, link_operator, operators, panel, properties

__all__ = ["register", "unregister"]

_MODULES = (properties, operators, link_operator, follow, panel)


def register() -> None:
    """Register this feature with Blender."""
    for module in _MODULES:
        module.register()


def unregister() -> None:
    """Unregister this feature."""
    for module in reversed(_MODULES):
        module.unregister()
