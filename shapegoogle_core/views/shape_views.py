# SPDX-License-Identifier: MIT
"""`ShapeViews`: the described pictures of a shape, which a search compares and a library stores."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

__all__ = ["LEVELS", "ShapeViews", "packed_size", "unpack_descriptors"]

LEVELS = 7
"""Greatest value of a component; from −7 to 7 they take half a byte."""


@dataclass(frozen=True, eq=False)
class ShapeViews:
    """Described pictures of a shape in two poses, from `ViewModel.describe`.

    Attributes
    ----------
    descriptors : (2, width) array of int8
        Of each pose (straight; in principal axes): the components of all pictures, of the twelve of gradients
        and then of the six of the network. Integers from −7 to 7; only the direction of each picture's vector
        counts.
    made_by : str
        Identifier of the `ViewModel`; only views of the same one can be compared.

    Examples
    --------
    >>> import shapegoogle_core as sg
    >>> import trimesh
    >>> views = sg.load_model().views.describe(trimesh.creation.box((1, 2, 3)))
    >>> views.descriptors.shape, len(views.to_bytes())
    ((2, 3840), 3840)
    """

    descriptors: NDArray[np.int8]
    made_by: str

    def to_bytes(self) -> bytes:
        """Serialise for a library, two components a byte; see `unpack_descriptors`.

        Returns
        -------
        content : bytes
        """
        values = (self.descriptors.reshape(-1) + np.int8(LEVELS + 1)).astype(np.uint8)
        pairs = np.append(values, np.zeros(len(values) % 2, np.uint8)).reshape(-1, 2)
        return (pairs[:, 0] << 4 | pairs[:, 1]).astype(np.uint8).tobytes()


def packed_size(shape: tuple[int, int]) -> int:
    """Return the number of bytes that descriptors of a shape (2, width) take."""
    return -(-int(np.prod(shape)) // 2)


def unpack_descriptors(content: NDArray[np.uint8], shape: tuple[int, int]) -> NDArray[np.int8]:
    """Rebuild the descriptors of several shapes.

    Parameters
    ----------
    content : (n, bytes) array of uint8
        Rows are results of `ShapeViews.to_bytes`.
    shape : (int, int)
        Shape of the descriptors of each.

    Returns
    -------
    descriptors : (n, *shape) array of int8

    Examples
    --------
    >>> import numpy as np
    >>> from shapegoogle_core.views import ShapeViews, unpack_descriptors
    >>> views = ShapeViews(np.array([[-7, 0, 7]], np.int8), "made by hand")
    >>> unpack_descriptors(np.frombuffer(views.to_bytes(), np.uint8)[None], (1, 3)).tolist()
    [[[-7, 0, 7]]]
    """
    count, size = content.shape
    values = np.stack([content >> 4, content & 15], axis=2).reshape(count, 2 * size).astype(np.int8)
    return np.asarray(values[:, : int(np.prod(shape))] - np.int8(LEVELS + 1)).reshape(count, *shape)
