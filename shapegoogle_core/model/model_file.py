# SPDX-License-Identifier: MIT
"""The file of a model: a numpy .npz archive whose entry `header` is JSON; nothing is pickled.

Files keep the names that they always had, also where the code has better ones now, so that models and their
identifiers stay valid.
"""

from __future__ import annotations

import hashlib
import io
import json
import zipfile
import zlib
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import fields
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from shapegoogle_core.errors import ModelError
from shapegoogle_core.model.background import Background
from shapegoogle_core.model.ranking import Ranking
from shapegoogle_core.model.settings import ModelSettings
from shapegoogle_core.model.shape_bags import ChannelWords
from shapegoogle_core.registration import LocalWords
from shapegoogle_core.views import GradientViews, NetworkViews, ViewModel

if TYPE_CHECKING:
    from shapegoogle_core.model.shape_model import ShapeModel

__all__ = [
    "arrays_of",
    "check_learnt",
    "damage_refused",
    "identifier_of",
    "pack",
    "unpack",
    "views_identifier",
]

FORMAT = 1
"""Version of the model file; files of higher versions are refused."""

# A file that claims to hold more than any model does is not unpacked.
_MOST_BYTES = 2**28

Arrays = dict[str, NDArray[np.generic]]
Fields = Mapping[str, Any]
"""Fields of a `ShapeModel` by their names."""

_LEARNT = ("weights", "mean", "projection", "directions", "thresholds")
_NUMBERS_AND_TEXT = (
    "similarity_half",
    "similarity_slope",
    "trained_on",
    "agreement_gain",
    "verified_half",
    "verified_slope",
)
_BACKGROUND = ("distinctive", "exponent", "verified_exponent")
_RANKING = (
    "view_weight",
    "bag_weight",
    "figure_weight",
    "unknown_views",
    "agreement",
    "power",
    "distinctive",
    "distrust",
    "certain_odds",
    "likeness_half",
    "likeness_slope",
)


def arrays_of(model: Fields) -> Arrays:
    """Return all arrays of a model by their names in its file.

    Parameters
    ----------
    model : mapping
        Its fields.

    Returns
    -------
    arrays : dict
    """
    arrays: Arrays = {name: model[name] for name in _LEARNT}
    arrays["sigmas"] = np.array([words.sigma for words in model["vocabularies"]])
    for index, words in enumerate(model["vocabularies"]):
        arrays[f"centers_{index}"] = words.centers
    if model["local_words"] is not None:
        arrays |= {
            f"local_{entry.name}": getattr(model["local_words"], entry.name) for entry in fields(LocalWords)
        }
    return arrays


def _part_arrays(model: Fields) -> Arrays:
    """Return the arrays of parts that say nothing about the bags, and so do not count for the identifier."""
    arrays: Arrays = {}
    if (views := model["views"]) is not None:
        own = views.gradients
        arrays = {"views_mean": own.mean, "views_code": own.code_components}
        arrays |= {f"views_projection_{index}": part for index, part in enumerate(own.projections)}
        if (network := views.network) is not None:
            arrays |= {
                "views_network_mean": network.mean,
                "views_network_projection": network.projection,
                "views_network_digest": np.array(network.digest),
            }
    if model["background"] is not None:
        arrays["background_vectors"] = model["background"].vectors
    if (ranking := model["ranking"]) is not None:
        arrays["ranking_figures"] = np.stack([ranking.figure_mean, ranking.figure_scale])
    return arrays


def identifier_of(settings: Mapping[str, Any], arrays: Arrays, agreement_gain: float) -> str:
    """Hash everything that ranks matches.

    Parameters
    ----------
    settings : mapping
        From `ModelSettings.to_dict`.
    arrays : dict
        From `arrays_of`.
    agreement_gain : float
        0 for models from before it existed, which keep their identifier.

    Returns
    -------
    identifier : str
        16 hexadecimal digits.
    """
    digest = hashlib.sha256(json.dumps(settings, sort_keys=True).encode())
    for name, array in sorted(arrays.items()):
        digest.update(name.encode())
        digest.update(np.ascontiguousarray(array).tobytes())
    if agreement_gain:
        digest.update(repr(agreement_gain).encode())
    return digest.hexdigest()[:16]


