# SPDX-License-Identifier: GPL-3.0-or-later
"""Shape Google for Blender: index a library, find the selected shape in it, see signatures and words.

One folder for each thing that the user does, with its panel, operators, properties and logic; each registers
its own classes:

- ``library``: the library file, its sources, indexing, training, and the Blender that reads .blend files;
- ``search``: the query, examples, and the answer;
- ``gallery``: pictures of the matches, their labels and filters, and appending, linking or marking a match;
- ``signature``: painting signatures, words and keypoints;
- ``duplicates``: groups of equal shapes, and linking their data;
- ``transfer``: carrying vertex groups, colours and UVs from a match to the query.

Shared: ``scene`` (objects and meshes), ``jobs`` (other processes), ``state`` (memory of the running add-on),
``session`` (results shown in the window), ``connections`` (other programs), ``preferences``, ``commands``.
Modules imported for registering must not import numpy or the core; those that need them are imported in
functions.
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
    wrapped_text,
)

__all__ = ["register", "unregister"]

_MODULES = (
    preferences,
    wrapped_text,
    library,
    search,
    gallery,
    signature,
    duplicates,
    transfer,
    session,
    commands,
)


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
