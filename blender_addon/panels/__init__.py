# SPDX-License-Identifier: GPL-3.0-or-later
"""The sidebar tab "Shape Google": one file for each panel."""

from . import duplicates, library, search, signature

__all__ = ["register", "unregister"]

_MODULES = (library, search, signature, duplicates)


def register() -> None:
    """Make the panels known to Blender."""
    for module in _MODULES:
        module.register()


def unregister() -> None:
    """Take them back."""
    for module in reversed(_MODULES):
        module.unregister()
