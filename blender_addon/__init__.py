# SPDX-License-Identifier: GPL-3.0-or-later
"""Shape Google for Blender: index a library, ask with the selected object, see the words.

One folder for each thing that the user does, with its panel, operators, properties and logic; each registers
its own classes. What they share is beside them.
"""

from . import (
    commands,
    duplicates,
    gallery,
    jobs,
    library,
    preferences,
    search,
    session,
    signature,
    state,
    transfer,
)

__all__ = ["register", "unregister"]

_MODULES = (preferences, library, search, gallery, signature, duplicates, transfer, session, commands)


def register() -> None:
    """Register everything with Blender."""
    state.start()
    for module in _MODULES:
        module.register()


def unregister() -> None:
    """Unregister everything and end all background work."""
    jobs.stop_all()
    for module in reversed(_MODULES):
        module.unregister()
    state.stop()
