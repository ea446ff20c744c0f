# SPDX-License-Identifier: MIT
"""`ViewModel`: from a mesh to its described pictures, and from these to distances.

Each picture shows the normals of the shape in one of twelve directions (see `directions`). It is described by
gradient histograms, as light field descriptors and their successors describe silhouettes and depth (Chen et
al. 2003; Papadakis et al. 2010), and whitened by a projection that was learnt from quite different shapes:
common structure then counts less than what sets shapes apart (Jégou and Chum 2012).

Whether two shapes look alike must not depend on how their files are turned. Two poses are described, straight
and in principal axes (see `poses`). Both are known up to quarter turns and flips, and a mirrored shape is the
same kind of thing. These 48 symmetries exchange the twelve pictures and mirror each of them.
The projection treats a picture's symmetric and antisymmetric parts separately, so that mirroring a picture
changes the sign of some components and does nothing else. All turned versions of a described shape are
therefore known without drawing anything.
"""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from shapegoogle_core.errors import ModelError
from shapegoogle_core.mesh import MeshLike, as_mesh
from shapegoogle_core.views.directions import DIRECTIONS, VIEW_ROTATIONS, Symmetry, symmetries
from shapegoogle_core.views.histograms import gradient_histograms, mirror_orbits
from shapegoogle_core.views.pictures import normal_pictures
from shapegoogle_core.views.points import fit_into_ball, surface_points
from shapegoogle_core.views.poses import principal_axes, straight_axes
from shapegoogle_core.views.shape_views import LEVELS, ShapeViews

__all__ = ["CODE_BYTES", "POSES", "ViewModel", "picture_parts"]

FloatArray = NDArray[np.float64]
Floats = NDArray[np.float32]

POSES = 2
"""Straight, and in principal axes."""

# Multiple of the spread of a picture's components that the largest level stands for.
_REACH = 2.5
# Chosen on procedural objects, upright and turned, and creatures (docs/concepts/views.md).
_WEIGHTS = (0.4, 0.6)
# Spreads the distances of shapes that look alike, for sums with others; it changes no order by views.
_POWER = 1.4

CODE_BYTES = 64
"""Length of the binary code of a shape's views: half of it for each pose."""

_POINTS = 30_000
_PIXELS = 64
# Factors of the channels of a picture (normal to the right, up and towards the viewer) when it is mirrored.
_SIGNS = ((-1, 1), (1, -1), (1, 1))
_ORBITS = mirror_orbits(_SIGNS)
# Parts of a picture that are symmetric or antisymmetric left to right and top to bottom: ++ −+ +− −−. Columns
# are orthonormal combinations of an entry and its three mirror images.
_PARTS = np.array([[1, 1, 1, 1], [1, -1, 1, -1], [1, 1, -1, -1], [1, -1, -1, 1]], np.float32) / 2
_SYMMETRIES = symmetries()
# Positions that codes of a query are computed for: comparing codes takes a time in proportion. Straight
# shapes usually have the same axis up; principal axes are seldom exchanged.
_UPRIGHT = tuple(s for s in _SYMMETRIES if abs(s.matrix[2, 2]) == 1)
_FLIPPED = tuple(s for s in _SYMMETRIES if (np.abs(np.diag(s.matrix)) == 1).all())


