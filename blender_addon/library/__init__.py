# SPDX-License-Identifier: GPL-3.0-or-later
"""The library that is searched: its sources, indexing, and training a model on it."""

from . import index, moving, open_file, operators, panel, properties, service, status_bar, train

__all__ = ["register", "unregister"]

_MODULES = (properties, open_file, operators, service, index, moving, train, panel, status_bar)


def register() -> None:
    """Register this feature with Blender."""
    for module in _MODULES:
        module.register()


def unregister() -> None:
    """Unregister this feature."""
    for module in reversed(_MODULES):
        module.unregister()
