# SPDX-License-Identifier: GPL-3.0-or-later
"""Ask with the selected shape, and with matches as examples."""

from . import examples, operators, panel, properties

__all__ = ["register", "unregister"]

_MODULES = (properties, operators, examples, panel)


def register() -> None:
    """Make this feature known to Blender."""
    for module in _MODULES:
        module.register()


def unregister() -> None:
    """Take it back."""
    for module in reversed(_MODULES):
        module.unregister()