@dataclass(frozen=True, eq=False)
class ViewModel:
    """What is learnt about pictures: a whitening projection, and the components that codes are made of.

    Attributes
    ----------
    mean : (m,) array of float32
        Mean of the symmetric part of the training pictures; that of the other parts is zero.
    projections : tuple of four (m, d_i) arrays of float16
        Whitened principal components of each part, see `picture_parts`.
    code_components : (c,) array of int64
        Components whose signs are the code of each picture.

    Raises
    ------
    ModelError
        If the arrays do not fit together.

    References
    ----------
    D.-Y. Chen, X.-P. Tian, Y.-T. Shen, M. Ouhyoung: On Visual Similarity Based 3D Model Retrieval. Computer
    Graphics Forum 22(3), 2003.
    P. Papadakis, I. Pratikakis, T. Theoharis, S. Perantonis: PANORAMA: A 3D Shape Descriptor Based on
    Panoramic Views for Unsupervised 3D Object Retrieval. International Journal of Computer Vision 89, 2010.
    H. Jégou, O. Chum: Negative Evidences and Co-occurrences in Image Retrieval: The Benefit of PCA and
    Whitening. European Conference on Computer Vision, 2012.

    Examples
    --------
    >>> import shapegoogle_core as sg
    >>> import trimesh
    >>> model = sg.load_model().views
    >>> long, longer, ring = (
    ...     model.describe(mesh)
    ...     for mesh in (
    ...         trimesh.creation.box((1, 2, 6)),
    ...         trimesh.creation.box((1, 2, 7)),
    ...         trimesh.creation.torus(1.0, 0.3),
    ...     )
    ... )
    >>> near, far = model.distances(long, [longer.descriptors, ring.descriptors])
    >>> bool(near < 0.5 < far)
    True
    """

    mean: Floats
    projections: tuple[NDArray[np.float16], ...]
    code_components: NDArray[np.int64]

    def __post_init__(self) -> None:
        length = len(_ORBITS)
        fits = (
            self.mean.shape == (length,)
            and len(self.projections) == len(_PARTS)
            and all(part.ndim == 2 and len(part) == length for part in self.projections)
            and np.isfinite(self.mean).all()
            and all(np.isfinite(part).all() for part in self.projections)
            and self.code_components.ndim == 1
            and DIRECTIONS * self.code_components.size <= 8 * CODE_BYTES // POSES
            and ((self.code_components >= 0) & (self.code_components < self.components)).all()
        )
        if not fits:
            raise ModelError("the model's views are damaged: their arrays do not fit together")

    @property
    def components(self) -> int:
        """Number d of components of each described picture."""
        return sum(part.shape[1] for part in self.projections)

    @property
    def shape(self) -> tuple[int, int, int]:
        """Shape of `ShapeViews.descriptors`."""
        return POSES, DIRECTIONS, self.components

    @cached_property
    def identifier(self) -> str:
        """16 hexadecimal digits, equal only for models whose views can be compared."""
        digest = hashlib.sha256()
        for array in (self.mean, *self.projections, self.code_components):
            digest.update(np.ascontiguousarray(array).tobytes())
        return digest.hexdigest()[:16]

    def describe(self, mesh: MeshLike) -> ShapeViews:
        """Draw a shape and describe its pictures.

        Parameters
        ----------
        mesh : MeshLike
            As given: loose parts, holes and faces that meet in any way are no problem, nor is a point cloud.

        Returns
        -------
        views : ShapeViews
        """
        parts = picture_parts(as_mesh(mesh))
        parts[:, 0] -= self.mean
        described = np.concatenate(
            [parts[:, index] @ part for index, part in enumerate(self._projections)], axis=1
        )
        spread = np.sqrt((described**2).mean(axis=1, keepdims=True))
        rounded = np.rint(described * (LEVELS / _REACH / np.where(spread > 0, spread, 1)))
        descriptors = rounded.clip(-LEVELS, LEVELS).astype(np.int8).reshape(self.shape)
        descriptors.setflags(write=False)
        return ShapeViews(descriptors, self.identifier)

    def distances(self, query: ShapeViews, stored: NDArray[np.int8]) -> FloatArray:
        """Compute the distances between one shape's views and those of others.

        1 − cos of corresponding pictures, averaged over the pictures of a pose in the best of its 48
        positions (quarter turns, flips and mirror images); the principal axes count a little more than the
        straight pose. The result is raised to the power 1.4.

        Parameters
        ----------
        query : ShapeViews
        stored : (n, 2, 12, d) array of int8
            `ShapeViews.descriptors` of n shapes.

        Returns
        -------
        distances : (n,) array
            0 for the same views, about 1 for shapes that have nothing in common, at most 2. The same from
            either shape.

        Raises
        ------
        ModelError
            If the views are not those of this model.
        """
        stored = np.asarray(stored, np.int8)
        if query.made_by != self.identifier or stored.shape[1:] != self.shape:
            raise ModelError(
                f"views of this model ({self.identifier}) are arrays {self.shape}, but those of the query "
                f"({query.made_by}) are {query.descriptors.shape} and the others {stored.shape[1:]}; "
                "describe all shapes with this model"
            )
        others = _directions_of(stored)
        best = [
            self._greatest_cosines(pose, others[:, number])
            for number, pose in enumerate(_directions_of(query.descriptors))
        ]
        apart = np.clip(1 - np.asarray(_WEIGHTS) @ np.stack(best), 0, 2)
        return np.asarray(apart**_POWER, np.float64)

    def code(self, views: ShapeViews) -> NDArray[np.uint8]:
        """Compute the binary code of a shape's views: the signs of the main components of each picture.

        Parameters
        ----------
        views : ShapeViews

        Returns
        -------
        code : (64,) array of uint8
            Packed as by `numpy.packbits`; the first half for the straight pose.
        """
        return _packed(views.descriptors[:, :, self.code_components] > 0).reshape(-1)

    def code_alternatives(self, code: NDArray[np.uint8]) -> tuple[NDArray[np.uint8], NDArray[np.uint8]]:
        """Compute the codes of a shape in other positions, to compare with codes of other shapes.

        Parameters
        ----------
        code : (64,) array of uint8
            From `code`.

        Returns
        -------
        straight : (16, 32) array of uint8
            To be compared with the first half of other codes,
        principal : (8, 32) array of uint8
            and with the second half.
        """
        count = DIRECTIONS * len(self.code_components)
        bits = np.unpackbits(code.reshape(POSES, -1), axis=1, count=count).reshape(POSES, DIRECTIONS, -1)
        straight, principal = (
            np.stack([pose[s.pictures] * self._signs(s)[:, self.code_components] for s in positions])
            for pose, positions in zip(2 * bits.astype(np.int8) - 1, (_UPRIGHT, _FLIPPED), strict=True)
        )
        return _packed(straight > 0), _packed(principal > 0)

    def _greatest_cosines(self, query: Floats, others: Floats) -> Floats:
        """Mean cosines of pictures (12, d) with those of others (n, 12, d) in the best positions."""
        turned = np.stack([query[s.pictures] * self._signs(s) for s in _SYMMETRIES])
        products = turned.reshape(len(turned), -1) @ others.reshape(len(others), -1).T
        return np.asarray(products.max(axis=0) / DIRECTIONS, np.float32)

    @cached_property
    def _projections(self) -> tuple[Floats, ...]:
        return tuple(part.astype(np.float32) for part in self.projections)

    @cached_property
    def _mirrored(self) -> tuple[NDArray[np.int8], NDArray[np.int8]]:
        """Signs (d,) of the components when a picture is mirrored left to right, and upside down."""
        widths = [part.shape[1] for part in self.projections]
        across, over = (np.repeat(np.sign(_PARTS[row]), widths).astype(np.int8) for row in (1, 2))
        return across, over

    def _signs(self, symmetry: Symmetry) -> NDArray[np.int8]:
        """Signs (12, d) that the components of each picture take on."""
        across, over = self._mirrored
        mirrored = symmetry.mirrored
        return np.where(mirrored[:, :1], across, 1) * np.where(mirrored[:, 1:], over, 1)


