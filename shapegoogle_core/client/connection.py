# SPDX-License-Identifier: MIT
"""`Connection`: requests to a service over HTTP, and what goes wrong on the way, in one sentence each."""

from __future__ import annotations

import http.client
import json
import re
import socket
import ssl
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from importlib.util import find_spec
from pathlib import Path
from typing import Any
from urllib.parse import urlencode

from shapegoogle_core import __version__
from shapegoogle_core.client.address import ServiceAddress
from shapegoogle_core.client.proxies import proxy_for
from shapegoogle_core.errors import LibraryError

__all__ = ["Connection", "NotThereError", "understood"]

# Seconds to connect, and to wait for an answer; the service itself gives up earlier.
CONNECT_SECONDS = 10.0
ANSWER_SECONDS = 90.0
# A service that is busy for no longer than this is asked again, that often.
_PATIENCE = 6
_ATTEMPTS = 3
# Nothing that a service answers is larger.
_MOST_BYTES = 2**27
_SECONDS = re.compile(r"[0-9]{1,4}")
# Codes of OpenSSL (X509_V_ERR_…).
_EXPIRED, _NOT_YET_VALID, _OTHER_HOST, _OTHER_IP = 10, 9, 62, 64


class NotThereError(LibraryError):
    """The service does not know (any more) what was asked for."""


