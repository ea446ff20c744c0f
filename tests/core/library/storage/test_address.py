# SPDX-License-Identifier: MIT
"""Addresses of libraries: what of them is shown, and where passwords go."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st
from psycopg.conninfo import conninfo_to_dict

from shapegoogle_core.client import LibraryAddress
from shapegoogle_core.library.storage.address import (
    shown_place,
    split_password,
    with_password,
    without_passwords,
)
from shapegoogle_core.library.storage.postgresql.address import parse_address

SECRETS = st.text(st.characters(codec="utf-8", exclude_characters="\0"), min_size=1, max_size=12)
ADDRESSES = (
    "postgresql://ana@server/shapes",
    "postgresql:///shapes",
    "postgres://ana@/shapes?host=/tmp/server&schema=props",
    "postgresql://ana@one,two:5433/shapes?sslmode=require",
    "postgresql://",
    "PostgreSQL://ana@[::1]:5432/shapes?service=studio",
)


@given(SECRETS, st.sampled_from(ADDRESSES))
def test_a_password_comes_back(secret: str, place: str) -> None:
    given = with_password(place, secret)
    assert parse_address(given).parameters["password"] == secret
    rest, password = split_password(given)
    assert password == secret
    assert parse_address(rest).parameters == parse_address(place).parameters
    assert shown_place(given) == shown_place(place)


@pytest.mark.parametrize(
    ("given", "rest"),
    [
        ("postgresql://ana:se%40cret@server/shapes", "postgresql://ana@server/shapes"),
        ("postgresql://:se%40cret@server/shapes", "postgresql://server/shapes"),
        ("postgresql://ana@server/shapes?password=se%40cret&a=b", "postgresql://ana@server/shapes?a=b"),
    ],
)
def test_passwords_are_found_wherever_an_address_has_them(given: str, rest: str) -> None:
    assert conninfo_to_dict(given.replace("&a=b", ""))["password"] == "se@cret"
    assert split_password(given) == (rest, "se@cret")
    assert with_password(given, "other") == given
    assert "cret" not in shown_place(given)
    assert "cret" not in without_passwords(f"--library={given.replace('postgresql', 'PostgreSQL')}")


@pytest.mark.parametrize("place", ["postgresql://[", "https://ana:secret@server", "/a/b.sglib", ""])
def test_other_places_stay_as_they_are(place: str) -> None:
    assert split_password(place) == (place, "")


def test_an_address_does_not_show_its_password() -> None:
    assert "secret" not in repr(LibraryAddress("postgresql://server/shapes", password="secret"))
