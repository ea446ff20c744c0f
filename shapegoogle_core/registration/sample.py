# SPDX-License-Identifier: MIT
"""A few hundred oriented points that represent a surface, with descriptors of some of them."""

from __future__ import annotations

import math
import struct
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import accumulate
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from shapegoogle_core.descriptors import log_heat_kernel_signature, spin_images
from shapegoogle_core.mesh.drawing import draw_points
from shapegoogle_core.mesh.measures import cross_products, lengths, point_normals, vertex_normals
from shapegoogle_core.mesh.mesh import FloatArray, Mesh
from shapegoogle_core.preprocessing import Unsmoothed
from shapegoogle_core.registration.heat.local_heat import LocalHeat, measure_local_heat
from shapegoogle_core.registration.medial import ball_centers, medial_radii
from shapegoogle_core.spectral import Spectrum

__all__ = ["SampleSettings", "SurfaceSample", "farthest_points", "sample_surface"]

# Number of random points that the sample is chosen from.
_CLOUD = 4000
# Heat kernel signatures: times as a share of the area, two octaves apart. They are short, because at short
# times a descriptor sees little of a cut.
_TIMES = 4.0 ** np.arange(1, 6) / 40_000
_OCTAVES_APART = 2
# Spin images of the surface and of the medial axis: radius as a share of √area, and bins.
_SURFACE_RADIUS, _AXIS_RADIUS, _BINS = 0.3, 0.35, (4, 3)
# Weights of the three kinds of descriptors, so that each contributes equally to distances.
_HEAT_WEIGHT, _SURFACE_WEIGHT, _AXIS_WEIGHT = 0.9, 5.0, 3.5
# Smaller balls are noise; a ball of almost the largest radius touches nothing on the other side.
_SMALLEST_RADIUS, _OPEN_RADIUS = 0.02, 0.45
_SMALLEST_COSINE = np.cos(np.radians(45))
# Largest radius of a medial ball, as a share of √area.
_LARGEST_RADIUS = 0.5
# Units of stored numbers; descriptors are within ±12.
_NORMAL_UNIT, _RADIUS_UNIT, _DESCRIPTOR_UNIT = 1 / 127, _LARGEST_RADIUS / 127, 12 / 127
# Number of eigenfunctions; their values at the keypoints, times √area, reach ±8 at the tips of thin limbs.
_MODES, _MODE_UNIT = 24, 8 / 127
# Number of points with local heat.
_HEAT_POINTS = 1200
_DESCRIPTOR_SIZE = len(_TIMES) + 2 * _BINS[0] * _BINS[1]
_MOST_POINTS = 65_535
# Numbers of points, keypoints, values of a descriptor, modes; unit of the coordinates; centre and unit.
_HEADER = struct.Struct("<4Hf4d")


