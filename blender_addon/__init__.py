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
    transfer,
)

__all__ = ["register", "unregister"]

_MODULES = (preferences, session, library, search, gallery, signature, duplicates, transfer, commands)


def register() -> None:
    """Make everything known to Blender."""
    for module in _MODULES:
        module.register()


def unregister() -> None:
    """Take everything back, and end what runs in the background."""
    jobs.stop_all()
    for module in reversed(_MODULES):
        module.unregister()
