# SPDX-License-Identifier: MIT
"""`ViewModel`: from a mesh to its described pictures, and from these to distances.

Each picture shows the normals of the shape in one of twelve directions (see `directions`). All are described
by gradient histograms, as light field descriptors and their successors describe silhouettes and depth (Chen
et al. 2003; Papadakis et al. 2010), and one of each two opposite ones by a network that was trained on
photographs. Both are whitened by projections that were learnt from quite different shapes: common structure
then counts less than what sets shapes apart (Jégou and Chum 2012).

Whether two shapes look alike must not depend on how their files are turned. Two poses are described, straight
and in principal axes (see `poses`). Both are known up to quarter turns and flips, and a mirrored shape is the
same kind of thing. These 48 symmetries exchange the twelve pictures and mirror each of them, which the
gradients follow (see `gradients`).
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from shapegoogle_core.errors import ModelError
from shapegoogle_core.mesh import MeshLike, as_mesh
from shapegoogle_core.views.directions import DIRECTIONS
from shapegoogle_core.views.gradients import POSES, GradientViews, gradient_parts
from shapegoogle_core.views.network_views import NETWORK_PICTURES, NetworkViews
from shapegoogle_core.views.pictures import normal_pictures
from shapegoogle_core.views.points import fit_into_ball, surface_points
from shapegoogle_core.views.poses import principal_axes, straight_axes
from shapegoogle_core.views.shape_views import LEVELS, ShapeViews

__all__ = ["ViewModel", "shape_pictures"]

FloatArray = NDArray[np.float64]
Floats = NDArray[np.float32]

# Multiple of the spread of a picture's components that the largest level stands for.
_REACH = 2.5
# Share of the network in the distance, chosen on shapes to learn from (docs/concepts/views.md).
_NETWORK_SHARE = 0.7
# Spreads the distances of shapes that look alike, for sums with others; it changes no order by views.
_POWER = 1.4

# Shapes whose views are compared at once: as floats they take 2 MB.
_AT_ONCE = 64

_POINTS = 30_000
_PIXELS = 128


@dataclass(frozen=True, eq=False)
class ViewModel:
    """What is learnt about pictures: whitening of their gradients, and of a network's features.

    Attributes
    ----------
    gradients : GradientViews
    network : NetworkViews or None
        None for models that were made before the network was known.

    References
    ----------
    D.-Y. Chen, X.-P. Tian, Y.-T. Shen, M. Ouhyoung: On Visual Similarity Based 3D Model Retrieval. Computer
    Graphics Forum 22(3), 2003.
    P. Papadakis, I. Pratikakis, T. Theoharis, S. Perantonis: PANORAMA: A 3D Shape Descriptor Based on
    Panoramic Views for Unsupervised 3D Object Retrieval. International Journal of Computer Vision 89, 2010.
    H. Jégou, O. Chum: Negative Evidences and Co-occurrences in Image Retrieval: The Benefit of PCA and
    Whitening. European Conference on Computer Vision, 2012.
    M. Tan, Q. V. Le: EfficientNet: Rethinking Model Scaling for Convolutional Neural Networks. International
    Conference on Machine Learning, 2019.

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

    gradients: GradientViews
    network: NetworkViews | None = None

    @property
    def shape(self) -> tuple[int, int]:
        """Shape of `ShapeViews.descriptors`."""
        return POSES, self._gradient_width + NETWORK_PICTURES * self._network_components

    @cached_property
    def identifier(self) -> str:
        """16 hexadecimal digits, equal only for models whose views can be compared."""
        digest = hashlib.sha256()
        own = self.gradients
        for array in (own.mean, *own.projections, own.code_components):
            digest.update(np.ascontiguousarray(array).tobytes())
        if self.network is not None:
            for array in (self.network.mean, self.network.projection):
                digest.update(np.ascontiguousarray(array).tobytes())
            digest.update(self.network.digest.encode())
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

        Raises
        ------
        ModelError
            If the network cannot be used.
        """
        pictures = shape_pictures(mesh)
        described = [self.gradients.project(gradient_parts(pictures.reshape(-1, *pictures.shape[2:])))]
        if self.network is not None:
            described.append(self.network.describe(pictures))
        descriptors = np.concatenate([_rounded(part).reshape(POSES, -1) for part in described], axis=1)
        descriptors.setflags(write=False)
        return ShapeViews(descriptors, self.identifier)

    def distances(self, query: ShapeViews, stored: NDArray[np.int8]) -> FloatArray:
        """Compute the distances between one shape's views and those of others.

        1 − cos of corresponding pictures, averaged over the pictures of a pose. Gradients take the best of a
        pose's 48 positions (quarter turns, flips and mirror images), and principal axes count a little more
        than the straight pose; the network takes the pose that fits better. Their weighted mean is raised to
        the power 1.4.

        Parameters
        ----------
        query : ShapeViews
        stored : (n, 2, width) array of int8
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
        gradients, network = self.part_distances(query, stored)
        apart = gradients if network is None else (1 - _NETWORK_SHARE) * gradients + _NETWORK_SHARE * network
        return np.asarray(np.clip(apart, 0, 2) ** _POWER, np.float64)

    def part_distances(self, query: ShapeViews, stored: NDArray[np.int8]) -> tuple[Floats, Floats | None]:
        """Compute the distances of gradients and of the network, which `distances` joins.

        Parameters
        ----------
        query : ShapeViews
        stored : (n, 2, width) array of int8

        Returns
        -------
        gradients : (n,) array
        network : (n,) array or None
            None for a model without a network.

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
        own, own_network = (part[0] for part in self._parts(query.descriptors[None]))
        positions = self.gradients.positions(own)
        gradients = np.empty(len(stored), np.float32)
        network = None if self.network is None else np.empty(len(stored), np.float32)
        for start in range(0, len(stored), _AT_ONCE):
            portion = slice(start, start + _AT_ONCE)
            others = self._parts(stored[portion])
            gradients[portion] = self.gradients.distances(positions, next(others))
            if self.network is not None and network is not None:
                network[portion] = self.network.distances(own_network, next(others))
        return gradients, network

    def code(self, views: ShapeViews) -> NDArray[np.uint8]:
        """Compute the binary code of a shape's views: the signs of the gradients' main components.

        Parameters
        ----------
        views : ShapeViews

        Returns
        -------
        code : (64,) array of uint8
            Packed as by `numpy.packbits`; the first half for the straight pose.
        """
        width = self._gradient_width
        return self.gradients.code(views.descriptors[:, :width].reshape(POSES, DIRECTIONS, -1))

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
        return self.gradients.code_alternatives(code)

    def _parts(self, descriptors: NDArray[np.int8]) -> Iterator[Floats]:
        """Split descriptors (n, 2, width), and scale the vector of each picture to unit length."""
        width, count = self._gradient_width, len(descriptors)
        yield _directions_of(descriptors[:, :, :width].reshape(count, POSES, DIRECTIONS, -1))
        yield _directions_of(
            descriptors[:, :, width:].reshape(count, POSES, NETWORK_PICTURES, self._network_components)
        )

    @property
    def _gradient_width(self) -> int:
        return DIRECTIONS * self.gradients.components

    @property
    def _network_components(self) -> int:
        return 0 if self.network is None else self.network.components


def shape_pictures(mesh: MeshLike) -> Floats:
    """Draw a shape in both poses.

    Parameters
    ----------
    mesh : MeshLike

    Returns
    -------
    pictures : (2, 12, 128, 128, 3) array of float32
        Of the straight pose, and in principal axes; see `normal_pictures`.
    """
    points, normals = surface_points(as_mesh(mesh), _POINTS)
    pictures = []
    for axes in (straight_axes(points, normals), principal_axes(points)):
        turn = axes.astype(np.float32)
        pictures.append(normal_pictures(fit_into_ball((turn @ points.T).T), (turn @ normals.T).T, _PIXELS))
    return np.stack(pictures)


def _rounded(components: Floats) -> NDArray[np.int8]:
    """Round the components (n, d) of each picture to levels relative to their spread."""
    spread = np.sqrt((components**2).mean(axis=1, keepdims=True))
    rounded = np.rint(components * (LEVELS / _REACH / np.where(spread > 0, spread, 1)))
    return rounded.clip(-LEVELS, LEVELS).astype(np.int8)


def _directions_of(descriptors: NDArray[np.int8]) -> Floats:
    """Scale the vector of each picture to unit length; zeros stay zeros."""
    vectors: Floats = descriptors.astype(np.float32)
    # A sum of small integers is exact in any order.
    norms = np.sqrt(np.einsum("...d,...d->...", vectors, vectors))[..., None]
    norms[norms == 0] = 1
    vectors /= norms
    return vectors
