# SPDX-License-Identifier: GPL-3.0-or-later
"""Shape Google for Blender: index a library, find the selected shape in it, see signatures and words.

One folder for each thing that the user does, with its panel, operators, properties and logic; each registers
its own classes:

- ``library``: the library file, its sources, indexing, training, and the Blender that reads .blend files;
- ``search``: the query, examples, and the answer;
- ``gallery``: pictures of the matches, their labels and filters, and appending, linking or marking a match;
- ``signature``: painting signatures, words and keypoints;
- ``duplicates``: groups of equal shapes, and linking their data;
- ``decisions``: what was decided about matches and duplicates;
- ``replacing``: giving objects the mesh of a match;
- ``new_objects``: checking whether objects are in the library already;
- ``transfer``: carrying vertex groups, colours and UVs from a match to the query;
- ``translation``: the texts of all features in other languages.

Shared: ``scene`` (objects and meshes), ``jobs`` (other processes), ``state`` (memory of the running add-on),
``session`` (results shown in the window), ``connections`` (other programs), ``preferences``, ``commands``,
``documentation`` (the manual), ``needs`` (what a Blender without numpy shows instead).
Modules imported for registering must not import numpy or the core; those that need them are imported in
functions.
"""

from . import (
    commands,
    decisions,
    documentation,
    duplicates,
    gallery,
    jobs,
    library,
    needs,
    new_objects,
    preferences,
    replacing,
    search,
    server,
    session,
    signature,
    state,
    suggestions,
    transfer,
    translation,
    wrapped_text,
)

__all__ = ["register", "unregister"]

_MODULES = (
    translation,
    server,
    preferences,
    documentation,
    wrapped_text,
    library,
    search,
    gallery,
    signature,
    duplicates,
    decisions,
    replacing,
    new_objects,
    transfer,
    suggestions,
    session,
    commands,
)
# What a Blender without numpy gets: preferences, a panel and a command that say so.
_WITHOUT_PACKAGES = (translation, server, preferences, needs, commands)


def register() -> None:
    """Register everything with Blender; where a package is missing, only what says so."""
    state.start()
    registered = _WITHOUT_PACKAGES if needs.sentence() else _MODULES
    for module in registered:
        module.register()
    state.current().registered = registered


def unregister() -> None:
    """Unregister everything and end all background work."""
    jobs.stop_all()
    for module in reversed(state.current().registered):
        module.unregister()
    state.stop()