def picture_parts(mesh: MeshLike) -> Floats:
    """Draw a shape in both poses, and split the gradient histograms of its pictures by symmetry.

    Parameters
    ----------
    mesh : MeshLike

    Returns
    -------
    parts : (24, 4, m) array of float32
        Parts that mirroring leaves alone, or turns into their negative: left to right, upside down.
    """
    points, normals = surface_points(mesh, _POINTS)
    pictures = []
    for axes in (straight_axes(points, normals), principal_axes(points)):
        turned = fit_into_ball(points @ axes.T)
        pictures.append(normal_pictures(turned, normals @ axes.T, VIEW_ROTATIONS, _PIXELS)[..., :3])
    histograms = gradient_histograms(np.concatenate(pictures))
    return np.asarray((histograms[:, _ORBITS] @ _PARTS).transpose(0, 2, 1), np.float32)


def _directions_of(descriptors: NDArray[np.int8]) -> Floats:
    """Scale the vector of each picture to unit length; zeros stay zeros."""
    vectors = descriptors.astype(np.float32)
    norms = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return np.asarray(vectors / np.where(norms > 0, norms, 1), np.float32)


def _packed(bits: NDArray[np.bool_]) -> NDArray[np.uint8]:
    """Pack bits (…, 12, c) to codes (…, 32)."""
    flat = bits.reshape(*bits.shape[:-2], -1)
    room = 8 * CODE_BYTES // POSES
    padded = np.zeros((*flat.shape[:-1], room), bool)
    padded[..., : flat.shape[-1]] = flat
    return np.packbits(padded, axis=-1)
