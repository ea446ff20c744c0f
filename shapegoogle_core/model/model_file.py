# SPDX-License-Identifier: MIT
"""The file of a model: a numpy .npz archive whose entry `header` is JSON; nothing is pickled."""

from __future__ import annotations

import io
import json
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import fields
from importlib import resources
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from shapegoogle_core.errors import ModelError
from shapegoogle_core.model.describe import ChannelWords
from shapegoogle_core.model.settings import ModelSettings
from shapegoogle_core.registration import LocalWords

__all__ = ["arrays_of", "damage_refused", "pack", "read_file", "unpack"]

FORMAT = 1
"""Version of the model file; a file with a higher one is refused."""

SHIPPED = ("default", "paper")
"""Models inside the package, made by `python -m benchmarks train`."""

Arrays = dict[str, NDArray[np.generic]]
Fields = Mapping[str, Any]
"""Of a `ShapeModel`, by their names."""

_LEARNT = ("weights", "mean", "projection", "directions", "thresholds")
_NUMBERS_AND_TEXT = (
    "similarity_half",
    "similarity_slope",
    "trained_on",
    "agreement_gain",
    "verified_half",
    "verified_slope",
)


def arrays_of(model: Fields) -> Arrays:
    """Name all arrays of a model as they stand in its file."""
    arrays: Arrays = {name: model[name] for name in _LEARNT}
    arrays["sigmas"] = np.array([words.sigma for words in model["vocabularies"]])
    for index, words in enumerate(model["vocabularies"]):
        arrays[f"centers_{index}"] = words.centers
    if model["local_words"] is not None:
        arrays |= {
            f"local_{entry.name}": getattr(model["local_words"], entry.name) for entry in fields(LocalWords)
        }
    return arrays


def pack(model: Fields) -> bytes:
    """Write a model into an archive.

    Parameters
    ----------
    model : mapping
        Its fields.

    Returns
    -------
    data : bytes
    """
    header = {"format": FORMAT, "settings": model["settings"].to_dict()}
    header |= {name: model[name] for name in _NUMBERS_AND_TEXT}
    text = np.array(json.dumps(header, sort_keys=True))
    buffer = io.BytesIO()
    np.savez_compressed(buffer, allow_pickle=False, header=text, **arrays_of(model))
    return buffer.getvalue()


def unpack(data: bytes, origin: str) -> Fields:
    """Read the fields of a model from an archive.

    Parameters
    ----------
    data : bytes
    origin : str
        What errors call the model.

    Returns
    -------
    fields : mapping

    Raises
    ------
    ModelError
        If it is of a newer version. A damaged archive fails in any way; see `damage_refused`.
    """
    with np.load(io.BytesIO(data), allow_pickle=False) as archive:
        arrays = {name: archive[name] for name in archive.files}
    header = json.loads(str(arrays["header"]))
    if header["format"] > FORMAT:
        raise ModelError(
            f"{origin} has format {header['format']}, newer than this version of Shape Google "
            f"can read (up to {FORMAT}); update Shape Google"
        )
    settings = ModelSettings.from_dict(header["settings"])
    return {
        "settings": settings,
        "vocabularies": tuple(
            ChannelWords(arrays[f"centers_{index}"].astype(np.float64), float(sigma))
            for index, sigma in enumerate(arrays["sigmas"])
        ),
        "weights": arrays["weights"].astype(np.float32),
        "mean": arrays["mean"].astype(np.float32),
        "projection": arrays["projection"].astype(np.float16),
        "directions": arrays["directions"].astype(np.float32),
        "thresholds": arrays["thresholds"].astype(np.float32),
        "similarity_half": float(header["similarity_half"]),
        "similarity_slope": float(header["similarity_slope"]),
        "trained_on": str(header["trained_on"]),
        # Models made before surfaces were sampled do not have these.
        "agreement_gain": float(header.get("agreement_gain", 0.0)),
        "verified_half": float(header.get("verified_half", 1.0)),
        "verified_slope": float(header.get("verified_slope", 1.0)),
        "local_words": None if settings.local is None else _local_words(arrays),
    }


def _local_words(arrays: Arrays) -> LocalWords:
    return LocalWords(
        centers=arrays["local_centers"].astype(np.float32),
        weights=arrays["local_weights"].astype(np.float32),
        mean=arrays["local_mean"].astype(np.float32),
        directions=arrays["local_directions"].astype(np.int8),
    )


@contextmanager
def damage_refused(origin: str) -> Iterator[None]:
    """Turn whatever goes wrong with an archive inside the block into a `ModelError` that names it."""
    try:
        yield
    except ModelError:
        raise
    except Exception as error:
        # Damaged archives make zipfile, zlib, numpy and json fail in every way.
        raise ModelError(
            f"{origin} is not a Shape Google model, or it is damaged ({error}); train or copy it again"
        ) from error


def read_file(path: str | Path | None) -> tuple[bytes, str]:
    """Read a model's archive.

    Parameters
    ----------
    path : str or Path or None
        A file, or the name of a shipped model; None is "default".

    Returns
    -------
    data : bytes
    origin : str
        What errors call the model.

    Raises
    ------
    ModelError
        If there is no such file.
    """
    key = "default" if path is None else str(path)
    if key in SHIPPED:
        data = (resources.files("shapegoogle_core") / "model" / "shipped" / f"{key}.npz").read_bytes()
        return data, f"the shipped model {key!r}"
    try:
        return Path(key).read_bytes(), repr(key)
    except OSError as error:
        raise ModelError(
            f"cannot read the model {key!r}: {error.strerror or error}; give a file made by "
            f"`shapegoogle train`, or one of {', '.join(SHIPPED)}"
        ) from error