def pack(model: Fields, identifier: str) -> bytes:
    """Write a model into an archive.

    Parameters
    ----------
    model : mapping
        Its fields.
    identifier : str

    Returns
    -------
    data : bytes
    """
    header = {"format": FORMAT, "settings": model["settings"].to_dict(), "identifier": identifier}
    header |= {name: model[name] for name in _NUMBERS_AND_TEXT}
    if model["views"] is not None:
        header["views"] = model["views"].identifier
    if model["background"] is not None:
        header["background"] = {name: getattr(model["background"], name) for name in _BACKGROUND}
    if model["ranking"] is not None:
        header["ranking"] = {name: getattr(model["ranking"], name) for name in _RANKING}
    text = np.array(json.dumps(header, sort_keys=True))
    buffer = io.BytesIO()
    np.savez_compressed(buffer, allow_pickle=False, header=text, **arrays_of(model), **_part_arrays(model))
    return buffer.getvalue()


def unpack(data: bytes, origin: str) -> tuple[Fields, str]:
    """Read the fields of a model from an archive.

    Parameters
    ----------
    data : bytes
    origin : str
        Name of the model in error messages.

    Returns
    -------
    fields : mapping
    identifier : str

    Raises
    ------
    ModelError
        If the archive has a newer format. A damaged archive raises any exception; see `damage_refused`.
    """
    with np.load(io.BytesIO(data), allow_pickle=False) as archive:
        if sum(entry.file_size for entry in archive.zip.infolist()) > _MOST_BYTES:
            raise ValueError
        arrays = {name: archive[name] for name in archive.files}
    header = json.loads(str(arrays["header"]))
    if header["format"] > FORMAT:
        raise ModelError(
            f"{origin} has format {header['format']}, newer than this version of Shape Google "
            f"can read (up to {FORMAT}); update Shape Google"
        )
    settings = ModelSettings.from_dict(header["settings"])
    model = {
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
        "views": _views(arrays) if "views_mean" in arrays else None,
        "ranking": _ranking(header, arrays),
        "background": _background(header, arrays) if "background" in header else None,
    }
    return model, header.get("identifier") or _earlier_identifier(model, header["settings"], arrays)


def views_identifier(data: bytes) -> str | None:
    """Return the identifier of a model's views without reading the rest.

    Parameters
    ----------
    data : bytes
        Result of `pack`.

    Returns
    -------
    identifier : str or None
        None for a model without views, and for a damaged one.
    """
    try:
        with np.load(io.BytesIO(data), allow_pickle=False) as archive:
            header = json.loads(str(archive["header"]))
    except (OSError, ValueError, KeyError, zipfile.BadZipFile, zlib.error):
        return None
    identifier = header.get("views")
    return identifier if isinstance(identifier, str) else None


def _local_words(arrays: Arrays) -> LocalWords:
    return LocalWords(
        centers=arrays["local_centers"].astype(np.float32), weights=arrays["local_weights"].astype(np.float32)
    )


def _views(arrays: Arrays) -> ViewModel:
    gradients = GradientViews(
        mean=arrays["views_mean"].astype(np.float32),
        projections=tuple(
            arrays[name].astype(np.float16) for name in sorted(arrays) if name.startswith("views_projection_")
        ),
        code_components=arrays["views_code"].astype(np.int64),
    )
    # Models made before there was a network know gradients only.
    if "views_network_mean" not in arrays:
        return ViewModel(gradients)
    network = NetworkViews(
        mean=arrays["views_network_mean"].astype(np.float32),
        projection=arrays["views_network_projection"].astype(np.float16),
        digest=str(arrays["views_network_digest"]),
    )
    return ViewModel(gradients, network)


