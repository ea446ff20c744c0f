# SPDX-License-Identifier: MIT
"""A depth-buffer rasteriser in numpy."""

from __future__ import annotations

import io

import numpy as np
from numpy.typing import ArrayLike, NDArray
from PIL import Image

from shapegoogle_core.errors import MeshError
from shapegoogle_core.mesh import Mesh, MeshLike, as_mesh
from shapegoogle_core.rendering.views import canonical_view

__all__ = ["render", "thumbnail"]

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

_NEUTRAL = np.array([0.74, 0.77, 0.82])
_SUPERSAMPLING = 2
_MARGIN = 0.04
# Directions towards the light and a weaker one on the other side, as (right, up, towards the viewer).
_KEY_LIGHT = np.array([-0.45, 0.65, 0.61])
_FILL_LIGHT = np.array([0.75, 0.1, 0.65])
# Corners between faces that meet at a larger angle are shaded sharp.
_SMOOTH_COSINE = np.cos(np.radians(50))
_MAX_SAMPLES = 2_000_000


def render(
    mesh: MeshLike,
    colors: ArrayLike | None = None,
    size: tuple[int, int] = (256, 256),
    background: tuple[int, int, int] | None = (255, 255, 255),
    view: ArrayLike | None = None,
) -> Image.Image:
    """Draw a mesh or a point cloud in orthographic projection so that it fills the picture.

    Parameters
    ----------
    mesh : MeshLike
    colors : (3,) or (n, 3) array_like, optional
        sRGB from 0 to 1, one for all vertices or one per vertex; a neutral grey by default.
    size : (int, int), optional
        Width and height in pixels.
    background : (int, int, int) or None, optional
        Red, green and blue from 0 to 255; None makes it transparent.
    view : (3, 3) array_like, optional
        Rotation whose rows point right, up and towards the viewer; `canonical_view` by default.

    Returns
    -------
    image : PIL.Image.Image
        "RGB", or "RGBA" when the background is transparent.

    Raises
    ------
    MeshError
        If the mesh has no vertices.
    ValueError
        If the size is not positive, or the colours do not fit the mesh.

    Examples
    --------
    >>> import trimesh
    >>> from shapegoogle_core.rendering import render
    >>> image = render(trimesh.creation.icosphere(), size=(64, 48))
    >>> image.size, image.mode
    ((64, 48), 'RGB')
    """
    mesh = as_mesh(mesh)
    if len(mesh.vertices) == 0:
        raise MeshError(f"{mesh.name!r} has no vertices, so there is nothing to draw")
    if min(size) < 1:
        raise ValueError(f"a picture needs a positive size, not {size}")
    vertex_colors = _vertex_colors(mesh, colors)
    rotation = canonical_view(mesh) if view is None else np.asarray(view, float)
    width, height = (extent * _SUPERSAMPLING for extent in size)
    points = _fit(mesh.vertices @ rotation.T, width, height)
    if mesh.is_point_cloud:
        shaded, covered = _draw_points(points, vertex_colors, width, height)
    else:
        shaded, covered = _draw_faces(points, mesh.faces, vertex_colors, width, height)
    return _compose(shaded, covered, background)


def thumbnail(
    mesh: MeshLike, size: int = 128, colors: ArrayLike | None = None, up_axis: int | None = None
) -> bytes:
    """Draw a small picture of a mesh as PNG, on a transparent background.

    Parameters
    ----------
    mesh : MeshLike
    size : int, optional
        Width and height in pixels.
    colors : (3,) or (n, 3) array_like, optional
        As for `render`.
    up_axis : {1, 2}, optional
        As for `canonical_view`.

    Returns
    -------
    png : bytes
        A few kilobytes, because it has only 64 colours.

    Raises
    ------
    MeshError
        If the mesh has no vertices.
    ValueError
        If the size is not positive, or the colours do not fit the mesh.

    Examples
    --------
    >>> import trimesh
    >>> from shapegoogle_core.rendering import thumbnail
    >>> thumbnail(trimesh.creation.icosphere())[1:4]
    b'PNG'
    """
    mesh = as_mesh(mesh)
    picture = render(mesh, colors, (size, size), None, canonical_view(mesh, up_axis))
    with io.BytesIO() as file:
        # The highest level takes several times as long to save few bytes: docs/measurements/libraries.md.
        picture.quantize(64, method=Image.Quantize.FASTOCTREE).save(file, "PNG", compress_level=7)
        return file.getvalue()


