# SPDX-License-Identifier: MIT
"""Figure of the keypoints that each detector finds, on creatures in two poses and with noise."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import trimesh
from numpy.typing import NDArray
from PIL import Image

from benchmarks.creatures import make_creature
from benchmarks.figures.contact_sheet import contact_sheet
from shapegoogle_core import Mesh
from shapegoogle_core.keypoints import DETECTORS, detect_keypoints
from shapegoogle_core.model import PRESETS
from shapegoogle_core.model.augmentation import transform
from shapegoogle_core.model.working_shape import working_shape
from shapegoogle_core.rendering import canonical_view, render

__all__ = ["draw"]

TILE = (190, 170)
INDIVIDUAL, VERTICES = 2011, 5000
# Radius of the balls as a share of √area, for the strongest response and for a response of 0.
LARGE, SMALL = 0.035, 0.018


def shapes() -> Iterator[tuple[str, Mesh]]:
    """Make creatures with their captions."""
    horse = make_creature("horse", INDIVIDUAL, VERTICES)
    yield "horse", horse.pose("rest")
    yield "another pose", horse.pose("gallop")
    yield "noise", transform(horse.pose("rest"), "noise", 4, 0)
    yield "human", make_creature("human", INDIVIDUAL, VERTICES).pose("rest")
    yield "octopus", make_creature("octopus", INDIVIDUAL, VERTICES).pose("rest")


def with_balls(mesh: Mesh, points: NDArray[np.int64], response: NDArray[np.float64]) -> Image.Image:
    """Render a mesh with a ball at each point, larger and redder for stronger responses."""
    ball = trimesh.creation.icosphere(2)
    vertices, faces = [mesh.vertices], [mesh.faces]
    colors = [np.tile([0.78, 0.81, 0.86], (len(mesh.vertices), 1))]
    share = np.sqrt(response / response.max()) if len(response) else response
    for point, strength in zip(points, share, strict=True):
        radius = (SMALL + (LARGE - SMALL) * strength) * np.sqrt(mesh.area)
        faces.append(ball.faces + sum(map(len, vertices)))
        vertices.append(mesh.vertices[point] + radius * ball.vertices)
        color = (1 - strength) * np.array([0.98, 0.75, 0.25]) + strength * np.array([0.85, 0.15, 0.15])
        colors.append(np.tile(color, (len(ball.vertices), 1)))
    picture = Mesh(np.concatenate(vertices), np.concatenate(faces))
    return render(picture, np.concatenate(colors), TILE, view=canonical_view(mesh, up_axis=2))


def draw(path: Path) -> None:
    """Draw the figure.

    Parameters
    ----------
    path : Path
        The .png file.
    """
    prepared = [(caption, working_shape(PRESETS["default"], mesh)) for caption, mesh in shapes()]
    images, captions = [], []
    for detector in DETECTORS:
        for caption, shape in prepared:
            found = detect_keypoints(shape.mesh, shape.spectrum, detector)
            images.append(with_balls(shape.mesh, found.indices, found.response))
            captions.append(f"{detector}: {caption}, {len(found)}")
    sheet = contact_sheet(images, captions, len(prepared))
    sheet.save(path, optimize=True)