class Connection:
    """Requests to one service, which belong to one thread.

    They go through the proxy that the environment variable https_proxy or the computer's settings name.

    Parameters
    ----------
    address : ServiceAddress
    token : str, optional
        Sent with each request.
    certificate : str, optional
        File with the certificates of further authorities, in the format PEM.
    timeout : float, optional
        Longest time to wait for an answer, in seconds.

    Raises
    ------
    LibraryError
        If the token, the certificate or the proxy cannot be used.
    """

    def __init__(
        self,
        address: ServiceAddress,
        token: str = "",
        certificate: str = "",
        timeout: float = ANSWER_SECONDS,
    ) -> None:
        self.address = address
        token = token.strip()
        if not (token.isascii() and token.isprintable()) or " " in token:
            raise LibraryError(f"the token for '{address}' has characters that no token has; copy it again")
        self._timeout = timeout
        self._context = _tls(certificate) if address.is_encrypted else None
        self._proxy = proxy_for(address)
        self._headers = {
            "Accept": "application/json",
            "User-Agent": f"shapegoogle/{__version__}",
        }
        if token:
            self._headers["Authorization"] = f"Bearer {token}"
        self._open: http.client.HTTPConnection | None = None

    def get(self, path: str, **values: object) -> Any:
        """Return the JSON at a path below ``/api/``.

        Parameters
        ----------
        path : str
        **values : object
            Of the query string.

        Returns
        -------
        content : object

        Raises
        ------
        LibraryError
            If there is no answer, or a refusal.
        """
        return self._json("GET", f"{path}?{urlencode(values)}" if values else path)

    def get_bytes(self, path: str) -> bytes:
        """Return the content at a path below ``/api/``; otherwise like `get`."""
        return self._request("GET", path, None)

    def post(self, path: str, content: Mapping[str, object], *, once: bool = False) -> Any:
        """Send JSON to a path below ``/api/``, and return the JSON of the answer.

        Parameters
        ----------
        path : str
        content : mapping
        once : bool, optional
            Whether the request changes something, so that it must not be sent twice.

        Returns
        -------
        content : object

        Raises
        ------
        LibraryError
            If there is no answer, or a refusal.
        """
        return self._json("POST", path, json.dumps(content).encode(), once=once)

    def delete(self, path: str) -> Any:
        """Delete what is at a path below ``/api/``, and return the JSON of the answer; see `get`."""
        return self._json("DELETE", path, once=True)

    def close(self) -> None:
        """Close the connection; the next request opens another one."""
        if self._open is not None:
            self._open.close()
            self._open = None

    def _json(self, method: str, path: str, body: bytes | None = None, *, once: bool = False) -> Any:
        content = self._request(method, path, body, once=once)
        with understood(self.address):
            return json.loads(content)

    def _request(self, method: str, path: str, body: bytes | None, *, once: bool = False) -> bytes:
        attempts = 1 if once else _ATTEMPTS
        for left in reversed(range(attempts)):
            status, headers, content = self._answer(method, path, body, fresh=once)
            if 200 <= status < 300:
                return content
            named = headers.get("retry-after", "")
            wait = int(named) if _SECONDS.fullmatch(named) else None
            if not left or status not in (429, 503) or wait is None or wait > _PATIENCE:
                break
            time.sleep(wait)
        self.close()  # a refusal may end the connection
        raise self._refusal(status, headers, content)

    def _answer(
        self, method: str, path: str, body: bytes | None, *, fresh: bool
    ) -> tuple[int, dict[str, str], bytes]:
        """Send a request; a connection that was closed meanwhile is opened again."""
        if fresh:
            self.close()
        reused = self._open is not None
        try:
            return self._exchange(method, path, body)
        except (ConnectionError, http.client.BadStatusLine) as error:
            self.close()
            if not reused:
                raise self._failure(error) from error
        except (OSError, http.client.HTTPException) as error:
            self.close()
            raise self._failure(error) from error
        return self._answer(method, path, body, fresh=True)

    def _exchange(self, method: str, path: str, body: bytes | None) -> tuple[int, dict[str, str], bytes]:
        if self._open is None:
            self._open = self._connected()
        headers = self._headers if body is None else {**self._headers, "Content-Type": "application/json"}
        self._open.request(method, f"{self.address.prefix}/api/{path}", body, headers)
        answer = self._open.getresponse()
        content = answer.read(_MOST_BYTES + 1)
        if len(content) > _MOST_BYTES:
            self.close()
            raise LibraryError(
                f"'{self.address}' answers with more than {_MOST_BYTES // 2**20:,} MB; ask for less"
            )
        if answer.length:  # reading a part at a time does not tell that the rest is missing
            raise http.client.IncompleteRead(content, answer.length)
        known = {name.lower(): value for name, value in answer.getheaders()}
        if not answer.isclosed() or answer.will_close:
            self.close()
        return answer.status, known, content

    def _connected(self) -> http.client.HTTPConnection:
        host, port = self.address.host, self.address.port
        connection: http.client.HTTPConnection
        if self._context is None:
            connection = http.client.HTTPConnection(host, port, timeout=CONNECT_SECONDS)
        elif self._proxy is None:
            connection = http.client.HTTPSConnection(
                host, port, timeout=CONNECT_SECONDS, context=self._context
            )
        else:
            connection = http.client.HTTPSConnection(
                self._proxy.host, self._proxy.port, timeout=CONNECT_SECONDS, context=self._context
            )
            connection.set_tunnel(host.encode("idna").decode(), port, self._proxy.headers)
        try:
            connection.connect()
        except ssl.SSLError:  # of the service itself, see `_failure`
            raise
        except TimeoutError as error:
            raise LibraryError(
                f"'{self.address}' cannot be reached within {CONNECT_SECONDS:g} s; check the address and the "
                "network"
            ) from error
        except (OSError, http.client.HTTPException) as error:
            if self._proxy is None:
                raise
            raise LibraryError(
                f"the proxy '{self._proxy}' leads to no service at '{self.address}'; check the address, and "
                "the environment variables https_proxy and no_proxy or the proxy of this computer"
            ) from error
        connection.sock.settimeout(self._timeout)
        return connection

    def _failure(self, error: Exception) -> LibraryError:
        """Say what went wrong on the way."""
        where = f"'{self.address}'"
        if isinstance(error, ssl.SSLCertVerificationError):
            return LibraryError(f"{where} {_about_certificate(error.verify_code)}")
        if isinstance(error, ssl.SSLError):
            return LibraryError(f"{where} does not speak HTTPS as expected; check the address and its port")
        if isinstance(error, socket.gaierror):
            return LibraryError(
                f"there is no server {self.address.host!r}; check the address {where}, and the network"
            )
        if isinstance(error, TimeoutError):
            return LibraryError(f"{where} did not answer within {self._timeout:g} s; try again later")
        if isinstance(error, ConnectionRefusedError):
            return LibraryError(
                f"nothing answers at {where}; check the address, or ask whoever runs the service to start it"
            )
        if isinstance(error, http.client.HTTPException) and not isinstance(
            error, (http.client.IncompleteRead, http.client.RemoteDisconnected)
        ):
            return _no_service(self.address)
        if isinstance(error, (ConnectionError, http.client.HTTPException)):
            return LibraryError(f"the connection to {where} was lost; try again")
        return LibraryError(f"{where} cannot be reached; check the address and the network")

    def _refusal(self, status: int, headers: Mapping[str, str], content: bytes) -> LibraryError:
        """Say why the service has not answered what was asked."""
        where = f"'{self.address}'"
        if 300 <= status < 400:
            target = headers.get("location", "")
            usable = target.isprintable() and 0 < len(target) <= 200
            advice = f"use {target!r} if you trust it" if usable else "ask whoever runs the service for it"
            return LibraryError(f"{where} sends requests on to another address; {advice}")
        sentence = _sentence_in(content)
        if status == 401:
            given = "refuses the token" if "Authorization" in self._headers else "needs a token"
            return LibraryError(f"{where} {given}; ask whoever runs the service for one, and enter it")
        if not sentence:
            if status in (500, 502, 503, 504):
                return LibraryError(
                    f"the service behind {where} does not work at the moment; try again later"
                )
            if status in (408, 413, 429):
                return LibraryError(
                    f"{where} refused the request as too large or too frequent; try again later"
                )
            return _no_service(self.address)
        kind = NotThereError if status == 404 else LibraryError
        return kind(f"{where}: {sentence}")


