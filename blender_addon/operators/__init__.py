# SPDX-License-Identifier: GPL-3.0-or-later
"""What the user presses, one file for each verb."""

from . import duplicates, examples, index, library, paint, place, query, select, train, transfer

__all__ = ["register", "unregister"]

_MODULES = (index, library, query, examples, place, transfer, paint, select, duplicates, train)


def register() -> None:
    """Make the operators known to Blender."""
    for module in _MODULES:
        module.register()


def unregister() -> None:
    """Take them back."""
    for module in reversed(_MODULES):
        module.unregister()
