# SPDX-License-Identifier: GPL-3.0-or-later
"""Look at the matches and use them: append, link, open, select, mark."""

from . import browse, operators, properties

__all__ = ["register", "unregister"]

_MODULES = (properties, browse, operators)


def register() -> None:
    """Make this feature known to Blender."""
    for module in _MODULES:
        module.register()


def unregister() -> None:
    """Take it back."""
    for module in reversed(_MODULES):
        module.unregister()
