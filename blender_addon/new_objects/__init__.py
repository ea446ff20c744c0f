# SPDX-License-Identifier: GPL-3.0-or-later
"""Check whether objects that are new in the scene are in the library already, or nearly."""

from . import known, operators, panel, properties, use

__all__ = ["register", "unregister"]

_MODULES = (properties, known, operators, use, panel)


def register() -> None:
    """Register this feature with Blender."""
    for module in _MODULES:
        module.register()


def unregister() -> None:
    """Unregister this feature."""
    for module in reversed(_MODULES):
        module.unregister()
