# SPDX-License-Identifier: MIT
"""`KeptTokens`: tokens for services, in a file that only its user may read."""

from __future__ import annotations

import json
import os
from contextlib import suppress
from pathlib import Path

from shapegoogle_core.errors import LibraryError

__all__ = ["KeptTokens"]


class KeptTokens:
    """Tokens by the addresses of their services.

    Parameters
    ----------
    path : Path
        The file; it need not exist. On Linux and macOS only its owner may read it.

    Examples
    --------
    >>> import tempfile
    >>> from pathlib import Path
    >>> from shapegoogle_core.client import KeptTokens
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     tokens = KeptTokens(Path(folder) / "tokens.json")
    ...     tokens.keep("https://shapes.example", "secret")
    ...     tokens.token("https://shapes.example"), tokens.token("https://other.example")
    ('secret', '')
    """

    def __init__(self, path: Path) -> None:
        self._path = path

    def token(self, address: str) -> str:
        """Return the token for a service.

        Parameters
        ----------
        address : str

        Returns
        -------
        token : str
            Empty if there is none, or the file cannot be read.
        """
        return self._read().get(address, "")

    def keep(self, address: str, token: str) -> None:
        """Keep the token for a service in place of an earlier one.

        Parameters
        ----------
        address : str
        token : str
            Empty to forget it.

        Raises
        ------
        LibraryError
            If the file cannot be written.
        """
        tokens = {**self._read(), address: token.strip()}
        text = json.dumps({place: kept for place, kept in tokens.items() if kept}, indent=1)
        draft = self._path.with_name(f"{self._path.name}.new")
        try:
            self._path.parent.mkdir(parents=True, exist_ok=True)
            with suppress(FileNotFoundError):
                draft.unlink()
            # Nobody else may read it, not even for the moment before its permissions are changed.
            with os.fdopen(os.open(draft, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600), "w") as file:
                file.write(text)
            draft.replace(self._path)
        except OSError as error:
            raise LibraryError(
                f"the token cannot be kept in '{self._path}': {error.strerror}; check the folder"
            ) from error

    def _read(self) -> dict[str, str]:
        try:
            found = json.loads(self._path.read_text())
        except (OSError, ValueError):
            return {}
        if not isinstance(found, dict):
            return {}
        return {place: token for place, token in found.items() if isinstance(token, str)}
