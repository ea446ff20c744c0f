# SPDX-License-Identifier: MIT
"""`ShapeViews`: the described pictures of a shape, which a search compares and a library stores."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

__all__ = ["ShapeViews"]


@dataclass(frozen=True, eq=False)
class ShapeViews:
    """Described pictures of a shape in two poses, from `ViewModel.describe`.

    Attributes
    ----------
    descriptors : (2, 12, d) array of int8
        Of each pose (the shape's own axes; its principal axes) and each picture. Only the direction of each
        picture's vector counts.
    made_by : str
        Identifier of the `ViewModel`; only views of the same one can be compared.

    Examples
    --------
    >>> import shapegoogle_core as sg
    >>> import trimesh
    >>> views = sg.load_model().views.describe(trimesh.creation.box((1, 2, 3)))
    >>> views.descriptors.dtype, len(views.to_bytes())
    (dtype('int8'), 3840)
    """

    descriptors: NDArray[np.int8]
    made_by: str

    def to_bytes(self) -> bytes:
        """Serialise for a library.

        Returns
        -------
        content : bytes
            The descriptors, one byte each.
        """
        return self.descriptors.tobytes()