@dataclass(frozen=True)
class SampleSettings:
    """Size of the samples.

    Attributes
    ----------
    points : int
        Number m of points, evenly spread.
    keypoints : int
        Number k ≤ m of the points that have a descriptor, evenly spread too.

    Raises
    ------
    ValueError
        If these are not 8 ≤ keypoints ≤ points ≤ 65,535.
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
        In units of √area. The first n of them are evenly spread too, for every n.
    normals : (m, 3) array
        Of unit length and arbitrary orientation.
    radii : (m,) array
        Radius of the ball that touches the surface there and holds no other point, see `medial_radii`.
    descriptors : (k, d) array of float32
        Descriptors of the first k points: logarithms of the heat kernel signature, and square roots of the
        spin images of the surface and of the medial axis.
    eigenvalues : (e,) array
        Lowest eigenvalues of the Laplacian without the first one, times the area, so dimensionless.
    modes : (k, e) array of float32
        Their eigenfunctions at the first k points, times √area.
    center : (3,) array
    unit : float
        The points lie at center + unit · points in the coordinates of the mesh.
    packed_heat : bytes
        `local_heat` as it is stored; empty if there is none.
    """

    points: FloatArray
    normals: FloatArray
    radii: FloatArray
    descriptors: NDArray[np.float32]
    eigenvalues: FloatArray
    modes: NDArray[np.float32]
    center: FloatArray
    unit: float
    packed_heat: bytes = b""

    @cached_property
    def local_heat(self) -> LocalHeat | None:
        """Local heat of points that begin with these; None for point clouds, and in libraries from before."""
        return LocalHeat.from_bytes(self.packed_heat) if self.packed_heat else None

    @property
    def is_cut(self) -> bool:
        """Whether something is cut off, see `LocalHeat.is_cut`."""
        return self.local_heat is not None and self.local_heat.is_cut

    @cached_property
    def centers(self) -> FloatArray:
        """(m, 3) points of the medial axis: the centres of the medial balls."""
        return ball_centers(self.points, self.normals, self.radii)

    def descriptors_at(self, scale: float, keypoints: int | None = None) -> NDArray[np.float32]:
        """Compute the descriptors that the surface would have at another size.

        When a part and its whole are both scaled to unit area, the part is too large, and whatever is not
        swollen of a swollen surface is too small. Descriptors depend on the size.

        Parameters
        ----------
        scale : float
            Factor of all lengths, from 0.5 to 2.
        keypoints : int, optional
            Number of the first keypoints to describe; all by default.

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

    def placed(self, matrix: FloatArray) -> Self:
        """Return the sample of the surface after a similarity transformation.

        Parameters
        ----------
        matrix : (4, 4) array
            Rotation or reflection, times a scale, and a translation.

        Returns
        -------
        sample : SurfaceSample
        """
        linear = np.asarray(matrix, np.float64)[:3, :3]
        scale = float(np.sqrt((linear**2).sum() / 3))
        turn = linear / scale
        return replace(
            self,
            points=self.points @ turn.T,
            normals=self.normals @ turn.T,
            center=linear @ self.center + matrix[:3, 3],
            unit=scale * self.unit,
        )

    def moved_back(self, origin: FloatArray, scale: float) -> Self:
        """Return the sample in the coordinates that its mesh had before x ↦ scale · (x - origin).

        Parameters
        ----------
        origin : (3,) array
        scale : float

        Returns
        -------
        sample : SurfaceSample
        """
        return replace(self, center=origin + self.center / scale, unit=self.unit / scale)

    def to_bytes(self) -> bytes:
        """Serialise with 10 bytes for each point, and one for each value of a descriptor, a mode and heat.

        Returns
        -------
        data : bytes
        """
        unit = np.float32(max(np.abs(self.points).max(), 1e-6) / 32767)
        counts = (len(self.points), *self.descriptors.shape, len(self.eigenvalues))
        header = _HEADER.pack(*counts, unit, *self.center, self.unit)
        points = np.rint(self.points / float(unit)).clip(-32767, 32767).astype("<i2")
        normals = np.rint(self.normals / _NORMAL_UNIT).astype(np.int8)
        arrays = [points, normals, self.eigenvalues.astype("<f4")]
        arrays += [
            np.rint(array / size).clip(-127, 127).astype(np.int8)
            for array, size in (
                (self.radii, _RADIUS_UNIT),
                (self.descriptors, _DESCRIPTOR_UNIT),
                (self.modes, _MODE_UNIT),
            )
        ]
        return header + b"".join(array.tobytes() for array in arrays) + self.packed_heat

    @classmethod
    def from_bytes(cls, data: bytes) -> Self:
        """Rebuild a sample from `to_bytes`.

        Parameters
        ----------
        data : bytes

        Returns
        -------
        sample : SurfaceSample
            Its coordinates are exact to 1/65,000 of the extent.

        Raises
        ------
        ValueError
            If the data is not a sample.
        """
        if len(data) < _HEADER.size:
            raise ValueError(f"a surface sample has at least {_HEADER.size} bytes")
        points, keypoints, size, modes, step, *frame = _HEADER.unpack_from(data)
        center, unit = np.array(frame[:3]), float(frame[3])
        usable = 0 < step < np.inf and 0 < unit < np.inf and np.isfinite(center).all()
        if not (8 <= keypoints <= points and size == _DESCRIPTOR_SIZE and usable):
            raise ValueError(
                f"a surface sample cannot have {points} points and {keypoints} keypoints with {size} numbers"
            )
        lengths = (6 * points, 3 * points, 4 * modes, points, keypoints * size, keypoints * modes)
        ends = list(accumulate(lengths, initial=_HEADER.size))
        if len(data) < ends[-1]:
            raise ValueError(f"a surface sample of {points} points has {ends[-1]} bytes, not {len(data)}")
        packed_heat = data[ends[-1] :]
        if packed_heat:
            LocalHeat.check(packed_heat)

        def numbers(part: int, kind: str, unit: float, exact: type[np.floating[Any]]) -> NDArray[Any]:
            stored = np.frombuffer(data, kind, lengths[part] // np.dtype(kind).itemsize, ends[part])
            return np.asarray(np.multiply(stored, exact(unit), dtype=exact))

        return cls(
            points=numbers(0, "<i2", step, np.float64).reshape(points, 3),
            normals=numbers(1, "i1", _NORMAL_UNIT, np.float64).reshape(points, 3),
            radii=numbers(3, "i1", _RADIUS_UNIT, np.float64),
            descriptors=numbers(4, "i1", _DESCRIPTOR_UNIT, np.float32).reshape(keypoints, size),
            eigenvalues=numbers(2, "<f4", 1.0, np.float64),
            modes=numbers(5, "i1", _MODE_UNIT, np.float32).reshape(keypoints, modes),
            center=center,
            unit=unit,
            packed_heat=packed_heat,
        )


def sample_surface(
    mesh: Mesh,
    spectrum: Spectrum,
    settings: SampleSettings,
    unsmoothed: Unsmoothed | None = None,
) -> SurfaceSample:
    """Spread points evenly over a surface and describe the neighbourhood of some of them.

    Parameters
    ----------
    mesh : Mesh
        Of positive area; or points without faces, of similar density everywhere.
    spectrum : Spectrum
        Spectrum of that mesh.
    settings : SampleSettings
    unsmoothed : Unsmoothed, optional
        The same vertices and faces before smoothing. Without it there is no local heat.

    Returns
    -------
    sample : SurfaceSample
        Deterministic. It has fewer points than `settings` asks for if a point cloud has fewer.
    """
    random = np.random.default_rng(0)
    unit = math.sqrt(spectrum.area if mesh.is_point_cloud else mesh.area)
    if mesh.is_point_cloud:
        points, normals = mesh.vertices, point_normals(mesh.vertices)
        vertices, corners = np.arange(len(points))[:, None], np.ones((len(points), 1))
    else:
        points, normals, face, corners = _random_points(mesh, max(settings.points, _CLOUD), random)
        vertices = mesh.faces[face].astype(np.int64)
    center = points.mean(axis=0)
    points = (points - center) / unit
    more = farthest_points(points, min(max(settings.points, _HEAT_POINTS), len(points)))
    chosen = more[: settings.points]
    radii = medial_radii(points[chosen], normals[chosen], points, _LARGEST_RADIUS)
    keys = chosen[: settings.keypoints]
    at_keys = vertices[keys], corners[keys, :, None]
    heat = _HEAT_WEIGHT * _interpolated(log_heat_kernel_signature(spectrum, _TIMES * unit**2), *at_keys)
    spin = _spin_images(points[chosen], normals[chosen], radii, len(keys), 1.0)
    modes = slice(1, 1 + _MODES)
    packed_heat = b""
    if unsmoothed is not None and not mesh.is_point_cloud:
        # The points of the sample first, then all others.
        ordered = np.concatenate([more, np.delete(np.arange(len(points)), more)])
        packed_heat = measure_local_heat(
            unsmoothed, spectrum, vertices[ordered], corners[ordered], min(_HEAT_POINTS, len(more))
        ).to_bytes()
    return SurfaceSample(
        points=points[chosen],
        normals=normals[chosen],
        radii=radii,
        descriptors=np.concatenate([heat, spin], axis=1).astype(np.float32),
        eigenvalues=spectrum.eigenvalues[modes] * unit**2,
        modes=_interpolated(unit * spectrum.eigenvectors[:, modes], *at_keys).astype(np.float32),
        center=center,
        unit=unit,
        packed_heat=packed_heat,
    )


def _interpolated(values: FloatArray, vertices: NDArray[np.int64], weights: FloatArray) -> FloatArray:
    """Return the weighted sum of the values at a few vertices for each point."""
    return np.asarray((values[vertices] * weights).sum(axis=1))


def _spin_images(
    points: FloatArray, normals: FloatArray, radii: FloatArray, keypoints: int, area: float
) -> FloatArray:
    """Return square roots of spin images of the first points, and of their ball centres among all centres.

    A tube has an area of 2π r for each unit of length of its axis. So each centre counts with the area of its
    point divided by r: a limb that swells keeps the length of its axis.
    """
    share = np.full(len(points), area / len(points))
    closed = np.abs(radii) < _OPEN_RADIUS * math.sqrt(area)
    lengths = np.where(closed, share / np.maximum(np.abs(radii), _SMALLEST_RADIUS), 0)
    centers = ball_centers(points, normals, radii)
    normals = normals[:keypoints]
    surface = spin_images(points[:keypoints], normals, points, share, _SURFACE_RADIUS, _BINS)
    axis = spin_images(centers[:keypoints], normals, centers, lengths, _AXIS_RADIUS, _BINS)
    return np.concatenate([_SURFACE_WEIGHT * np.sqrt(surface), _AXIS_WEIGHT * np.sqrt(axis)], axis=1)


def _random_points(
    mesh: Mesh, count: int, random: np.random.Generator
) -> tuple[FloatArray, FloatArray, NDArray[np.int64], FloatArray]:
    """Draw uniformly distributed points: positions, normals, faces, barycentric coordinates."""
    a, b, c = mesh.vertices[mesh.faces.T]
    normals = cross_products(b - a, c - a).T
    doubled = lengths(normals)
    face, corners = draw_points(doubled, count, random)
    points = (corners[:, :, None] * mesh.vertices[mesh.faces[face]]).sum(axis=1)
    flat = normals[face] / doubled[face, None]
    smooth = (corners[:, :, None] * vertex_normals(mesh)[mesh.faces[face]]).sum(axis=1)
    smooth /= np.maximum(np.linalg.norm(smooth, axis=1, keepdims=True), np.finfo(float).tiny)
    # At a crease, and where neighbouring faces have opposite orientation, the face's own normal is better.
    fits = (smooth * flat).sum(axis=1, keepdims=True) > _SMALLEST_COSINE
    return points, np.where(fits, smooth, flat), face, corners


def farthest_points(points: FloatArray, count: int) -> NDArray[np.int64]:
    """Choose points one by one, each the farthest from all chosen before (Gonzalez 1985).

    Parameters
    ----------
    points : (n, 3) array
    count : int
        At most n.

    Returns
    -------
    chosen : (count,) array of int
        Indices of points. The first one is the farthest from the origin.
    """
    columns = np.ascontiguousarray(points.T, np.float32)
    chosen = np.empty(count, np.int64)
    nearest = np.full(len(points), np.inf, np.float32)
    squares = np.empty_like(columns)
    here = int((points**2).sum(axis=1).argmax())
    for index in range(count):
        chosen[index] = here
        np.subtract(columns, columns[:, here, None], out=squares)
        np.multiply(squares, squares, out=squares)
        distance = squares[0]
        distance += squares[1]
        distance += squares[2]
        np.minimum(nearest, distance, out=nearest)
        here = int(nearest.argmax())
    return chosen