def _vertex_colors(mesh: Mesh, colors: ArrayLike | None) -> FloatArray:
    count = len(mesh.vertices)
    given = _NEUTRAL if colors is None else np.asarray(colors, float)
    if given.shape not in ((3,), (count, 3)):
        raise ValueError(
            f"{mesh.name!r}: colors must have shape (3,) or ({count}, 3), one per vertex, not {given.shape}"
        )
    if not ((given >= 0) & (given <= 1)).all():
        raise ValueError(f"{mesh.name!r}: colors must be between 0 and 1")
    return np.broadcast_to(given, (count, 3))


def _fit(points: FloatArray, width: int, height: int) -> FloatArray:
    """Transform points to pixels: x right, y down, z towards the viewer."""
    low, high = points.min(axis=0), points.max(axis=0)
    extent = (high - low)[:2]
    # A single point, or a line seen from its end, has no extent.
    wide = extent > 1e-9 * (high - low).max()
    scale = (1 - 2 * _MARGIN) * float(np.min(np.array([width, height])[wide] / extent[wide], initial=np.inf))
    scale = scale if wide.any() else 0.0
    return np.asarray((points - (low + high) / 2) * [scale, -scale, scale] + [width / 2, height / 2, 0])


def _spans(tips: FloatArray, height: int, width: int) -> tuple[IntArray, IntArray, IntArray, IntArray]:
    """Return the spans of pixels that triangles cover: triangle, row, first column and number of columns."""
    by_height = tips[:, :, 1].argsort(axis=1)
    xs, ys = (np.take_along_axis(tips[:, :, axis], by_height, axis=1).T.copy() for axis in range(2))
    first = np.clip(np.ceil(ys[0] - 0.5), 0, height).astype(np.int64)
    last = np.clip(np.ceil(ys[2] - 0.5), 0, height).astype(np.int64)
    rows_per_face = np.maximum(last - first, 0)
    face = np.repeat(np.arange(len(tips)), rows_per_face)
    row = first[face] + _counting(rows_per_face)
    y = row + 0.5
    corners = [(x.take(face), y.take(face)) for x, y in zip(xs, ys, strict=True)]

    def crossing(a: int, b: int) -> FloatArray:
        (start, above), (end, below) = corners[a], corners[b]
        rise = np.where(below > above, below - above, 1)
        share = np.clip((y - above) / rise, 0, 1)
        return np.asarray(start + share * (end - start))

    one = crossing(0, 2)
    other = np.where(y < corners[1][1], crossing(0, 1), crossing(1, 2))
    left = np.clip(np.ceil(np.minimum(one, other) - 0.5), 0, width).astype(np.int64)
    right = np.clip(np.ceil(np.maximum(one, other) - 0.5), 0, width).astype(np.int64)
    return face, row, left, np.maximum(right - left, 0)


def _counting(lengths: IntArray) -> IntArray:
    """Return 0 … length − 1 for each length, concatenated."""
    ends = np.cumsum(lengths)
    return np.arange(int(lengths.sum())) - np.repeat(ends - lengths, lengths)


def _barycentric(tips: FloatArray, face: IntArray, column: IntArray, row: IntArray) -> FloatArray:
    """Return barycentric coordinates (3, s) of pixel centres in their triangles, of m given as (m, 3, 3)."""
    ax, ay, bx, by, cx, cy = tips[:, :, :2].reshape(-1, 6).T
    bx, by, cx, cy = bx - ax, by - ay, cx - ax, cy - ay
    area = bx * cy - cx * by
    area = np.where(area == 0, 1, area)
    x, y = column + 0.5 - ax.take(face), row + 0.5 - ay.take(face)
    second = x * (cy / area).take(face) - y * (cx / area).take(face)
    third = y * (bx / area).take(face) - x * (by / area).take(face)
    weights: FloatArray = np.clip(np.stack([1 - second - third, second, third]), 0, 1)
    weights /= weights.sum(axis=0)
    return weights


