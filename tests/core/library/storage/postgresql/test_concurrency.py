# SPDX-License-Identifier: MIT
"""Several programs on one database: writers and readers at once, killed writers, a lost server."""

from __future__ import annotations

import signal
import subprocess
import sys
import textwrap
from collections.abc import Callable, Iterator
from contextlib import closing

import psycopg
import pytest

from shapegoogle_core.errors import LibraryError
from shapegoogle_core.library.library import Library
from shapegoogle_core.library.storage.opening import connect
from shapegoogle_core.library.storage.records import NewShape
from shapegoogle_core.model import ShapeModel, ShapeSignature
from tests.core.postgresql_server import PostgresqlServer, new_server, system_programs

SignatureMaker = Callable[..., ShapeSignature]

# What a child process knows: the library, and signatures like those of the fixture.
PRELUDE = """
import sys
import threading
import time
import numpy as np
from shapegoogle_core.library.library import Library
from shapegoogle_core.library.storage.records import NewShape
from shapegoogle_core.model import ShapeSignature

url, number = sys.argv[1], int(sys.argv[2])

def make_signature(model, seed):
    bags = np.random.default_rng(seed).dirichlet(np.full(model.bag_size, 0.3)).astype(np.float32) ** 0.5
    return ShapeSignature(bags, model.codes(bags[None])[0], 1.0, 3, 1)

def write(library, name, seed):
    shapes = [NewShape(make_signature(library.model, 3 * seed + i), f"{name} {i}", f"{i}") for i in range(3)]
    return library.replace_source(name, size=1, mtime_ns=1, sha256="ab", shapes=shapes, claim=True)
"""


