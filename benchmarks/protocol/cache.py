# SPDX-License-Identifier: MIT
"""Intermediate results on disk: an interrupted run continues, and a second one takes seconds.

A key is a hash of everything that a result depends on: the content of the mesh file, the transformation,
settings, and the source code involved. So no result is ever outdated, and nothing must be deleted by hand.
"""

from __future__ import annotations

import hashlib
import re
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import joblib
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

PREPARATION_CODE = (
    "shapegoogle_core/mesh",
    "shapegoogle_core/preprocessing",
    "shapegoogle_core/laplacian",
    "shapegoogle_core/spectral",
    "shapegoogle_core/model/working_shape.py",
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
"""Code that a signature depends on, besides the content of the model."""

SEARCH_CODE = (*SIGNATURE_CODE, "shapegoogle_core/library", "shapegoogle_core/indexing")
"""Code that the matches of a query depend on, besides the content of the model."""

# Files of these folders that neither describe nor search.
_OTHER_CODE = re.compile(
    r"shapegoogle_core/(model/(training|metric)|words/(hashing|estimators|vocabulary|tfidf))\.py"
)


class BenchmarkCache:
    """Results of functions on disk, found by their keys.

    joblib writes each result completely or not at all, and a damaged one counts as missing. Results are
    pickled, so use folders of your own only.

    Parameters
    ----------
    folder : Path
        Created if it does not exist.

    Raises
    ------
    BenchmarkError
        If it cannot be created.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise BenchmarkError(f"cannot make the cache '{folder}': {error.strerror}") from error
        self._computed = joblib.Memory(folder, verbose=0).cache(_computed, ignore=["compute"])

    def __repr__(self) -> str:
        return f"BenchmarkCache('{self.folder}')"

    def path(self, kind: str, key: str, suffix: str) -> Path:
        """Return the path of a file that is not an array, such as a library; its folder exists.

        Parameters
        ----------
        kind : str
            Name of the file's folder.
        key : str
            From `digest`.
        suffix : str

        Returns
        -------
        path : Path
        """
        folder = self.folder / kind
        folder.mkdir(exist_ok=True)
        return folder / f"{key}{suffix}"

    def load(self, kind: str, key: str) -> Arrays | None:
        """Read a result.

        Parameters
        ----------
        kind : str
            What the result is, such as "shapes".
        key : str
            From `digest`.

        Returns
        -------
        arrays : dict of str to array, or None
            None if there is no such result, or it is damaged.
        """
        if not self._computed.check_call_in_cache(kind, key, _give_up):
            return None
        try:
            arrays: Arrays = self._computed(kind, key, _give_up)
        except _MissingError:
            return None
        return arrays

    def remembered(self, kind: str, key: str, compute: Callable[[], Arrays]) -> Arrays:
        """Read a result, or compute and write it.

        Parameters
        ----------
        kind, key : str
            As for `load`.
        compute : callable
            Returns the arrays.

        Returns
        -------
        arrays : dict of str to array

        Raises
        ------
        BenchmarkError
            If the result cannot be written.
        """
        arrays: Arrays = self._computed(kind, key, compute)
        # joblib only warns if it cannot write.
        if not self._computed.check_call_in_cache(kind, key, compute):
            raise BenchmarkError(
                f"cannot write into the cache '{self.folder}'; free disk space, or name another folder with "
                "--cache"
            )
        return arrays


class _MissingError(Exception):
    """A result is missing, and must not be computed."""


def _computed(kind: str, key: str, compute: Callable[[], Arrays]) -> Arrays:
    """Compute a result; the function that joblib remembers, by kind and key."""
    del kind, key
    return compute()


def _give_up() -> Arrays:
    raise _MissingError


def digest(*parts: object) -> str:
    """Hash everything that a result depends on.

    Parameters
    ----------
    *parts : object
        Numbers, strings, arrays, and lists and dictionaries of them.

    Returns
    -------
    key : str
        32 hexadecimal digits.
    """
    key: str = joblib.hash(parts)
    return key


@cache
def content_digest(path: Path) -> str:
    """Hash the content of a file; each process reads it once.

    Parameters
    ----------
    path : Path

    Returns
    -------
    hexadecimal : str
        Empty if the file cannot be read: the reader of the mesh will say why.
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
        Files and folders, relative to the repository, such as `PREPARATION_CODE`.

    Returns
    -------
    hexadecimal : str

    Raises
    ------
    ValueError
        If one of them does not exist.
    """
    repository = Path(__file__).parents[2]
    hashed = hashlib.sha256()
    for part in parts:
        place = repository / part
        if not place.exists():
            raise ValueError(f"'{part}' is not in the repository; name the files that results depend on")
        for path in sorted(place.rglob("*.py")) if place.is_dir() else [place]:
            name = path.relative_to(repository).as_posix()
            if not _OTHER_CODE.fullmatch(name):
                hashed.update(name.encode())
                hashed.update(path.read_bytes())
    return hashed.hexdigest()


def preparation_of(settings: ModelSettings) -> list[object]:
    """List the settings of a model that a prepared spectrum depends on.

    Parameters
    ----------
    settings : ModelSettings

    Returns
    -------
    values : list
        Preprocessing, area, Laplacian, boundary and number of eigenpairs.
    """
    preprocessing = None if settings.preprocessing is None else vars(settings.preprocessing)
    return [preprocessing, settings.area, settings.laplacian, settings.boundary, settings.eigenpairs]


def cached_shape(
    store: BenchmarkCache, settings: ModelSettings, shape_key: str, mesh: Callable[[], Mesh]
) -> WorkingShape:
    """Preprocess a shape with a model's settings and compute its spectrum, unless that was done before.

    Eigenvectors are rounded to float32, which halves the file and changes bags by less than 1e-5 (L1).

    Parameters
    ----------
    store : BenchmarkCache
    settings : ModelSettings
        Only their preprocessing, area, Laplacian and number of eigenpairs matter.
    shape_key : str
        Digest of what the mesh is made from.
    mesh : callable
        Returns the mesh; called only if the result is not on disk.

    Returns
    -------
    shape : WorkingShape
        Of float64, with eigenvectors rounded to float32; its mesh has no name.

    Raises
    ------
    MeshError
        If the mesh cannot be read, made or preprocessed, or has no spectrum.
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
