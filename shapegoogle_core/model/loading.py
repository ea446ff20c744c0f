# SPDX-License-Identifier: MIT
"""Loading of models: shipped ones by their names, others from files."""

from __future__ import annotations

from importlib import resources
from pathlib import Path

from shapegoogle_core.api.arguments import as_path
from shapegoogle_core.errors import ModelError
from shapegoogle_core.model.shape_model import ShapeModel

__all__ = ["SHIPPED", "as_model", "load_model"]

SHIPPED = ("default", "paper")
"""Names of the models inside the package, made by `python -m benchmarks train`."""


def load_model(path: str | Path | None = None) -> ShapeModel:
    """Load a model.

    Parameters
    ----------
    path : str or Path, optional
        A model file, or the name of a shipped model: "default" (also when left out) or "paper".

    Returns
    -------
    model : ShapeModel

    Raises
    ------
    ModelError
        If the file cannot be read, or is not a model.

    Examples
    --------
    >>> import shapegoogle_core as sg
    >>> sg.load_model()
    ShapeModel('default', cba0db7ebddee94c)
    >>> sg.load_model("paper").settings.eigenpairs
    200
    """
    key = "default" if path is None else str(as_path(path))
    if key in SHIPPED:
        shipped = resources.files("shapegoogle_core") / "model" / "shipped" / f"{key}.npz"
        return ShapeModel.from_bytes(shipped.read_bytes(), f"the shipped model {key!r}")
    try:
        data = Path(key).read_bytes()
    except OSError as error:
        raise ModelError(
            f"cannot read the model {key!r}: {error.strerror}; give a file made by "
            f"`shapegoogle train`, or one of {', '.join(SHIPPED)}"
        ) from error
    return ShapeModel.from_bytes(data, repr(key))


def as_model(model: ShapeModel | str | Path | None) -> ShapeModel:
    """Return a model as it is, or load the one with this name or path.

    Parameters
    ----------
    model : ShapeModel, str, Path or None
        A model, or what `load_model` accepts.

    Returns
    -------
    model : ShapeModel

    Raises
    ------
    ModelError
        If it cannot be loaded.
    """
    return model if isinstance(model, ShapeModel) else load_model(model)