@contextmanager
def understood(address: ServiceAddress) -> Iterator[None]:
    """Refuse an answer that lacks something or has it in another form.

    Parameters
    ----------
    address : ServiceAddress

    Returns
    -------
    context : context manager

    Raises
    ------
    LibraryError
    """
    try:
        yield
    except (
        KeyError,
        TypeError,
        ValueError,
        AttributeError,
        IndexError,
        OverflowError,
        RecursionError,
    ) as error:
        raise _no_service(address) from error


def _no_service(address: ServiceAddress) -> LibraryError:
    return LibraryError(
        f"what answers at '{address}' is no Shape Google service that this version understands; check the "
        "address, and that both have the same version"
    )


def _sentence_in(content: bytes) -> str:
    """Return the sentence of an error that the service has answered; empty if there is none."""
    try:
        answer = json.loads(content)
    except ValueError:
        return ""
    sentence = answer.get("error", "") if isinstance(answer, dict) else ""
    return sentence[:500] if isinstance(sentence, str) and sentence.isprintable() else ""


def _tls(certificate: str) -> ssl.SSLContext:
    context = ssl.create_default_context()
    if find_spec("certifi") is not None:
        # The Python of some programs, such as Blender, does not find the authorities of the system.
        import certifi

        context.load_verify_locations(certifi.where())
    if certificate:
        try:
            context.load_verify_locations(Path(certificate))
        except OSError as error:  # also for a file that holds something else
            raise LibraryError(
                f"'{certificate}' cannot be read as a certificate; name a file in the format PEM"
            ) from error
    return context


def _about_certificate(code: int) -> str:
    if code in (_EXPIRED, _NOT_YET_VALID):
        return (
            "has a certificate that is not valid today; check the date of this computer, or ask whoever runs "
            "the service to renew it"
        )
    if code in (_OTHER_HOST, _OTHER_IP):
        return "has a certificate for another name; use the name that it was made for"
    return (
        "has a certificate that nobody this computer knows has signed; ask whoever runs the service for the "
        "file of its certificate, and name that as the certificate of the server"
    )
