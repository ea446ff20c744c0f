# SPDX-License-Identifier: MIT
"""What a benchmark has computed, kept on disk: a run that was ended goes on, a second one takes seconds.

Entries are `.npz` archives of arrays, never pickled. A key is a hash of all that an entry depends on: the
content of the mesh file, what is done to the shape, settings, and the source code that does it. So nothing
has to be thrown away by hand, and nothing stale is ever used.
"""

from __future__ import annotations

import hashlib
import json
import os
import re
import zipfile
import zlib
from collections.abc import Callable, Mapping
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.errors import BenchmarkError
from shapegoogle_core.mesh import Mesh
from shapegoogle_core.model import ModelSettings
from shapegoogle_core.model.working_shape import Placement, WorkingShape, working_shape
from shapegoogle_core.spectral import Spectrum

__all__ = [
    "PREPARATION_CODE",
    "SEARCH_CODE",
    "SIGNATURE_CODE",
    "Arrays",
    "BenchmarkCache",
    "cached_shape",
    "code_digest",
    "content_digest",
    "digest",
    "preparation_of",
]

Arrays = dict[str, NDArray[Any]]

CACHE_VERSION = 1
"""Of the entries; raise it when their arrays change their meaning."""

PREPARATION_CODE = (
    "shapegoogle_core/mesh",
    "shapegoogle_core/preprocessing",
    "shapegoogle_core/laplacian",
    "shapegoogle_core/spectral",
    "shapegoogle_core/model/describe.py",
    "shapegoogle_core/model/augmentation",
)
"""Files and folders that a prepared spectrum depends on, relative to the repository."""

SIGNATURE_CODE = (
    *PREPARATION_CODE,
    "shapegoogle_core/descriptors",
    "shapegoogle_core/keypoints",
    "shapegoogle_core/words",
    "shapegoogle_core/model",
    "shapegoogle_core/registration",
)
"""What a signature depends on besides the model's content."""

SEARCH_CODE = (*SIGNATURE_CODE, "shapegoogle_core/library", "shapegoogle_core/indexing")
"""What an answer of the search depends on besides the model."""

# These neither describe nor search.
_OTHER_CODE = re.compile(
    r"shapegoogle_core/(model/(training|metric)|words/(hashing|estimators|vocabulary|tfidf))\.py"
)


