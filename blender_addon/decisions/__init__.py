# SPDX-License-Identifier: GPL-3.0-or-later
"""What people decided about shapes of the library: made on a match or a duplicate, listed, and undone."""

from . import listed, menu, operators, panel, properties

__all__ = ["register", "unregister"]

_MODULES = (properties, operators, listed, menu, panel)


def register() -> None:
    """Register this feature with Blender."""
    for module in _MODULES:
        module.register()


def unregister() -> None:
    """Unregister this feature."""
    for module in reversed(_MODULES):
        module.unregister()
