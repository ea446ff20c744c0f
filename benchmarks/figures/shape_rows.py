# SPDX-License-Identifier: MIT
"""Shapes side by side in a figure of matplotlib, for the examples and the pages of the documentation."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from numpy.typing import ArrayLike

from shapegoogle_core.mesh import MeshLike
from shapegoogle_core.rendering import canonical_view, render

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["show_shapes"]

_PIXELS, _INCHES = 420, 2.2


def show_shapes(
    meshes: Sequence[MeshLike],
    captions: Sequence[str] | None = None,
    colors: Sequence[ArrayLike | None] | None = None,
    columns: int = 4,
    up_axis: int | None = 2,
) -> Figure:
    """Draw shapes in rows, each below its caption.

    Parameters
    ----------
    meshes : sequence of MeshLike
    captions : sequence of str, optional
        One for each shape.
    colors : sequence of array_like or None, optional
        Colours of each shape as for `render`; None: grey.
    columns : int, optional
        Maximum number of shapes in a row.
    up_axis : {1, 2} or None, optional
        Up axis of the shapes, as for `canonical_view`: z (2), as of all procedural shapes; y (1); None to
        guess it.

    Returns
    -------
    figure : matplotlib.figure.Figure

    Raises
    ------
    ValueError
        If there are no shapes, or not one caption or colour for each.

    Examples
    --------
    >>> import trimesh
    >>> figure = show_shapes([trimesh.creation.box(), trimesh.creation.icosphere()], ["box", "ball"])
    >>> [axes.get_title() for axes in figure.axes]
    ['box', 'ball']
    """
    import matplotlib.pyplot as plt

    count = len(meshes)
    captions = [""] * count if captions is None else captions
    colors = [None] * count if colors is None else colors
    if not count or not count == len(captions) == len(colors):
        raise ValueError(
            f"{count} shapes need as many captions and colours, not {len(captions)} and {len(colors)}"
        )
    across = min(columns, count)
    down = -(-count // across)
    lines = max(caption.count("\n") + 1 for caption in captions)
    figure, grid = plt.subplots(
        down, across, squeeze=False, figsize=(_INCHES * across, (_INCHES + 0.2 * lines) * down)
    )
    for axes in grid.flat:
        axes.axis("off")
    for axes, mesh, caption, color in zip(grid.flat, meshes, captions, colors, strict=False):
        axes.imshow(render(mesh, color, (_PIXELS, _PIXELS), view=canonical_view(mesh, up_axis)))
        axes.set_title(caption, fontsize=10)
    figure.tight_layout()
    return figure
