# SPDX-License-Identifier: MIT
"""Small 3MF files, put together piece by piece."""

from __future__ import annotations

import io
import zipfile
from collections.abc import Mapping, Sequence

from tests.core.mesh.io.mesh_files import POINTS, TRIANGLES, Faces, Points

CORE = "http://schemas.microsoft.com/3dmanufacturing/core/2015/02"
PRODUCTION = "http://schemas.microsoft.com/3dmanufacturing/production/2015/06"
LATTICE = "http://schemas.microsoft.com/3dmanufacturing/beamlattice/2017/02"
SLICE = "http://schemas.microsoft.com/3dmanufacturing/slice/2015/07"
MATERIAL = "http://schemas.microsoft.com/3dmanufacturing/material/2015/02"
RELATIONSHIPS = (
    '<Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships">'
    '<Relationship Id="r" Target="{}" Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/>'
    "</Relationships>"
)


def package(
    model: str,
    target: str = "/3D/3dmodel.model",
    compression: int = zipfile.ZIP_DEFLATED,
    parts: Mapping[str, str] | None = None,
) -> bytes:
    """A 3MF file; `target` is the part that it says it begins with."""
    data = io.BytesIO()
    with zipfile.ZipFile(data, "w", compression) as archive:
        archive.writestr("[Content_Types].xml", "<Types/>")
        if target:
            archive.writestr("_rels/.rels", RELATIONSHIPS.format(target))
        archive.writestr("3D/3dmodel.model", model)
        for name, content in (parts or {}).items():
            archive.writestr(name, content)
    return data.getvalue()


def model(resources: str, build: str | None = None, more: str = "", unit: str | None = "millimeter") -> str:
    """The XML of a model; attributes may be added."""
    units = "" if unit is None else f' unit="{unit}"'
    built = "" if build is None else f"<build>{build}</build>"
    return (
        f'<?xml version="1.0" encoding="UTF-8"?><model{units} xml:lang="en-US" xmlns="{CORE}" '
        f'xmlns:p="{PRODUCTION}" xmlns:b="{LATTICE}" xmlns:s="{SLICE}" xmlns:m="{MATERIAL}" '
        f'xmlns:x="urn:x" {more}>'
        f"<resources>{resources}</resources>{built}</model>"
    )


def mesh_object(
    identity: int, points: Points = POINTS, more: str = "", inside: str = "", faces: Faces = TRIANGLES
) -> str:
    vertices = "".join(f'<vertex x="{x}" y="{y}" z="{z}"/>' for x, y, z in points)
    triangles = "".join(f'<triangle v1="{a}" v2="{b}" v3="{c}" pid="9"/>' for a, b, c in faces)
    return (
        f'<object id="{identity}" {more}><mesh><vertices>{vertices}</vertices>'
        f"<triangles>{triangles}</triangles>{inside}</mesh></object>"
    )


def components(identity: int, *children: str, more: str = "") -> str:
    return f'<object id="{identity}" {more}><components>{"".join(children)}</components></object>'


def component(identity: int, matrix: Sequence[float] | None = None, more: str = "") -> str:
    return f'<component objectid="{identity}"{transform(matrix)} {more}/>'


def item(identity: int, matrix: Sequence[float] | None = None, more: str = "") -> str:
    return f'<item objectid="{identity}"{transform(matrix)} {more}/>'


def transform(matrix: Sequence[float] | None) -> str:
    return "" if matrix is None else f' transform="{" ".join(map(str, matrix))}"'


def moved(x: float, y: float, z: float, scale: Sequence[float] = (1, 1, 1)) -> list[float]:
    """Three rows of a matrix, and the translation as the fourth."""
    return [scale[0], 0, 0, 0, scale[1], 0, 0, 0, scale[2], x, y, z]
