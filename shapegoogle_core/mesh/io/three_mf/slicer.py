# SPDX-License-Identifier: MIT
"""What slicers store beside the model: names of objects, and volumes that are no part of what is printed.

PrusaSlicer and its relatives join all volumes of an object into one mesh, and tell modifiers, support
blockers and the like from the model only by the numbers of their triangles; Bambu Studio and OrcaSlicer by
the components.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from shapegoogle_core.mesh.connectivity import used_vertices
from shapegoogle_core.mesh.io.three_mf.model import Model, ModelObject
from shapegoogle_core.mesh.io.three_mf.package import Package, parse_xml

__all__ = ["apply_slicer_settings"]

_SETTINGS = (
    "Metadata/Slic3r_PE_model.config",
    "Metadata/Slic3r_model.config",
    "Metadata/model_settings.config",
)
_PRINTED = ("ModelPart", "normal_part")
_SUBTRACTED = ("NegativeVolume", "negative_part")
_NOTE = "has volumes that its slicer subtracts from it, which is not done here"


@dataclass(eq=False)
class _Volume:
    """Triangles of an object, or one of its components."""

    kind: str = "ModelPart"
    first: int = 0
    last: int = -1
    component: str = ""


@dataclass(eq=False)
class _Settings:
    """What a slicer says of an object."""

    name: str = ""
    volumes: list[_Volume] = field(default_factory=list)


def apply_slicer_settings(package: Package, model: Model) -> Model:
    """Name the objects of a plate, and leave out the volumes that are not printed.

    Parameters
    ----------
    package : Package
    model : Model
        The part that the package begins with.

    Returns
    -------
    model : Model
        The same if no slicer has written the file.

    Raises
    ------
    FormatError
        If the settings are damaged.
    """
    settings: dict[str, _Settings] = {}
    for path in _SETTINGS:
        if package.has(path):
            _read(package, path, settings)
    objects = {
        identity: _applied(found, settings[identity]) if identity in settings else found
        for identity, found in model.objects.items()
    }
    return replace(model, objects=objects)


def _read(package: Package, path: str, settings: dict[str, _Settings]) -> None:
    """Read the settings of the objects in a part of the package."""
    current, volume = _Settings(), None

    def start(name: str, attributes: Mapping[str, str]) -> None:
        nonlocal current, volume
        if name == "object":
            current, volume = settings.setdefault(attributes["id"], _Settings()), None
        elif name == "volume":
            volume = _Volume(first=int(attributes["firstid"]), last=int(attributes["lastid"]))
            current.volumes.append(volume)
        elif name == "part":
            volume = _Volume(attributes.get("subtype", "normal_part"), component=attributes["id"])
            current.volumes.append(volume)
        elif name == "metadata":
            key, value = attributes.get("key"), attributes.get("value", "")
            if volume is None and key == "name":
                current.name = value.strip()
            elif volume is not None and key == "volume_type":
                volume.kind = value
            elif volume is not None and key == "modifier" and value == "1" and volume.kind in _PRINTED:
                volume.kind = "ParameterModifier"  # the older spelling

    def end(name: str) -> None:
        nonlocal current, volume
        if name in ("volume", "part"):
            volume = None
        elif name == "object":
            current = _Settings()  # what follows belongs to none

    parse_xml(package, path, start, end)


def _applied(found: ModelObject, settings: _Settings) -> ModelObject:
    printed = np.ones(len(found.faces), bool)
    left_out = set[str]()
    for volume in settings.volumes:
        if volume.kind not in _PRINTED:
            printed[max(volume.first, 0) : volume.last + 1] = False
            left_out.add(volume.component)
    used, faces = used_vertices(found.faces[printed], len(found.vertices))
    subtracted = any(volume.kind in _SUBTRACTED for volume in settings.volumes)
    return replace(
        found,
        name=settings.name or found.name,
        vertices=found.vertices[used],
        faces=faces.astype(np.int64),
        components=tuple(item for item in found.components if item.object_id not in left_out),
        notes=(*found.notes, _NOTE) if subtracted else found.notes,
    )
