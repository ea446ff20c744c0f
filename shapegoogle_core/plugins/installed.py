# SPDX-License-Identifier: MIT
"""The list of installed plug-ins."""

from __future__ import annotations

from shapegoogle_core.api.registry import Plugin
from shapegoogle_core.descriptors import DESCRIPTORS
from shapegoogle_core.keypoints import DETECTORS
from shapegoogle_core.library.search.stages import CANDIDATE_STAGES, RERANKERS
from shapegoogle_core.mesh.io.reading import READERS

__all__ = ["installed_plugins"]


def installed_plugins() -> list[Plugin]:
    """Load all plug-ins of installed packages.

    Returns
    -------
    plugins : list of Plugin
        By kind and name; `Plugin.problem` of those that cannot be used says why.

    Examples
    --------
    >>> from shapegoogle_core.plugins import installed_plugins
    >>> [plugin.name for plugin in installed_plugins() if plugin.problem]
    []
    """
    return [
        plugin
        for registry in (DESCRIPTORS, DETECTORS, READERS, CANDIDATE_STAGES, RERANKERS)
        for plugin in registry.plugins()
    ]
