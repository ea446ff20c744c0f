# SPDX-License-Identifier: GPL-3.0-or-later
"""Query the library with the selection, and with matches as examples."""

from . import examples, menus, operators, other_file, panel, properties, versions

__all__ = ["register", "unregister"]

_MODULES = (properties, operators, menus, versions, examples, other_file, panel)


def register() -> None:
    """Register this feature with Blender."""
    for module in _MODULES:
        module.register()


def unregister() -> None:
    """Unregister this feature."""
    for module in reversed(_MODULES):
        module.unregister()
