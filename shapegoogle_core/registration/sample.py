# SPDX-License-Identifier: MIT
"""A few hundred oriented points that stand for a surface, and what it looks like around some of them."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from shapegoogle_core.descriptors import log_heat_kernel_signature
from shapegoogle_core.medial import medial_radii
from shapegoogle_core.mesh.mesh import FloatArray, Mesh
from shapegoogle_core.spectrum import Spectrum
from shapegoogle_core.spin_images import spin_images

__all__ = ["SampleSettings", "SurfaceSample", "sample_surface"]

# The sample is picked from so many random points.
_CLOUD = 4000
# Heat kernel signatures: times as a share of the area, two octaves apart; short ones see little of a cut.
_TIMES = 4.0 ** np.arange(1, 6) / 40_000
_OCTAVES_APART = 2
# Spin images of the surface and of the medial axis: radius as a share of √area, and bins.
_SURFACE_RADIUS, _AXIS_RADIUS, _BINS = 0.3, 0.35, (4, 3)
# Between the three kinds of descriptors, so that distances of each count alike.
_HEAT_WEIGHT, _SURFACE_WEIGHT, _AXIS_WEIGHT = 0.9, 5.0, 3.5
# Balls smaller than this are noise; one of almost the largest radius touches nothing on the other side.
_SMALLEST_RADIUS, _OPEN_RADIUS = 0.02, 0.45
_LEAST_COSINE = np.cos(np.radians(45))
# No medial ball is larger than this share of √area.
_LARGEST_RADIUS = 0.5
# Of stored numbers; descriptors are within ±12.
_NORMAL_UNIT, _RADIUS_UNIT, _DESCRIPTOR_UNIT = 1 / 127, _LARGEST_RADIUS / 127, 12 / 127
_DESCRIPTOR_SIZE = len(_TIMES) + 2 * _BINS[0] * _BINS[1]
_MOST_POINTS = 65_535
_HEADER = 10  # bytes


@dataclass(frozen=True)
class SampleSettings:
    """How many points stand for a surface.

    Attributes
    ----------
    points : int
        m, all points, evenly spread.
    keypoints : int
        k ≤ m of them, evenly spread too, have a descriptor.
    """

    points: int = 600
    keypoints: int = 192

    def __post_init__(self) -> None:
        if not 8 <= self.keypoints <= self.points <= _MOST_POINTS:
            raise ValueError(f"a sample needs 8 ≤ keypoints ≤ points ≤ {_MOST_POINTS}, not {self}")


@dataclass(frozen=True, eq=False)
class SurfaceSample:
    """Points of a surface, scaled to unit area and centred.

    Attributes
    ----------
    points : (m, 3) array
        In units of √area; any first part of them is evenly spread.
    normals : (m, 3) array
        Of unit length; which side they are on means nothing.
    radii : (m,) array
        Of the ball that touches there and holds no other point, see `medial_radii`.
    descriptors : (k, d) array of float32
        Of the first k points: logarithms of the heat kernel signature, and roots of the spin images of the
        surface and of the medial axis.
    """

    points: FloatArray
    normals: FloatArray
    radii: FloatArray
    descriptors: NDArray[np.float32]

    @property
    def centers(self) -> FloatArray:
        """(m, 3) points of the medial axis: the centres of those balls."""
        centers: FloatArray = self.points - self.radii[:, None] * self.normals
        return centers

    def descriptors_at(self, scale: float, keypoints: int | None = None) -> NDArray[np.float32]:
        """Descriptors that the surface would have if it were larger.

        When a part and its whole are both scaled to unit area, the part is too large; what is not swollen of
        a swollen surface is too small. Descriptors have a size of their own, so they must be told.

        Parameters
        ----------
        scale : float
            How many times larger, from 0.5 to 2.
        keypoints : int, optional
            Of so many of the first points; without it, of all that have descriptors.

        Returns
        -------
        descriptors : (k, d) array of float32
        """
        known = self.descriptors[:keypoints]
        if scale == 1:
            return known
        # t K_t at the size of the others is t/s² K_{t/s²} here.
        times = np.arange(len(_TIMES)) - 2 * math.log2(scale) / _OCTAVES_APART
        after = np.clip(np.floor(times).astype(int) + 1, 1, len(_TIMES) - 1)
        share = np.float32(times - after + 1)
        heat = known[:, after - 1] * (1 - share) + known[:, after] * share
        spin = _spin_images(scale * self.points, self.normals, scale * self.radii, len(known), scale**2)
        return np.concatenate([heat, spin], axis=1).astype(np.float32)

    def to_bytes(self) -> bytes:
        """Serialise in 10 bytes for each point and one for each number of a descriptor."""
        counts = np.array([len(self.points), *self.descriptors.shape], "<u2")
        unit = np.array([max(np.abs(self.points).max(), 1e-6) / 32767], "<f4")
        points = np.rint(self.points / float(unit[0])).clip(-32767, 32767).astype("<i2")
        normals = np.rint(self.normals / _NORMAL_UNIT).astype(np.int8)
        radii = np.clip(np.rint(self.radii / _RADIUS_UNIT), -127, 127).astype(np.int8)
        descriptors = np.clip(np.rint(self.descriptors / _DESCRIPTOR_UNIT), -127, 127).astype(np.int8)
        return b"".join(array.tobytes() for array in (counts, unit, points, normals, radii, descriptors))

    @classmethod
    def from_bytes(cls, data: bytes) -> Self:
        """Rebuild a sample from `to_bytes`.

        Parameters
        ----------
        data : bytes

        Returns
        -------
        sample : SurfaceSample
            Coordinates to 1/65,000 of the extent.

        Raises
        ------
        ValueError
            If the data is no sample.
        """
        if len(data) < _HEADER:
            raise ValueError(f"a surface sample has at least {_HEADER} bytes")
        points, keypoints, size = (int(count) for count in np.frombuffer(data, "<u2", 3))
        (unit,) = np.frombuffer(data, "<f4", 1, offset=6).astype(np.float64)
        if not (8 <= keypoints <= points and size == _DESCRIPTOR_SIZE and 0 < unit < np.inf):
            raise ValueError(
                f"a surface sample cannot have {points} points and {keypoints} keypoints with {size} numbers"
            )
        ends = np.cumsum([_HEADER, 6 * points, 3 * points, points, keypoints * size])
        if len(data) != ends[-1]:
            raise ValueError(f"a surface sample of {points} points has {ends[-1]} bytes, not {len(data)}")
        positions: FloatArray = np.frombuffer(data[_HEADER : ends[1]], "<i2").reshape(points, 3) * unit
        normals: FloatArray = np.frombuffer(data[ends[1] : ends[2]], np.int8).astype(np.float64)
        radii = np.frombuffer(data[ends[2] : ends[3]], np.int8).astype(np.float64) * _RADIUS_UNIT
        descriptors = np.frombuffer(data[ends[3] :], np.int8).reshape(keypoints, size)
        normals = normals.reshape(points, 3) * _NORMAL_UNIT
        return cls(positions, normals, radii, descriptors.astype(np.float32) * np.float32(_DESCRIPTOR_UNIT))


def sample_surface(mesh: Mesh, spectrum: Spectrum, settings: SampleSettings) -> SurfaceSample:
    """Spread points evenly over a surface and describe the surroundings of some.

    Parameters
    ----------
    mesh : Mesh
        Of positive area.
    spectrum : Spectrum
        Of that mesh.
    settings : SampleSettings

    Returns
    -------
    sample : SurfaceSample
        The same one whenever it is asked for.
    """
    random = np.random.default_rng(0)
    unit = math.sqrt(mesh.area)
    points, normals, face, corners = _random_points(mesh, max(settings.points, _CLOUD), random)
    points = (points - points.mean(axis=0)) / unit
    chosen = farthest_points(points, settings.points)
    radii = medial_radii(points[chosen], normals[chosen], points, _LARGEST_RADIUS)
    keys = chosen[: settings.keypoints]
    heat = log_heat_kernel_signature(spectrum, _TIMES * unit**2)
    heat = _HEAT_WEIGHT * (heat[mesh.faces[face[keys]]] * corners[keys, :, None]).sum(axis=1)
    spin = _spin_images(points[chosen], normals[chosen], radii, len(keys), 1.0)
    descriptors = np.concatenate([heat, spin], axis=1).astype(np.float32)
    return SurfaceSample(points[chosen], normals[chosen], radii, descriptors)


def _spin_images(
    points: FloatArray, normals: FloatArray, radii: FloatArray, keypoints: int, area: float
) -> FloatArray:
    """Roots of spin images of the first few points, and of their balls' centres among all centres.

    A tube has an area of 2π r for each length of its axis. So each centre counts with its point's area
    divided by r: what swells keeps the length of its axis.
    """
    share = np.full(len(points), area / len(points))
    closed = np.abs(radii) < _OPEN_RADIUS * math.sqrt(area)
    lengths = np.where(closed, share / np.maximum(np.abs(radii), _SMALLEST_RADIUS), 0)
    centers = points - radii[:, None] * normals
    normals = normals[:keypoints]
    surface = spin_images(points[:keypoints], normals, points, share, _SURFACE_RADIUS, _BINS)
    axis = spin_images(centers[:keypoints], normals, centers, lengths, _AXIS_RADIUS, _BINS)
    return np.concatenate([_SURFACE_WEIGHT * np.sqrt(surface), _AXIS_WEIGHT * np.sqrt(axis)], axis=1)


def _random_points(
    mesh: Mesh, count: int, random: np.random.Generator
) -> tuple[FloatArray, FloatArray, NDArray[np.int64], FloatArray]:
    """Random points, as dense everywhere: positions, normals, faces, barycentric coordinates."""
    a, b, c = (mesh.vertices[mesh.faces[:, corner]] for corner in range(3))
    normals = np.cross(b - a, c - a)
    doubled = np.linalg.norm(normals, axis=1)
    total = np.cumsum(doubled)
    # One in each of as many slices of equal area: no crowds and no gaps by chance.
    place = (np.arange(count) + random.random(count)) / count * total[-1]
    face = np.minimum(np.searchsorted(total, place, side="right"), len(doubled) - 1)
    root, other = np.sqrt(random.random(count)), random.random(count)
    corners = np.stack([1 - root, root * (1 - other), root * other], axis=1)
    points = (corners[:, :, None] * mesh.vertices[mesh.faces[face]]).sum(axis=1)
    flat = normals[face] / doubled[face, None]
    smooth = (corners[:, :, None] * _vertex_normals(mesh, normals)[mesh.faces[face]]).sum(axis=1)
    smooth /= np.maximum(np.linalg.norm(smooth, axis=1, keepdims=True), np.finfo(float).tiny)
    # At a crease, and where faces are turned against each other, the face's own normal is the better one.
    fits = (smooth * flat).sum(axis=1, keepdims=True) > _LEAST_COSINE
    return points, np.where(fits, smooth, flat), face, corners


def _vertex_normals(mesh: Mesh, face_normals: FloatArray) -> FloatArray:
    corners = mesh.faces.ravel()
    weighted = np.repeat(face_normals, 3, axis=0)
    summed = np.stack([np.bincount(corners, axis, len(mesh.vertices)) for axis in weighted.T], axis=1)
    normals: FloatArray = summed / np.maximum(
        np.linalg.norm(summed, axis=1, keepdims=True), np.finfo(float).tiny
    )
    return normals


def farthest_points(points: FloatArray, count: int) -> NDArray[np.int64]:
    """Pick points one after the other, each as far as possible from those picked before.

    Parameters
    ----------
    points : (n, 3) array
    count : int
        At most n.

    Returns
    -------
    chosen : (count,) array of int
        Indices of points; the first one is the farthest from the origin.
    """
    x, y, z = np.ascontiguousarray(points.T, np.float32)
    chosen = np.empty(count, np.int64)
    nearest = np.full(len(points), np.inf, np.float32)
    here = int((points**2).sum(axis=1).argmax())
    for index in range(count):
        chosen[index] = here
        np.minimum(nearest, (x - x[here]) ** 2 + (y - y[here]) ** 2 + (z - z[here]) ** 2, out=nearest)
        here = int(nearest.argmax())
    return chosen