def _interpolated(weights: FloatArray, values: FloatArray, face: IntArray) -> FloatArray:
    """Interpolate values (m, 3, 3) at the corners of m triangles: (s, 3)."""
    at_corners = np.ascontiguousarray(values.transpose(1, 2, 0))
    found = np.zeros((3, len(face)))
    for weight, corner in zip(weights, at_corners, strict=True):
        for axis in range(3):
            found[axis] += weight * corner[axis].take(face)
    return found.T


def _nearest_faces(tips: FloatArray, width: int, height: int) -> IntArray:
    """Return the index of the nearest triangle at every pixel, −1 where there is none."""
    depth = tips[:, :, 2]
    low = float(depth.min())
    scale = 2**30 / float(np.ptp(depth)) if np.ptp(depth) > 0 else 0.0
    buffer = np.full(width * height, -1, np.int64)
    # z = z0 + slope · (x − x0, y − y0), the triangle's plane.
    u, v = tips[:, 1] - tips[:, 0], tips[:, 2] - tips[:, 0]
    normal = np.cross(u, v)
    upright = np.where(normal[:, 2] == 0, 1, normal[:, 2])
    slope_x, slope_y = np.where(normal[:, 2] == 0, 0, -normal[:, :2].T / upright)
    first_x, first_y, first_z = tips[:, 0].T.copy()
    least, most = depth.min(axis=1), depth.max(axis=1)

    face, row, left, columns = _spans(tips, height, width)
    ends = np.cumsum(columns)
    start = 0
    while start < len(face):
        stop = max(int(np.searchsorted(ends, (ends[start - 1] if start else 0) + _MAX_SAMPLES)), start + 1)
        part = slice(start, stop)
        of_face = np.repeat(face[part], columns[part])
        x = np.repeat(left[part], columns[part]) + _counting(columns[part])
        y = np.repeat(row[part], columns[part])
        z = (
            first_z.take(of_face)
            + slope_x.take(of_face) * (x + 0.5 - first_x.take(of_face))
            + slope_y.take(of_face) * (y + 0.5 - first_y.take(of_face))
        )
        # The slope of a triangle seen edge-on is unbounded; its corners bound the depth.
        z = np.clip(z, least.take(of_face), most.take(of_face))
        keys = (((z - low) * scale).astype(np.int64) << 32) | of_face
        np.maximum.at(buffer, y * width + x, keys)
        start = stop
    return np.where(buffer < 0, -1, buffer & 0xFFFFFFFF)


def _corner_normals(
    tips: FloatArray, faces: NDArray[np.int32], count: int, seen: NDArray[np.intp]
) -> FloatArray:
    """Return unit normals at the corners of s faces, (s, 3, 3): smooth where neighbours bend little."""
    normals = np.cross(tips[:, 1] - tips[:, 0], tips[:, 2] - tips[:, 0])
    summed = np.stack(
        [np.bincount(faces.ravel(), np.repeat(normals[:, axis], 3), minlength=count) for axis in range(3)],
        axis=1,
    )
    tiny = np.finfo(float).tiny
    normals = normals[seen]
    unit = normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), tiny)
    smooth = summed / np.maximum(np.linalg.norm(summed, axis=1, keepdims=True), tiny)
    corners: FloatArray = smooth[faces[seen]]
    sharp = np.einsum("mcd,md->mc", corners, unit) < _SMOOTH_COSINE
    corners[sharp] = np.broadcast_to(unit[:, None], corners.shape)[sharp]
    return corners


