# SPDX-License-Identifier: MIT
"""Who may do what, and how often: tokens, rates, and requests that another web page makes a browser send."""

from __future__ import annotations

import time
from collections import OrderedDict
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated
from urllib.parse import urlsplit

from fastapi import Depends, Request
from fastapi.security import APIKeyCookie, HTTPAuthorizationCredentials, HTTPBearer
from fastapi.security.utils import get_authorization_scheme_param

from shapegoogle_core.api.hosts import is_loopback
from shapegoogle_core.service.settings import ServiceError, ServiceSettings
from shapegoogle_core.service.tokens import Scope, Token, TokenFile

__all__ = ["COOKIE", "TOKENS_UNREADABLE", "Access", "Client", "reader", "searcher", "writer"]

COOKIE = "shapegoogle_token"
TOKENS_UNREADABLE = "the service cannot read its tokens; whoever runs it finds the reason in its log"
_BEARER = HTTPBearer(auto_error=False, description="A token from `shapegoogle token create`.")
_COOKIE = APIKeyCookie(name=COOKIE, auto_error=False, description="The same token, as the web page sends it.")
# Other requests than searches and uploads cost little.
_CHEAP = 20
# Clients whose rates are remembered.
_MOST_CLIENTS = 10_000
_MINUTE = 60.0
# Methods that change nothing.
_SAFE = {"GET", "HEAD", "OPTIONS"}


@dataclass(frozen=True)
class Client:
    """Who sends a request.

    Attributes
    ----------
    name : str
        Of the token; empty without tokens.
    scope : {"read", "write"}
    """

    name: str
    scope: Scope


class Access:
    """Decides about requests.

    Parameters
    ----------
    settings : ServiceSettings
    """

    def __init__(self, settings: ServiceSettings) -> None:
        self._settings = settings
        self.file = None if settings.token_file is None else TokenFile(Path(settings.token_file))
        # Tokens that are left to each client, and when that was; each process allows its share.
        share = settings.rate / settings.workers
        self._rates = {
            "search": (_Buckets(share), "searches and uploads"),
            "read": (_Buckets(share * _CHEAP), "requests"),
        }

    @property
    def needs_token(self) -> bool:
        """Whether requests need a token."""
        return self.file is not None

    def token(self, text: str | None) -> Token | None:
        """Return the token with a text, None if there is none."""
        return None if self.file is None or not text else self.file.find(text)

    def check_origin(self, request: Request) -> None:
        """Refuse what a page of somebody else makes a browser send.

        Raises
        ------
        ServiceError
            403.
        """
        host = _host_of(f"//{request.headers.get('host', '')}")
        if not self.needs_token and not is_loopback(host):
            # A name that somebody made point to this machine: the browser believes to speak with another one.
            raise ServiceError(403, f"this service does not answer under the name {host!r}; use localhost")
        if request.method in _SAFE:
            return
        site = request.headers.get("sec-fetch-site")
        origin = request.headers.get("origin")
        foreign = site not in ("same-origin", "none", None)
        if site is None:  # an old browser, or no browser
            foreign = origin is not None and origin.partition("//")[2] != request.headers.get("host")
        if foreign:
            raise ServiceError(403, "requests from other web pages are refused")

    def check_sender(self, request: Request) -> None:
        """Refuse a request of somebody whose content need not be received at all.

        Raises
        ------
        ServiceError
            See `check_origin` and `client`.
        """
        self.check_origin(request)
        scheme, text = get_authorization_scheme_param(request.headers.get("authorization"))
        self.client(request, text if scheme.lower() == "bearer" else request.cookies.get(COOKIE))

    def client(self, request: Request, text: str | None) -> Client:
        """Return who sends a request.

        Raises
        ------
        ServiceError
            401 without a valid token.
        """
        if not self.needs_token:
            return Client("", "write")
        found = self.token(text)
        if found is None:
            self.count("search", request)  # trying tokens is limited too
            given = "is not valid (any more)" if text else "is missing"
            raise ServiceError(401, f"the token {given}; ask whoever runs this service for one")
        return Client(found.name, found.scope)

    def count(self, rate: str, request: Request, client: Client | None = None) -> None:
        """Count a request.

        Raises
        ------
        ServiceError
            429 if the client sends too many.
        """
        address = "" if request.client is None else request.client.host
        buckets, noun = self._rates[rate]
        wait = buckets.wait(client.name if client is not None and client.name else address)
        if wait > 0:
            seconds = max(1, round(wait))
            raise ServiceError(429, f"too many {noun} in a minute; try again in {seconds} s", seconds)


def _host_of(address: str) -> str:
    """Return the name of the machine in an address; empty if it cannot be understood."""
    try:
        return urlsplit(address).hostname or ""
    except ValueError:
        return ""


class _Buckets:
    """For each client a number of requests that it may send at once, which grows again with time."""

    def __init__(self, per_minute: float) -> None:
        self._most = max(1.0, per_minute)
        self._left: OrderedDict[str, tuple[float, float]] = OrderedDict()

    def wait(self, client: str) -> float:
        """Count a request; return the seconds until it would be allowed, 0 if it is."""
        now = time.monotonic()
        left, since = self._left.pop(client, (self._most, now))
        left = min(self._most, left + (now - since) * self._most / _MINUTE)
        allowed = left >= 1
        self._left[client] = (left - 1 if allowed else left, now)
        if len(self._left) > _MOST_CLIENTS:
            self._left.popitem(last=False)
        return 0.0 if allowed else (1 - left) * _MINUTE / self._most


Bearer = Annotated[HTTPAuthorizationCredentials | None, Depends(_BEARER)]
Cookie = Annotated[str | None, Depends(_COOKIE)]


def _checked(request: Request, bearer: Bearer, cookie: Cookie, *, rate: str, scope: Scope) -> Client:
    access: Access = request.app.state.access
    access.check_origin(request)
    client = access.client(request, cookie if bearer is None else bearer.credentials)
    access.count(rate, request, client)
    if scope == "write" and client.scope != "write":
        raise ServiceError(403, f"the token {client.name!r} allows reading only; ask for one that may write")
    return client


def reader(request: Request, bearer: Bearer, cookie: Cookie) -> Client:
    """Let requests through that read."""
    return _checked(request, bearer, cookie, rate="read", scope="read")


def searcher(request: Request, bearer: Bearer, cookie: Cookie) -> Client:
    """Let requests through that search, or describe an upload."""
    return _checked(request, bearer, cookie, rate="search", scope="read")


def writer(request: Request, bearer: Bearer, cookie: Cookie) -> Client:
    """Let requests through that change decisions and tags."""
    return _checked(request, bearer, cookie, rate="read", scope="write")