class BenchmarkCache:
    """A folder of named arrays.

    Parameters
    ----------
    folder : Path
        Made if it is not there.

    Raises
    ------
    BenchmarkError
        If it cannot be made.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise BenchmarkError(f"cannot make the cache '{folder}': {error.strerror or error}") from error

    def __repr__(self) -> str:
        return f"BenchmarkCache('{self.folder}')"

    def path(self, kind: str, key: str, suffix: str = ".npz") -> Path:
        """Where an entry is, or would be; its folder exists.

        Parameters
        ----------
        kind : str
            Such as "shapes": a folder of its own.
        key : str
            From `digest`.
        suffix : str

        Returns
        -------
        path : Path
        """
        folder = self.folder / kind / key[:2]
        folder.mkdir(parents=True, exist_ok=True)
        return folder / f"{key}{suffix}"

    def load(self, kind: str, key: str) -> Arrays | None:
        """Read an entry.

        Parameters
        ----------
        kind, key : str

        Returns
        -------
        arrays : dict of str to array, or None
            None if there is no such entry, or it is damaged: then it is to be made again.
        """
        path = self.path(kind, key)
        try:
            with np.load(path, allow_pickle=False) as archive:
                return {name: archive[name] for name in archive.files}
        except FileNotFoundError:
            return None
        except (OSError, ValueError, EOFError, KeyError, zipfile.BadZipFile, zlib.error):
            # Cut short by a full disk, say. The new entry will replace it.
            return None

    def store(self, kind: str, key: str, arrays: Mapping[str, NDArray[Any]]) -> None:
        """Write an entry, whole or not at all.

        Parameters
        ----------
        kind, key : str
        arrays : mapping of str to array

        Raises
        ------
        BenchmarkError
            If it cannot be written.
        """
        path = self.path(kind, key)
        unfinished = path.with_name(f".{path.name}.{os.getpid()}")
        try:
            with unfinished.open("wb") as file:
                np.savez(file, allow_pickle=False, **arrays)
            unfinished.replace(path)
        except OSError as error:
            unfinished.unlink(missing_ok=True)
            raise BenchmarkError(
                f"cannot write into the cache '{self.folder}' ({error.strerror or error}); make room, or "
                "name another folder with --cache"
            ) from error

    def remembered(self, kind: str, key: str, make: Callable[[], Arrays]) -> Arrays:
        """Read an entry, or make and write it.

        Parameters
        ----------
        kind, key : str
        make : callable
            Returns the arrays.

        Returns
        -------
        arrays : dict of str to array
        """
        arrays = self.load(kind, key)
        if arrays is None:
            arrays = make()
            self.store(kind, key, arrays)
        return arrays


def digest(*parts: object) -> str:
    """Hash what an entry depends on.

    Parameters
    ----------
    *parts : str, int, float, None, bytes, array, or lists and mappings of them

    Returns
    -------
    key : str
        32 hex digits.
    """
    text = json.dumps([CACHE_VERSION, *parts], sort_keys=True, default=_content)
    return hashlib.sha256(text.encode()).hexdigest()[:32]


def _content(value: object) -> object:
    if isinstance(value, np.ndarray):
        data = np.ascontiguousarray(value)
        return [str(data.dtype), list(data.shape), hashlib.sha256(data.tobytes()).hexdigest()]
    if isinstance(value, bytes):
        return hashlib.sha256(value).hexdigest()
    raise TypeError(f"{value!r} has no digest")


@cache
def content_digest(path: Path) -> str:
    """Hash the content of a file; it is read once in a process.

    Parameters
    ----------
    path : Path

    Returns
    -------
    hexadecimal : str
        Empty if the file cannot be read: whoever reads it will say why.
    """
    try:
        return hashlib.sha256(path.read_bytes()).hexdigest()
    except OSError:
        return ""


@cache
def code_digest(parts: tuple[str, ...]) -> str:
    """Hash source code of this repository.

    Parameters
    ----------
    parts : tuple of str
        Patterns of files and folders in the repository, such as `PREPARATION_CODE`.

    Returns
    -------
    hexadecimal : str
    """
    repository = Path(__file__).parents[2]
    hashed = hashlib.sha256()
    for part in parts:
        for place in sorted(repository.glob(part)):
            for path in sorted(place.rglob("*.py")) if place.is_dir() else [place]:
                name = path.relative_to(repository).as_posix()
                if not _OTHER_CODE.fullmatch(name):
                    hashed.update(name.encode())
                    hashed.update(path.read_bytes())
    return hashed.hexdigest()


def preparation_of(settings: ModelSettings) -> list[object]:
    """List the settings that a prepared spectrum depends on: preprocessing, area, operator, pairs."""
    preprocessing = None if settings.preprocessing is None else vars(settings.preprocessing)
    return [preprocessing, settings.area, settings.laplacian, settings.boundary, settings.eigenpairs]


def cached_shape(
    store: BenchmarkCache, settings: ModelSettings, shape_key: str, mesh: Callable[[], Mesh]
) -> WorkingShape:
    """Prepare a shape as a model's settings say and decompose it, unless that was done before.

    Eigenvectors are kept as float32, which halves the file: on TOSCA and PSB the bags of both shipped models,
    which differ by about 1 from shape to shape, moved by less than 1e-5 (L1).

    Parameters
    ----------
    store : BenchmarkCache
    settings : ModelSettings
        Only their preprocessing, area, Laplacian and number of eigenpairs matter.
    shape_key : str
        Digest of what the mesh is made from.
    mesh : callable
        Makes the mesh where it is needed.

    Returns
    -------
    shape : WorkingShape
        Of float64, the same whether it was at hand or not. Its mesh has no name.

    Raises
    ------
    MeshError
        If the mesh cannot be read, made, prepared or decomposed.
    """

    def make() -> Arrays:
        shape = working_shape(settings, mesh())
        return {
            "vertices": shape.mesh.vertices,
            "faces": shape.mesh.faces,
            "origin": shape.placement.origin,
            "scale": np.array(shape.placement.scale),
            "eigenvalues": shape.spectrum.eigenvalues,
            "eigenvectors": shape.spectrum.eigenvectors.astype(np.float32),
            "mass": shape.spectrum.mass,
        }

    key = digest(shape_key, preparation_of(settings), code_digest(PREPARATION_CODE))
    arrays = store.remembered("shapes", key, make)
    return WorkingShape(
        Mesh(arrays["vertices"], arrays["faces"]),
        Spectrum(arrays["eigenvalues"], arrays["eigenvectors"].astype(np.float64), arrays["mass"]),
        Placement(arrays["origin"], float(arrays["scale"])),
    )
