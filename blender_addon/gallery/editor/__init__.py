# SPDX-License-Identifier: GPL-3.0-or-later
"""The large gallery: an editor that shows the matches as pictures as large as its area allows."""

from . import area, dragging, draw, keys, menu, operators, search

__all__ = ["register", "unregister"]

# The keys last: they name the operators.
_MODULES = (area, operators, search, dragging, menu, draw, keys)


def register() -> None:
    """Register the editor with Blender."""
    for module in _MODULES:
        module.register()


def unregister() -> None:
    """Unregister it."""
    for module in reversed(_MODULES):
        module.unregister()
