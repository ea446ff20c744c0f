# SPDX-License-Identifier: MIT
"""What the owner of a library in a database does now and then: access of roles, index of codes, upgrade."""

from __future__ import annotations

import math
import os
import shutil
import subprocess
from collections.abc import Sequence
from pathlib import Path

from psycopg import sql
from psycopg.conninfo import make_conninfo

from shapegoogle_core.errors import LibraryError
from shapegoogle_core.library.storage.postgresql.codes import CODE_INDEX
from shapegoogle_core.library.storage.postgresql.schema import FORMAT, TABLES, schema_statements
from shapegoogle_core.library.storage.postgresql.store import PostgresqlStore
from shapegoogle_core.model import ShapeModel

__all__ = [
    "back_up",
    "grants",
    "index_memory",
    "index_statements",
    "is_outdated",
    "run_statements",
    "upgrade_tables",
]

_READER = ("USAGE ON SCHEMA", "SELECT ON ALL TABLES IN SCHEMA", "SELECT ON ALL SEQUENCES IN SCHEMA")
_WRITER = (
    "USAGE ON SCHEMA",
    "SELECT, INSERT, UPDATE, DELETE ON ALL TABLES IN SCHEMA",
    "ALL ON ALL SEQUENCES IN SCHEMA",
)
_OLDEST_VECTOR = (0, 7)

MOST_LISTS = 2_000
"""Of the index. As a tenth of the lists is searched, more of them would hardly save time; making an index of
this many takes 0.9 GB of memory, and the need grows with the square of the number."""

# Bytes of a code or a centre, with pgvector's numbers about it; codes of the shipped model have 32.
_CODE_ROOM = 128


def grants(store: PostgresqlStore, readers: Sequence[str], writers: Sequence[str]) -> list[str]:
    """Write the statements that let roles search a library, or also change it.

    Parameters
    ----------
    store : PostgresqlStore
    readers, writers : sequence of str
        Names of roles of the server.

    Returns
    -------
    statements : list of str
    """
    schema = sql.Identifier(store.address.schema)
    return [
        sql.SQL(f"GRANT {what} {{}} TO {{}}").format(schema, sql.Identifier(role)).as_string(store.connection)
        for roles, rights in ((readers, _READER), (writers, _WRITER))
        for role in roles
        for what in rights
    ]


def index_statements(store: PostgresqlStore) -> list[str]:
    """Write the statements that make the index of codes, or make it anew for the present number of codes.

    Parameters
    ----------
    store : PostgresqlStore

    Returns
    -------
    statements : list of str

    Raises
    ------
    LibraryError
        If the server has no pgvector, or an old one.
    """
    version = store.value("SELECT default_version FROM pg_available_extensions WHERE name = 'vector'")
    if version is None or tuple(int(part) for part in version.split(".")[:2]) < _OLDEST_VECTOR:
        found = "no pgvector" if version is None else f"pgvector {version}"
        raise LibraryError(
            f"the server of '{store.name}' has {found}; install pgvector 0.7 or later there, or "
            "go on without an index: all codes are compared then"
        )
    lists = min(MOST_LISTS, max(1, round(math.sqrt(store.count()))))
    schema = store.vector_schema() or "public"
    kilobytes = index_memory(lists) // 1024
    given = int(store.value("SELECT setting FROM pg_settings WHERE name = 'maintenance_work_mem'"))
    room = [f"SET maintenance_work_mem TO '{kilobytes}kB'"] if kilobytes > given else []
    return [
        f"CREATE EXTENSION IF NOT EXISTS vector SCHEMA {schema}",
        f"DROP INDEX IF EXISTS {CODE_INDEX}",
        *room,
        f"CREATE INDEX {CODE_INDEX} ON codes USING ivfflat (code {schema}.bit_hamming_ops)"
        f" WITH (lists = {lists})",
        *(["RESET maintenance_work_mem"] if room else []),
        "ANALYZE codes",
    ]


def index_memory(lists: int) -> int:
    """Bound the memory in which pgvector groups codes for an index; it refuses to work with less.

    It takes 50 codes for each list (10,000 at least), and keeps a bound for the distance of each from the
    centre of each list, in single precision: k-means after Elkan (2003). The rest are the codes, their
    centres and distances of centres. Measured: 21 MB for 316 lists, 198 for 1,000, 785 for 2,000.

    Parameters
    ----------
    lists : int

    Returns
    -------
    bytes : int

    References
    ----------
    C. Elkan: Using the Triangle Inequality to Accelerate k-Means. ICML 2003.
    """
    samples = max(10_000, 50 * lists)
    return 4 * lists * (samples + 2 * lists) + _CODE_ROOM * (samples + 3 * lists) + 2**24


def run_statements(store: PostgresqlStore, statements: Sequence[str]) -> None:
    """Run statements in one transaction.

    Parameters
    ----------
    store : PostgresqlStore
    statements : sequence of str
    """
    with store.writing():
        for statement in statements:
            store.execute(statement)


def is_outdated(store: PostgresqlStore) -> bool:
    """Whether tables are missing that this version of Shape Google uses.

    Parameters
    ----------
    store : PostgresqlStore

    Returns
    -------
    outdated : bool

    Raises
    ------
    LibraryError
        If the library is of a newer version.
    """
    version = int(store.value("SELECT value FROM meta WHERE key = 'schema'"))
    if version > FORMAT:
        store.check_format()
    missing = store.value(
        "SELECT count(*) FROM unnest(%s::text[]) AS name WHERE to_regclass(name) IS NULL", list(TABLES)
    )
    return version < FORMAT or missing > 0


def upgrade_tables(store: PostgresqlStore, model: ShapeModel) -> None:
    """Make the tables that are missing, in one transaction.

    Parameters
    ----------
    store : PostgresqlStore
    model : ShapeModel
        Of the library.
    """
    with store.writing():
        for statement in schema_statements(model):
            store.execute(statement)
        store.execute("UPDATE meta SET value = %s WHERE key = 'schema'", str(FORMAT))


def back_up(store: PostgresqlStore, file: Path) -> None:
    """Write a backup of a library with `pg_dump`, for `pg_restore`.

    Parameters
    ----------
    store : PostgresqlStore
    file : Path
        Must not exist.

    Raises
    ------
    LibraryError
        If there is no `pg_dump`, the file exists, or the backup fails.
    """
    command = shutil.which("pg_dump")
    if command is None:
        raise LibraryError(
            f"'{store.name}' was not changed: a backup needs pg_dump, which is not on this computer; make "
            "one elsewhere and run the same with --no-backup"
        )
    if file.exists():
        raise LibraryError(f"'{file}' exists already; move it away, or name another file with --backup")
    parameters = dict(store.address.parameters)
    # Not as an argument, which other users of this computer can see.
    password = parameters.pop("password", None)
    environment = os.environ | ({} if password is None else {"PGPASSWORD": password})
    schema = '"' + store.address.schema.replace('"', '""') + '"'
    options = [f"--schema={schema}", "--format=custom", f"--file={file}"]
    result = subprocess.run(
        [command, *options, f"--dbname={make_conninfo(**parameters)}"],
        env=environment,
        check=False,
        capture_output=True,
        text=True,
        errors="replace",
    )
    if result.returncode != 0:
        file.unlink(missing_ok=True)
        reason = next(iter(reversed(result.stderr.strip().splitlines())), "it ended without a reason")
        raise LibraryError(f"'{store.name}' was not changed: its backup failed: {reason}")
