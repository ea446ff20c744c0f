# SPDX-License-Identifier: MIT
"""A PostgreSQL database: connection, transactions, and errors as `LibraryError`.

One program at a time changes a library: each transaction that writes takes one lock, which it gives back when
it is committed. So ids become visible in the order in which they are given, and a search that reads the codes
after the last id it knows misses none. Transactions take milliseconds; readers never wait.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from typing import Any

import numpy as np
import psycopg
from numpy.typing import NDArray
from psycopg import sql
from psycopg.conninfo import make_conninfo

from shapegoogle_core.errors import LibraryError
from shapegoogle_core.library.storage.local_folders import LocalFolders
from shapegoogle_core.library.storage.postgresql.adapters import register_adapters
from shapegoogle_core.library.storage.postgresql.address import DatabaseAddress
from shapegoogle_core.library.storage.postgresql.errors import database_error, unreachable
from shapegoogle_core.library.storage.store import damaged

__all__ = ["Database"]

# "SGLB", the first half of the key of the lock; the second is the name of the schema.
_LOCK_CLASS = 0x53474C42
OLDEST_SERVER = 140_000
_CONNECT_SECONDS = 15


class Database:
    """A connection to the database of a library. Errors of psycopg become `LibraryError`.

    A connection that was lost between two calls is made again by the next one.

    Parameters
    ----------
    address : DatabaseAddress
    read_only : bool
        Refuse changes.
    timeout : float
        Longest time to wait for another program's lock, in seconds.

    Attributes
    ----------
    name : str
        The address without password, as error messages name the library.
    """

    def __init__(self, address: DatabaseAddress, *, read_only: bool, timeout: float) -> None:
        self.address = address
        self.name = address.name
        self.timeout = timeout
        self.local_folders = LocalFolders()
        self._requested_read_only = read_only
        self._closed = False
        self._connection = self._connect()

    @property
    def connection(self) -> psycopg.Connection[Any]:
        """The connection, made again if it was lost outside a transaction."""
        if self._closed:
            raise LibraryError(f"'{self.name}' was closed; open it again with Library.open")
        if self._connection.closed:
            self._connection = self._connect()
        return self._connection

    def close(self) -> None:
        """Close the connection. Closing twice does no harm."""
        self._closed = True
        with suppress(psycopg.Error):  # nothing can be lost any more
            self._connection.close()

    def _connect(self) -> psycopg.Connection[Any]:
        parameters: dict[str, Any] = {
            "connect_timeout": _CONNECT_SECONDS,
            "application_name": "shapegoogle",
            **self.address.parameters,
        }
        try:
            connection = psycopg.connect(make_conninfo(**parameters), autocommit=True)
        except psycopg.Error as error:
            raise unreachable(error, self.name) from error
        try:
            with self._explained(connection):
                self._prepare(connection)
        except BaseException:
            connection.close()
            raise
        return connection

    def _prepare(self, connection: psycopg.Connection[Any]) -> None:
        if connection.info.server_version < OLDEST_SERVER:
            raise LibraryError(
                f"'{self.name}' is PostgreSQL {connection.info.server_version // 10_000}; a library needs "
                "PostgreSQL 14 or later: upgrade the server"
            )
        encoding = connection.info.parameter_status("server_encoding")
        if encoding != "UTF8":
            raise LibraryError(
                f"'{self.name}' stores text as {encoding}; make a database with the encoding UTF8: "
                "createdb --template=template0 --encoding=UTF8 NAME"
            )
        register_adapters(connection)
        # Nothing but the library's own schema: in "public" others may make objects, which would be taken for
        # missing ones of the library.
        connection.execute(
            sql.SQL("SET search_path TO {}, pg_temp").format(sql.Identifier(self.address.schema))
        )
        connection.execute(f"SET lock_timeout TO {max(1, round(1000 * self.timeout))}")
        if self._requested_read_only:
            connection.execute("SET default_transaction_read_only TO on")

    # -- transactions ---------------------------------------------------------------------------------------

    @contextmanager
    def snapshot(self) -> Iterator[None]:
        """Let all reads inside see the library at one moment."""
        with self._transaction("BEGIN ISOLATION LEVEL REPEATABLE READ READ ONLY"):
            yield

    @contextmanager
    def writing(self) -> Iterator[None]:
        """Run the changes inside as one transaction: all of them are stored, or none."""
        if self._requested_read_only:
            raise LibraryError(
                f"'{self.name}' was opened with read_only=True; open it without to add or remove shapes"
            )
        with self._transaction("BEGIN"):
            self.connection.execute(
                "SELECT pg_advisory_xact_lock(%s, hashtext(%s))", (_LOCK_CLASS, self.address.schema)
            )
            yield

    @contextmanager
    def _transaction(self, begin: str) -> Iterator[None]:
        connection = self.connection
        with self._explained(connection):
            try:
                connection.execute(begin)
                yield
                connection.execute("COMMIT")
            except BaseException:  # Ctrl-C as well: no transaction may stay open
                if not connection.closed:
                    with suppress(psycopg.Error):  # the first error counts
                        connection.execute("ROLLBACK")
                raise

    @contextmanager
    def explained(self) -> Iterator[None]:
        """Turn errors of psycopg into `LibraryError`."""
        with self._explained(self.connection):
            yield

    @contextmanager
    def _explained(self, connection: psycopg.Connection[Any]) -> Iterator[None]:
        try:
            yield
        except psycopg.Error as error:
            raise database_error(error, self.name, self.timeout, lost=connection.closed) from error

    # -- statements -----------------------------------------------------------------------------------------

    def rows(self, statement: str, *parameters: object) -> list[tuple[Any, ...]]:
        """Run a query and return all rows."""
        with self.explained(), self.connection.cursor(binary=True) as cursor:
            return cursor.execute(statement.encode(), parameters).fetchall()

    def rows_with_ids(self, statement: str, ids: Sequence[int]) -> list[tuple[Any, ...]]:
        """Run a query that ends with the column of ids, for these ids; rows come in the order of ids."""
        if not ids:
            return []
        return self.rows(f"{statement} = ANY(%s::bigint[]) ORDER BY 1", list(ids))

    def value(self, statement: str, *parameters: object) -> Any:
        """Run a query and return its first value, None if there is none."""
        rows = self.rows(statement, *parameters)
        return rows[0][0] if rows else None

    def execute(self, statement: str, *parameters: object) -> int:
        """Run a change, inside `writing`; return how many rows it met."""
        return self.connection.execute(statement.encode(), parameters).rowcount

    def matrix(self, blobs: Sequence[bytes], dtype: np.dtype[Any], width: int) -> NDArray[Any]:
        """Stack the contents of rows into an array (n, width); `LibraryError` if their lengths do not fit."""
        if any(len(blob) != width * dtype.itemsize for blob in blobs):
            raise self.damaged("a bag or code has another length than its model's")
        return np.frombuffer(b"".join(blobs), dtype).reshape(len(blobs), width)

    def damaged(self, detail: str) -> LibraryError:
        """Make the error for content that contradicts itself."""
        return damaged(self.name, detail)
