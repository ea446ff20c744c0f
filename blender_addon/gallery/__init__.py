# SPDX-License-Identifier: GPL-3.0-or-later
"""The matches: pictures with labels, filters, and appending, linking, opening, selecting, marking them."""

from . import browse, compare, editor, finding, operators, properties

__all__ = ["register", "unregister"]

_MODULES = (properties, finding, browse, operators, compare, editor)


def register() -> None:
    """Register this feature with Blender."""
    for module in _MODULES:
        module.register()


def unregister() -> None:
    """Unregister this feature."""
    for module in reversed(_MODULES):
        module.unregister()