def start(code: str, url: str, number: int = 0) -> subprocess.Popen[str]:
    return subprocess.Popen(
        [sys.executable, "-c", PRELUDE + textwrap.dedent(code), url, str(number)],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


def end(process: subprocess.Popen[str]) -> str:
    output, errors = process.communicate()
    assert process.returncode == 0, errors
    return output


@pytest.fixture
def made(postgresql_url: str, model: ShapeModel) -> str:
    Library.open(postgresql_url, model).close()
    return postgresql_url


def check_whole(url: str) -> dict[str, list[int]]:
    """Every source has its three shapes, each with a code and bags, and none is there twice."""
    by_source: dict[str, list[int]] = {}
    with Library.open(url, read_only=True) as library:
        for shape in library.shapes():
            by_source.setdefault(shape.source, []).append(shape.shape_id)
        assert set(by_source) == set(library.sources())
        assert all(len(ids) == 3 for ids in by_source.values())
        for ids in by_source.values():
            assert library.signature(ids[0]).bags.size == library.model.bag_size
    with closing(connect(url, read_only=True, timeout=5)) as store:
        counts = {store.value(f"SELECT count(*) FROM {table}") for table in ("shapes", "codes", "bags")}
        assert counts == {3 * len(by_source)}
    return by_source


def test_a_killed_writer_loses_only_what_was_in_flight(made: str) -> None:
    process = start(
        """
        with Library.open(url) as library:
            for number in range(100_000):
                write(library, f"{number}.blend", number)
                print(number, flush=True)
        """,
        made,
    )
    assert process.stdout is not None
    assert [process.stdout.readline() for _ in range(5)] == [f"{number}\n" for number in range(5)]
    process.send_signal(signal.SIGKILL)
    reported = 5 + len(process.stdout.read().split())
    process.communicate()
    sources = check_whole(made)
    assert {f"{number}.blend" for number in range(reported)} <= set(sources)
    assert len(sources) <= reported + 1
    # Running the same again stores nothing twice, and moves nothing that was there.
    again = start(
        """
        with Library.open(url) as library:
            for number in range(8):
                write(library, f"{number}.blend", number)
        """,
        made,
    )
    end(again)
    after = check_whole(made)
    assert {name: after[name] for name in sources} == sources


WRITER = """
with Library.open(url) as library:
    for round in range(5):
        # Half of the files are those of all writers at once, half are its own.
        write(library, f"shared {round}.blend", round)
        write(library, f"own {number} {round}.blend", 100 * number + round)
"""

READER = """
with Library.open(url, read_only=True) as library:
    # The end of the input is the end of the writers.
    ended = threading.Event()
    threading.Thread(target=lambda: (sys.stdin.read(), ended.set()), daemon=True).start()
    seen = 0
    while not ended.is_set():
        matches = library.query(make_signature(library.model, 0), top=1000, explain=0)
        # What a search has found once stays, and the index in memory misses nothing that came in between.
        assert len(matches) >= seen, (len(matches), seen)
        seen = len(matches)
        time.sleep(0.05)
    count = len(library)
    matches = library.query(make_signature(library.model, 0), top=1000, explain=0)
    assert len(matches) == count, (len(matches), count)
    print(count)
"""


@pytest.mark.parametrize(
    ("writers", "readers"), [(2, 1), pytest.param(8, 8, marks=pytest.mark.long)], ids=["few", "many"]
)
def test_writers_and_readers_at_once(made: str, writers: int, readers: int) -> None:
    reading = [start(READER, made) for _ in range(readers)]
    writing = [start(WRITER, made, number) for number in range(writers)]
    for process in writing:
        end(process)
    sources = check_whole(made)
    assert len(sources) == 5 + 5 * writers
    for process in reading:
        output, errors = process.communicate()
        assert process.returncode == 0, errors
        assert int(output) == 3 * len(sources)


def test_a_lost_server_is_one_sentence_and_the_library_goes_on_when_it_is_back(
    own_server: PostgresqlServer, model: ShapeModel, make_signature: SignatureMaker
) -> None:
    url = own_server.new_url()
    with Library.open(url, model) as library:
        library.add_signature(make_signature(1), "before")
        own_server.kill()
        with pytest.raises(LibraryError, match=r"lost its connection; check the network .* is safe\)"):
            library.add_signature(make_signature(2), "lost")
        with pytest.raises(LibraryError, match="cannot be opened: no server answers there"):
            library.add_signature(make_signature(2), "lost")
        own_server.start()
        library.add_signature(make_signature(3), "after")
        assert [shape.name for shape in library.shapes()] == ["before", "after"]
        found = library.query(make_signature(3), top=5, explain=0)
        assert {match.name for match in found} == {"before", "after"}


@pytest.fixture(scope="module")
def own_server() -> Iterator[PostgresqlServer]:
    """A server that a test may end."""
    yield from new_server(system_programs())


def test_a_writer_waits_for_another_one_and_says_so(
    made: str, model: ShapeModel, make_signature: SignatureMaker
) -> None:
    with closing(connect(made, read_only=False, timeout=5)) as other, other.writing():
        with (
            Library.open(made, timeout=0.2) as library,
            pytest.raises(LibraryError, match=r"in use by another program .*waited 0\.2 s"),
        ):
            library.add_signature(make_signature(1), "late")
        with Library.open(made, read_only=True) as library:  # readers do not wait
            assert len(library) == 0


class TestRoles:
    @pytest.fixture
    def roles(self, postgresql: PostgresqlServer, made: str) -> Iterator[dict[str, str]]:
        """Addresses of the library for a reader and a writer."""
        with psycopg.connect(postgresql.url("postgres"), autocommit=True) as connection:
            for role in ("artist", "farm", "stranger"):
                connection.execute(f"DROP ROLE IF EXISTS {role}".encode())
                connection.execute(f"CREATE ROLE {role} LOGIN PASSWORD 'geheim'".encode())
        yield {role: made.replace("owner@", f"{role}:geheim@") for role in ("artist", "farm", "stranger")}
        with psycopg.connect(postgresql.url("shapes"), autocommit=True) as connection:
            for role in ("artist", "farm", "stranger"):
                connection.execute(f"DROP OWNED BY {role}".encode())

    def test_roles(
        self,
        made: str,
        roles: dict[str, str],
        make_signature: SignatureMaker,
        capsys: pytest.CaptureFixture[str],
    ) -> None:
        from shapegoogle_core.cli.parser import main

        assert main(["database", "--library", made, "--reader", "artist", "--writer", "farm"]) == 0
        assert "artist: may search" in capsys.readouterr().out
        with Library.open(roles["farm"]) as library:
            library.add_signature(make_signature(1), "one")
            library.replace_source(
                "a", size=1, mtime_ns=1, sha256="a", shapes=[NewShape(make_signature(2), "two")]
            )
            assert library.remove("a")
            assert not library.read_only
        for read_only in (True, False):
            with Library.open(roles["artist"], read_only=read_only) as library:
                assert library.read_only
                assert [match.name for match in library.query(make_signature(1), explain=0)] == ["one"]
                assert library.info()["shapes"] == 1
                with pytest.raises(LibraryError, match=r"read_only=True|not changed, by your role"):
                    library.add_signature(make_signature(2), "two")
        with pytest.raises(LibraryError) as stranger:
            Library.open(roles["stranger"])
        assert "geheim" not in str(stranger.value)
        assert main(["info", "--library", roles["artist"]]) == 0
        assert "geheim" not in capsys.readouterr().out

    def test_statements_can_be_shown_first(self, made: str, capsys: pytest.CaptureFixture[str]) -> None:
        from shapegoogle_core.cli.parser import main

        assert main(["database", "--library", made, "--reader", 'Ana "x"', "--sql"]) == 0
        assert 'TO "Ana ""x""";' in capsys.readouterr().out
        assert main(["database", "--library", "shapes.sglib", "--reader", "a"]) == 2
        assert main(["database", "--library", made]) == 2
