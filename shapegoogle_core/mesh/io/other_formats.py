# SPDX-License-Identifier: MIT
"""Formats of shapes that are not read, and what to do with such files."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from shapegoogle_core.api.text import counted

__all__ = ["OTHER_SUFFIXES", "SkippedFormat", "advice", "skipped_formats"]

_CAD = "export from the CAD program as STL or 3MF, with a fine tolerance"
_SCENE = "import into Blender and save as .blend, or export as glTF"
_IMPORTED = "index with Blender and scripts/index_library.py, or export as glTF"


@dataclass(frozen=True)
class _Format:
    name: str
    suffixes: tuple[str, ...]
    advice: str


_FORMATS = (
    _Format("Blender", (".blend",), "index with Blender and scripts/index_library.py"),
    _Format("STEP", (".step", ".stp", ".stpz"), _CAD),
    _Format("IGES", (".iges", ".igs"), _CAD),
    _Format("Parasolid", (".x_t", ".x_b", ".xmt_txt", ".xmt_bin"), _CAD),
    _Format("ACIS", (".sat", ".sab"), _CAD),
    _Format("BREP", (".brep", ".brp"), _CAD),
    _Format("JT", (".jt",), _CAD),
    _Format("SolidWorks", (".sldprt", ".sldasm"), _CAD),
    _Format("Inventor", (".ipt", ".iam"), _CAD),
    _Format("CATIA", (".catpart", ".catproduct", ".cgr"), _CAD),
    _Format("Creo or NX", (".prt",), _CAD),
    _Format("Solid Edge", (".psm",), _CAD),
    _Format("Fusion", (".f3d", ".f3z"), _CAD),
    _Format("FreeCAD", (".fcstd",), _CAD),
    _Format("OpenSCAD", (".scad",), "render in OpenSCAD and export as 3MF or STL"),
    _Format("AutoCAD", (".dwg", ".dxf"), _CAD),
    _Format("IFC", (".ifc", ".ifczip"), "export as glTF or OBJ"),
    _Format("Rhino", (".3dm",), "export from Rhino as OBJ or STL"),
    _Format("SketchUp", (".skp",), "export from SketchUp as glTF or OBJ"),
    _Format("FBX", (".fbx",), _IMPORTED),
    _Format(
        "COLLADA",
        (".dae",),
        "index with Blender 4.5 or earlier and scripts/index_library.py, or export as glTF",
    ),
    _Format("USD", (".usd", ".usda", ".usdc", ".usdz"), _IMPORTED),
    _Format("Alembic", (".abc",), _IMPORTED),
    _Format("3D Studio", (".3ds", ".max"), "export from 3ds Max as glTF or OBJ"),
    _Format("Maya", (".ma", ".mb"), "export from Maya as glTF or OBJ"),
    _Format("Cinema 4D", (".c4d",), "export from Cinema 4D as glTF or OBJ"),
    _Format("LightWave", (".lwo",), "export from LightWave as glTF or OBJ"),
    _Format("VRML or X3D", (".wrl", ".vrml", ".x3d"), _SCENE),
    _Format("AMF", (".amf",), "export as 3MF or STL"),
    _Format("VTK", (".vtk", ".vtp", ".vtu"), "export the surface as PLY or STL"),
    _Format("LAS or E57", (".las", ".laz", ".e57"), "export the scan as PLY or PCD"),
)

_BY_SUFFIX = {suffix: form for form in _FORMATS for suffix in form.suffixes}

OTHER_SUFFIXES = frozenset(_BY_SUFFIX)
"""Suffixes of files that hold shapes and are not read, in lower case with the dot."""


def advice(suffix: str) -> str:
    """Say what to do with a file of a format that is not read.

    Parameters
    ----------
    suffix : str
        In lower case with the dot.

    Returns
    -------
    text : str
        Completes the sentence "<file> …"; empty for a suffix that is unknown too.

    Examples
    --------
    >>> from shapegoogle_core.mesh.io.other_formats import advice
    >>> advice(".vtk")
    'is of the format VTK, which is not read here; export the surface as PLY or STL'
    >>> advice(".txt")
    ''
    """
    form = _BY_SUFFIX.get(suffix)
    if form is None:
        return ""
    return f"is of the format {form.name}, which is not read here; {form.advice}"


@dataclass(frozen=True)
class SkippedFormat:
    """Files of one format that were found and not read.

    Attributes
    ----------
    format : str
        Its name.
    files : int
        Number of files.
    advice : str
        What to do with them.
    """

    format: str
    files: int
    advice: str

    def sentence(self) -> str:
        """Describe it for people.

        Returns
        -------
        text : str
            Such as "2 LightWave files skipped: export from LightWave as glTF or OBJ".
        """
        return f"{counted(self.files, f'{self.format} file')} skipped: {self.advice}"


def skipped_formats(paths: Iterable[Path]) -> list[SkippedFormat]:
    """Count files of formats that are not read.

    Parameters
    ----------
    paths : iterable of Path
        Those with other suffixes are left out.

    Returns
    -------
    formats : list of SkippedFormat
        In alphabetical order.

    Examples
    --------
    >>> from pathlib import Path
    >>> from shapegoogle_core.mesh.io.other_formats import skipped_formats
    >>> [skipped.sentence() for skipped in skipped_formats([Path("a.lwo"), Path("b.LWO"), Path("c.txt")])]
    ['2 LightWave files skipped: export from LightWave as glTF or OBJ']
    """
    counts = Counter(_BY_SUFFIX.get(path.suffix.lower()) for path in paths)
    found = [SkippedFormat(form.name, count, form.advice) for form, count in counts.items() if form]
    return sorted(found, key=lambda skipped: skipped.format)
