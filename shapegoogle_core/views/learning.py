# SPDX-License-Identifier: MIT
"""Learning of a `ViewModel` from pictures of any shapes; nothing needs a label."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from shapegoogle_core.mesh import MeshLike
from shapegoogle_core.views.gradients import gradient_parts, learn_gradients
from shapegoogle_core.views.network_views import features_of, learn_network
from shapegoogle_core.views.view_model import ViewModel, shape_pictures

__all__ = ["learn_views"]

COMPONENTS = (192, 256)
"""Components of a picture's gradients and of its network features: 24 · 192 + 12 · 256 half bytes are stored
for a shape."""


def learn_views(meshes: Iterable[MeshLike], components: tuple[int, int] = COMPONENTS) -> ViewModel:
    """Learn the whitening of pictures.

    Parameters
    ----------
    meshes : iterable of MeshLike
        The more varied they are the better; they need not resemble the shapes that are searched for.
    components : (int, int), optional
        Components of gradients, and of the network's features.

    Returns
    -------
    model : ViewModel

    Raises
    ------
    ValueError
        If there are fewer pictures than components.
    ModelError
        If the network cannot be used.
    """
    gradients, features = [], []
    for mesh in meshes:
        pictures = shape_pictures(mesh)
        gradients.append(gradient_parts(pictures.reshape(-1, *pictures.shape[2:])))
        features.append(features_of(pictures))
    for count, kind, found in zip(components, ("gradients", "features"), (gradients, features), strict=True):
        if (pictures_seen := sum(map(len, found))) < count:
            raise ValueError(
                f"{pictures_seen} pictures are too few to learn {count} components of {kind} from"
            )
    return ViewModel(
        learn_gradients(np.concatenate(gradients).astype(np.float64), components[0]),
        learn_network(np.concatenate(features).astype(np.float64), components[1]),
    )
