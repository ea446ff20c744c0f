# SPDX-License-Identifier: MIT
"""Tokens of a service: a file with their names, scopes and hashes, from which nobody can make a token.

A token is 256 random bits, so that a plain SHA-256 protects it: there is nothing to guess. Its text is shown
once, when it is created.
"""

from __future__ import annotations

import hashlib
import json
import os
import secrets
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import asdict, dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Literal, get_args

from shapegoogle_core.errors import ShapeGoogleError
from shapegoogle_core.processes.temporary import locked

__all__ = ["SCOPES", "Scope", "Token", "TokenError", "TokenFile"]

Scope = Literal["read", "write"]

SCOPES: tuple[Scope, ...] = get_args(Scope)
"""What a token allows: searching and looking; or decisions and tags as well."""

_PREFIX = "sg_"


class TokenError(ShapeGoogleError):
    """A file of tokens cannot be used, or does not have a token."""


@dataclass(frozen=True)
class Token:
    """A token, without its text.

    Attributes
    ----------
    name : str
        Whom it was made for.
    scope : {"read", "write"}
    sha256 : str
        Hash of its text.
    created : float
        In seconds since 1970.
    """

    name: str
    scope: Scope
    sha256: str
    created: float

    @property
    def date(self) -> str:
        """Day on which it was created, such as "2026-11-30"."""
        return datetime.fromtimestamp(self.created, UTC).date().isoformat()


class TokenFile:
    """A file of tokens, which is read again whenever it has changed.

    Parameters
    ----------
    path : Path

    Examples
    --------
    >>> import tempfile
    >>> from pathlib import Path
    >>> from shapegoogle_core.service.tokens import TokenFile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     file = TokenFile(Path(folder, "tokens.json"))
    ...     text = file.create("ana", "write")
    ...     file.find(text).name, file.find("something else"), file.revoke("ana"), file.find(text)
    ('ana', None, True, None)
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self._read: tuple[tuple[int, int, int], dict[str, Token]] | None = None

    def tokens(self) -> list[Token]:
        """Return all tokens in the order of their names.

        Returns
        -------
        tokens : list of Token

        Raises
        ------
        TokenError
            If the file is damaged or cannot be read; a missing file has no tokens.
        """
        return sorted(self._by_hash().values(), key=lambda token: token.name)

    def find(self, text: str) -> Token | None:
        """Return the token with a text, None if there is none.

        Parameters
        ----------
        text : str
            As a client sent it.

        Returns
        -------
        token : Token or None

        Raises
        ------
        TokenError
            See `tokens`.
        """
        return self._by_hash().get(_hash(text))

    def create(self, name: str, scope: Scope) -> str:
        """Make a token.

        Parameters
        ----------
        name : str
        scope : {"read", "write"}

        Returns
        -------
        text : str
            The token itself, which is stored nowhere.

        Raises
        ------
        TokenError
            If there is a token of this name, or the file cannot be written.
        """
        if not name.strip():
            raise TokenError("a token needs a name, such as that of the person who will use it")
        text = _PREFIX + secrets.token_urlsafe(32)
        with self._changing():
            tokens = self.tokens()
            if any(token.name == name for token in tokens):
                raise TokenError(
                    f"'{self.path}' has a token {name!r} already; revoke it first, or choose another name"
                )
            self._write([*tokens, Token(name, scope, _hash(text), time.time())])
        return text

    def revoke(self, name: str) -> bool:
        """Remove a token; a running service refuses it from then on.

        Parameters
        ----------
        name : str

        Returns
        -------
        known : bool
            Whether there was such a token.

        Raises
        ------
        TokenError
            If the file cannot be read or written.
        """
        with self._changing():
            tokens = self.tokens()
            others = [token for token in tokens if token.name != name]
            if len(others) == len(tokens):
                return False
            self._write(others)
        return True

    @contextmanager
    def _changing(self) -> Iterator[None]:
        """Let nobody else change the file between reading and writing it."""
        # The file itself is replaced by each change, so another one is locked.
        lock = self.path.with_name(f"{self.path.name}.lock")
        with ExitStack() as stack:
            try:
                stack.enter_context(locked(lock))
            except OSError as error:
                raise TokenError(f"'{self.path}' cannot be written: {error.strerror}") from error
            yield

    def _by_hash(self) -> dict[str, Token]:
        try:
            status = self.path.stat()
            identity = (status.st_ino, status.st_mtime_ns, status.st_size)
            if self._read is None or self._read[0] != identity:
                listed = json.loads(self.path.read_text(encoding="utf-8"))["tokens"]
                tokens = [Token(**{**record, "scope": _scope(record["scope"])}) for record in listed]
                self._read = identity, {token.sha256: token for token in tokens}
        except FileNotFoundError:
            return {}
        except OSError as error:
            raise TokenError(f"'{self.path}' cannot be read: {error.strerror}") from error
        except (ValueError, KeyError, TypeError) as error:
            raise TokenError(
                f"'{self.path}' is not a file of tokens, or is damaged; create the tokens again in a new file"
            ) from error
        return self._read[1]

    def _write(self, tokens: list[Token]) -> None:
        content = json.dumps({"tokens": [asdict(token) for token in tokens]}, indent=1) + "\n"
        draft = self.path.with_name(f"{self.path.name}.{secrets.token_hex(4)}")
        try:
            # Nobody else may read even the hashes; and the file is replaced as a whole.
            descriptor = os.open(draft, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600)
            with os.fdopen(descriptor, "w", encoding="utf-8") as file:
                file.write(content)
                file.flush()
                os.fsync(file.fileno())
            draft.replace(self.path)
        except OSError as error:
            draft.unlink(missing_ok=True)
            raise TokenError(f"'{self.path}' cannot be written: {error.strerror}") from error


def _hash(text: str) -> str:
    return hashlib.sha256(text.encode("utf-8", "surrogatepass")).hexdigest()


def _scope(text: object) -> Scope:
    for scope in SCOPES:
        if scope == text:
            return scope
    raise ValueError(f"there is no scope {text!r}")