def _background(header: Mapping[str, Any], arrays: Arrays) -> Background:
    numbers = {name: float(header["background"][name]) for name in _BACKGROUND}
    return Background(vectors=arrays["background_vectors"].astype(np.float16), **numbers)


def _ranking(header: Mapping[str, Any], arrays: Arrays) -> Ranking | None:
    """Read the ranking; None for a model without one, or with one of an earlier kind."""
    if not set(_RANKING) <= set(header.get("ranking", {})):
        return None
    mean, scale = arrays["ranking_figures"].astype(np.float32)
    numbers = {name: float(header["ranking"][name]) for name in _RANKING}
    return Ranking(figure_mean=mean, figure_scale=scale, **numbers)


def _earlier_identifier(model: Fields, settings: Mapping[str, Any], arrays: Arrays) -> str:
    """Identify a model whose file does not state its identifier.

    Earlier local words had codes of their own. They are no longer read, but the identifier depends on them.
    """
    described = model["settings"].to_dict()
    if model["local_words"] is not None:
        described["local"] |= settings["local"]
    earlier = {name: arrays[name] for name in ("local_mean", "local_directions") if name in arrays}
    return identifier_of(described, arrays_of(model) | earlier, model["agreement_gain"])


@contextmanager
def damage_refused(origin: str) -> Iterator[None]:
    """Turn any exception of reading an archive inside the block into a `ModelError` that names it.

    Parameters
    ----------
    origin : str
        Name of the model in error messages.

    Raises
    ------
    ModelError
        If the block raises anything.
    """
    try:
        yield
    except ModelError:
        raise
    except Exception as error:
        # Depending on where it is damaged, an archive makes zipfile, zlib, numpy or json fail.
        raise ModelError(
            f"{origin} is not a Shape Google model, or it is damaged; train or copy it again"
        ) from error


def check_learnt(model: ShapeModel) -> None:
    """Raise unless all that a model has learnt has the sizes that its settings ask for.

    A damaged file must not give wrong answers.

    Parameters
    ----------
    model : ShapeModel

    Raises
    ------
    ModelError
        If an array has another shape or is not finite, or a number is out of range.
    """
    size, projected, bits = model.bag_size, model.projection.shape[-1], model.code_bits
    expected = {
        "weights": (size,),
        "mean": (size,),
        "projection": (size, projected),
        "directions": (bits, projected),
        "thresholds": (bits,),
    }
    for name, shape in expected.items():
        array = getattr(model, name)
        if array.shape != shape or not np.isfinite(array).all():
            raise ModelError(f"the model's {name} are damaged: expected finite numbers of shape {shape}")
    for channel, words in zip(model.settings.channels, model.vocabularies, strict=True):
        fits = words.centers.shape == (channel.words, channel.size)
        if not (fits and np.isfinite(words.centers).all() and 0 < words.sigma < np.inf):
            raise ModelError(f"the model's vocabulary of {channel.descriptor!r} is damaged")
    calibration = (model.similarity_half, model.similarity_slope, model.verified_half, model.verified_slope)
    if not all(0 < value < np.inf for value in calibration):
        raise ModelError("the model's calibration of similarities is damaged")
    if not 0 <= model.agreement_gain < np.inf:
        raise ModelError("the model's agreement_gain is damaged: it must be a number ≥ 0")
    width = projected if model.settings.metric == "cosine" else size
    if model.background is not None and model.background.vectors.shape[1] != width:
        raise ModelError(f"the model's background is damaged: expected rows of {width} numbers")
    local = None if model.settings.local is None else model.settings.local.words
    if local != (None if model.local_words is None else len(model.local_words.weights)):
        raise ModelError("the model's local words are damaged: they are not of the size in its settings")
