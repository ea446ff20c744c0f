# SPDX-License-Identifier: MIT
"""`ServiceSettings`: what a service serves, to whom, and its limits."""

from __future__ import annotations

import json
import os
from dataclasses import asdict, dataclass
from pathlib import Path
from urllib.parse import urlsplit

from shapegoogle_core.errors import ShapeGoogleError
from shapegoogle_core.library.storage.address import is_database

__all__ = ["VARIABLE", "ServiceError", "ServiceSettings", "short_name"]

VARIABLE = "SHAPEGOOGLE_SERVICE"
"""Environment variable by which the processes of a service get their settings."""


class ServiceError(ShapeGoogleError):
    """A request that cannot be answered; the message is one sentence for the client.

    Parameters
    ----------
    status : int
        Status code of the answer.
    sentence : str
    retry_after : int, optional
        Seconds after which the client may try again.
    """

    def __init__(self, status: int, sentence: str, retry_after: int | None = None) -> None:
        super().__init__(sentence)
        self.status = status
        self.retry_after = retry_after


@dataclass(frozen=True)
class ServiceSettings:
    """Settings of a service.

    Attributes
    ----------
    library : str
        Path or address of the library.
    spool : str
        Existing folder for uploads and results, which all processes of the service share.
    host : str
        Address that the service listens at.
    port : int
    workers : int
        Number of processes.
    token_file : str or None
        File of the tokens; None: nobody needs one, which is allowed on a loopback address only.
    allow_download : bool
        Whether clients may download the files that shapes come from.
    max_upload : int
        Largest upload, in megabytes.
    time_limit : float
        Seconds that reading and describing an upload may take, and a search.
    memory_limit : int
        Megabytes that reading and describing an upload may take.
    rate : int
        Searches and uploads of a client per minute; other requests may be twenty times as many.
    upload_seconds : float
        Longest time that receiving a request may take.
    max_waiting : int
        Number of requests that may wait for a search in each process.
    """

    library: str
    spool: str
    host: str = "127.0.0.1"
    port: int = 8765
    workers: int = 1
    token_file: str | None = None
    allow_download: bool = False
    max_upload: int = 64
    time_limit: float = 60.0
    memory_limit: int = 2048
    rate: int = 120
    upload_seconds: float = 60.0
    max_waiting: int = 64

    def to_environment(self) -> None:
        """Write the settings into this process's environment, for the processes that it starts."""
        os.environ[VARIABLE] = json.dumps(asdict(self))

    @classmethod
    def from_environment(cls) -> ServiceSettings:
        """Read the settings that `to_environment` wrote."""
        return cls(**json.loads(os.environ[VARIABLE]))


def short_name(library: str) -> str:
    """Return the name of a library as clients see it, without the place where it lies.

    Parameters
    ----------
    library : str
        Path or address.

    Returns
    -------
    name : str

    Examples
    --------
    >>> from shapegoogle_core.service.settings import short_name
    >>> short_name("/srv/shapes.sglib"), short_name("postgresql://ana:secret@db.example/shapes?schema=props")
    ('shapes.sglib', 'shapes')
    """
    if is_database(library):
        return urlsplit(library).path.strip("/") or "library"
    return Path(library).name
