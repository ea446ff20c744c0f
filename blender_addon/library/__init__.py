# SPDX-License-Identifier: GPL-3.0-or-later
"""Which shapes are searched: the library, its sources, indexing and training."""

from . import index, operators, panel, properties, train

__all__ = ["register", "unregister"]

_MODULES = (properties, operators, index, train, panel)


def register() -> None:
    """Make this feature known to Blender."""
    for module in _MODULES:
        module.register()


def unregister() -> None:
    """Take it back."""
    for module in reversed(_MODULES):
        module.unregister()
