# SPDX-License-Identifier: MIT
"""Models of services, each downloaded once and kept under the hash of its content."""

from __future__ import annotations

import hashlib
import os
import re
import sys
from contextlib import suppress
from pathlib import Path
from tempfile import NamedTemporaryFile

from shapegoogle_core.client.address import ServiceAddress
from shapegoogle_core.client.connection import Connection
from shapegoogle_core.errors import LibraryError, ModelError
from shapegoogle_core.model import ShapeModel

__all__ = ["cache_folder", "model_file", "model_of_service"]

_HASH = re.compile(r"[0-9a-f]{64}")
# Models take a few MB. A service that has another one each day must not fill the disk.
_MOST_KEPT = 8


def cache_folder() -> Path:
    """Return the folder that models are kept in, which need not exist yet."""
    if sys.platform == "win32":
        base = Path(os.environ.get("LOCALAPPDATA") or Path.home() / "AppData" / "Local")
    elif sys.platform == "darwin":
        base = Path.home() / "Library" / "Caches"
    else:
        base = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    return base / "shapegoogle" / "models"


def model_file(content_hash: str, folder: Path) -> Path:
    """Return the file that a model with a hash is kept in, which need not exist yet."""
    return folder / f"{content_hash}.npz"


def model_of_service(connection: Connection, content_hash: str, folder: Path) -> ShapeModel:
    """Return the model that a service describes shapes with.

    Parameters
    ----------
    connection : Connection
    content_hash : str
        SHA-256 of the model's file, as the service states it.
    folder : Path
        Where models are kept.

    Returns
    -------
    model : ShapeModel

    Raises
    ------
    LibraryError
        If it cannot be downloaded, or this version cannot read it.
    """
    address = connection.address
    if not _HASH.fullmatch(content_hash):
        raise LibraryError(f"'{address}' does not say which model it uses; update the service")
    path = model_file(content_hash, folder)
    content = _kept(path, content_hash)
    if content is None:
        content = connection.get_bytes("model")
        if hashlib.sha256(content).hexdigest() != content_hash:
            raise LibraryError(f"the model of '{address}' has changed while it was downloaded; try again")
        model = _read(content, address)
        _keep(path, content)
        return model
    return _read(content, address)


def _read(content: bytes, address: ServiceAddress) -> ShapeModel:
    try:
        return ShapeModel.from_bytes(content, origin=f"the model of '{address}'")
    except ModelError as error:
        raise LibraryError(str(error)) from error


def _kept(path: Path, content_hash: str) -> bytes | None:
    """Read a model that was kept; None if there is none, or it is damaged."""
    try:
        content = path.read_bytes()
    except OSError:
        return None
    with suppress(OSError):  # a folder that others fill
        os.utime(path)  # those not used for longest go first
    return content if hashlib.sha256(content).hexdigest() == content_hash else None


def _keep(path: Path, content: bytes) -> None:
    """Keep a model; where that is not possible it is downloaded again the next time."""
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with NamedTemporaryFile(dir=path.parent, delete=False) as draft:
            try:
                draft.write(content)
                draft.close()
                Path(draft.name).replace(path)
            except BaseException:
                draft.close()
                Path(draft.name).unlink(missing_ok=True)
                raise
        kept = [other for other in path.parent.iterdir() if _HASH.fullmatch(other.stem)]
        for other in sorted(kept, key=lambda other: other.stat().st_mtime)[:-_MOST_KEPT]:
            other.unlink(missing_ok=True)
    except OSError:
        return