def _draw_faces(
    points: FloatArray, faces: NDArray[np.int32], colors: FloatArray, width: int, height: int
) -> tuple[FloatArray, NDArray[np.bool_]]:
    tips = points[faces]
    nearest = _nearest_faces(tips, width, height)
    pixels = np.flatnonzero(nearest >= 0)
    # Only the faces that are seen, numbered anew.
    is_seen = np.zeros(len(faces), bool)
    is_seen[nearest[pixels]] = True
    seen = np.flatnonzero(is_seen)
    face = (np.cumsum(is_seen) - 1)[nearest[pixels]]
    row, column = np.divmod(pixels, width)
    weights = _barycentric(tips[seen], face, column, row)
    normals = _interpolated(weights, _corner_normals(tips, faces, len(points), seen), face)
    # One colour for all vertices is repeated in place, without memory of its own.
    plain = colors.strides[0] == 0
    drawn = colors[:1] if plain else _interpolated(weights, colors[faces[seen]], face)
    picture = np.zeros((height * width, 3))
    picture[pixels] = _shade(drawn, normals * [1, -1, 1])
    covered = nearest >= 0
    return picture.reshape(height, width, 3), covered.reshape(height, width)


def _shade(colors: FloatArray, normals: FloatArray) -> FloatArray:
    """Shade with two lights and a soft rim; both sides of a face are lit: polygon soup has no inside."""
    normals = normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), np.finfo(float).tiny)
    normals = np.where(normals[:, 2:] < 0, -normals, normals)
    key = np.maximum(normals @ (_KEY_LIGHT / np.linalg.norm(_KEY_LIGHT)), 0)
    fill = np.maximum(normals @ (_FILL_LIGHT / np.linalg.norm(_FILL_LIGHT)), 0)
    light = 0.34 + 0.58 * key + 0.2 * fill
    rim = 0.75 + 0.25 * np.clip(normals[:, 2] / 0.35, 0, 1)
    return np.asarray(np.clip(colors * (light * rim)[:, None], 0, 1))


def _draw_points(
    points: FloatArray, colors: FloatArray, width: int, height: int
) -> tuple[FloatArray, NDArray[np.bool_]]:
    """Draw square splats, nearer ones lighter and in front."""
    # About as large as the gaps between points, if these cover the picture evenly.
    reach = int(np.clip(0.45 * np.sqrt(width * height / len(points)), 1, 8))
    steps = np.arange(-reach, reach + 1)
    depth = points[:, 2]
    order = depth.argsort(kind="stable")
    span = max(float(np.ptp(depth)), np.finfo(float).tiny)
    shaded = colors * (0.55 + 0.45 * (depth - depth.min()) / span)[:, None]
    picture = np.zeros((height, width, 3))
    covered = np.zeros((height, width), bool)
    column = np.floor(points[order, 0]).astype(np.int64)[:, None, None] + steps[None, :, None]
    row = np.floor(points[order, 1]).astype(np.int64)[:, None, None] + steps[None, None, :]
    column, row = np.broadcast_arrays(column, row)
    inside = (column >= 0) & (column < width) & (row >= 0) & (row < height)
    # Assigned in order of depth, so that the last and nearest one remains.
    owner = np.broadcast_to(order[:, None, None], inside.shape)[inside]
    picture[row[inside], column[inside]] = shaded[owner]
    covered[row[inside], column[inside]] = True
    return picture, covered


def _compose(
    shaded: FloatArray, covered: NDArray[np.bool_], background: tuple[int, int, int] | None
) -> Image.Image:
    """Average the samples of each pixel; where nothing is covered, `shaded` is 0."""
    share, total = _reduced(covered.astype(np.float64)), _reduced(shaded)
    if background is not None:
        mixed = total + (1 - share)[:, :, None] * np.asarray(background, float) / 255
        return Image.fromarray(np.round(255 * mixed).astype(np.uint8))
    color = total / np.maximum(share, 1 / _SUPERSAMPLING**2)[:, :, None]
    return Image.fromarray(np.round(255 * np.dstack([color, share])).astype(np.uint8))


def _reduced(picture: FloatArray) -> FloatArray:
    """Average blocks of pixels."""
    step = _SUPERSAMPLING
    parts = [picture[row::step, column::step] for row in range(step) for column in range(step)]
    return np.asarray(sum(parts[1:], parts[0]) / len(parts))
