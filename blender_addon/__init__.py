# SPDX-License-Identifier: GPL-3.0-or-later
"""Shape Google for Blender: index a library, ask with the selected object, see the words.

Register and unregister, nothing else; what the user sees is in `panels`, what they press in `operators`.
"""

from . import commands, jobs, operators, panels, preferences, properties

__all__ = ["register", "unregister"]

_MODULES = (preferences, properties, operators, panels, commands)


def register() -> None:
    """Make everything known to Blender."""
    for module in _MODULES:
        module.register()


def unregister() -> None:
    """Take everything back, and end what runs in the background."""
    jobs.stop_all()
    for module in reversed(_MODULES):
        module.unregister()
