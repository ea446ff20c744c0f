# SPDX-License-Identifier: MIT
"""Other processes: readers beside a writer, two writers, a killed writer, a full disk."""

from __future__ import annotations

import os
import signal
import sqlite3
import subprocess
import sys
import textwrap
import threading
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from shapegoogle_core.errors import LibraryError
from shapegoogle_core.library.library import Library
from shapegoogle_core.library.storage.records import NewShape
from shapegoogle_core.library.storage.sqlite.store import SqliteStore
from shapegoogle_core.model import ShapeModel, ShapeSignature

SignatureMaker = Callable[..., ShapeSignature]

# What a child process knows: the library, and signatures like those of the fixture.
PRELUDE = """
import sys
import numpy as np
from shapegoogle_core.errors import LibraryError
from shapegoogle_core.library.library import Library
from shapegoogle_core.library.storage.records import NewShape
from shapegoogle_core.model import ShapeSignature

path = sys.argv[1]

def make_signature(model, seed):
    bags = np.random.default_rng(seed).dirichlet(np.full(model.bag_size, 0.3)).astype(np.float32) ** 0.5
    return ShapeSignature(bags, model.codes(bags[None])[0], 1.0, 3, 1)
"""


def start(code: str, path: Path) -> subprocess.Popen[str]:
    return subprocess.Popen(
        [sys.executable, "-c", PRELUDE + textwrap.dedent(code), str(path)],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


def end(process: subprocess.Popen[str]) -> str:
    output, errors = process.communicate()
    assert process.returncode == 0, errors
    return output


def check_file(path: Path) -> None:
    connection = sqlite3.connect(path)
    assert connection.execute("PRAGMA integrity_check").fetchall() == [("ok",)]
    assert connection.execute("PRAGMA foreign_key_check").fetchall() == []
    counts = [
        connection.execute(f"SELECT count(*) FROM {table}").fetchone()
        for table in ("shapes", "codes", "bags")
    ]
    assert len(set(counts)) == 1
    connection.close()


@pytest.fixture
def made(path: Path, model: ShapeModel) -> Path:
    with Library.open(path, model):
        return path


@pytest.mark.skipif(os.name == "nt", reason="SIGKILL")
@pytest.mark.parametrize("writes", [1, 7, 20])
def test_a_killed_writer_loses_only_what_was_in_flight(made: Path, writes: int) -> None:
    """Three shapes to a file, killed in the stream: every file that was reported is there as a whole."""
    process = start(
        """
        with Library.open(path) as library:
            number = 0
            while True:
                signature = make_signature(library.model, number)
                shapes = [NewShape(signature, f"{i}", f"{i}", b"p" * 20_000) for i in range(3)]
                library.replace_source(f"{number}.blend", size=1, mtime_ns=1, sha256="ab", shapes=shapes)
                print(number, flush=True)
                number += 1
        """,
        made,
    )
    assert process.stdout is not None
    lines = [process.stdout.readline() for _ in range(writes)]
    process.send_signal(signal.SIGKILL)
    rest = process.stdout.read()  # communicate() would miss lines that readline has buffered already
    _, errors = process.communicate()
    assert all(lines), errors
    reported = len(lines) + len(rest.split())
    with Library.open(made, read_only=True) as library:
        sources = library.sources()
        assert {f"{number}.blend" for number in range(reported)} <= set(sources)
        # The one in flight may have come in before its report did.
        assert len(sources) <= reported + 1
        assert all(source.shape_count == 3 for source in sources.values())
        assert len(library) == 3 * len(sources)
    check_file(made)


@pytest.mark.skipif(os.name == "nt", reason="SIGKILL")
@pytest.mark.parametrize("read_only", [False, True])
def test_a_writer_killed_within_a_transaction_is_undone(
    made: Path, model: ShapeModel, make_signature: SignatureMaker, read_only: bool
) -> None:
    """Killed when half of the transaction lies in the file already: the journal brings the old state back."""
    with Library.open(made) as library:
        library.add_signature(make_signature(1), "old", source="a.blend")
    process = start(
        """
        with Library.open(path) as library:
            def shapes():
                for number in range(10_000):
                    yield NewShape(make_signature(library.model, 0), str(number), thumbnail=b"p" * 100_000)
                    if number == 200:  # 20 MB: far more than SQLite keeps in memory
                        print("half done", flush=True)
                        sys.stdin.read()
            from shapegoogle_core.library.storage.records import SourceRecord
            library._store.replace_source(SourceRecord("a.blend", 1, 1, None, None, 0), shapes())
        """,
        made,
    )
    assert process.stdout is not None
    assert process.stdout.readline() == "half done\n"
    process.kill()
    process.communicate()
    assert Path(f"{made}-journal").stat().st_size > 0
    assert made.stat().st_size > 10_000_000
    with Library.open(made, read_only=read_only) as library:
        assert [match.name for match in library.query(make_signature(1), explain=0)] == ["old"]
        assert [shape.name for shape in library.shapes()] == ["old"]
    check_file(made)
    assert made.stat().st_size < 1_000_000


@pytest.mark.skipif(os.name == "nt", reason="SIGINT of one process only")
def test_ctrl_c_loses_only_what_was_in_flight(made: Path) -> None:
    process = start(
        """
        import signal
        signal.signal(signal.SIGINT, signal.default_int_handler)  # shells start background jobs without it
        done = 0
        try:
            with Library.open(path) as library:
                print("ready", flush=True)
                while True:
                    library.add_signature(make_signature(library.model, done), f"{done}")
                    done += 1
        except KeyboardInterrupt:
            print(done)
        """,
        made,
    )
    assert process.stdout is not None
    process.stdout.readline()
    with Library.open(made, read_only=True) as library:
        while len(library) < 5:
            time.sleep(0.01)
    process.send_signal(signal.SIGINT)
    done = int(end(process))
    with Library.open(made) as library:
        assert len(library) in (done, done + 1)
    check_file(made)


def test_readers_see_whole_files_while_a_writer_writes(made: Path, make_signature: SignatureMaker) -> None:
    writer = start(
        """
        import itertools, threading
        enough = threading.Event()
        threading.Thread(target=lambda: (sys.stdin.read(), enough.set()), daemon=True).start()
        with Library.open(path) as library:
            for round in itertools.count():
                shapes = [
                    NewShape(make_signature(library.model, i), f"{round}", f"{i}", b"p" * 30_000)
                    for i in range(5)
                ]
                library.replace_source("a.blend", size=round, mtime_ns=1, sha256="ab", shapes=shapes)
                if enough.is_set():
                    break
        """,
        made,
    )
    seen: set[str] = set()
    with Library.open(made, read_only=True) as first, Library.open(made, read_only=True) as second:
        while len(seen) < 20 and writer.poll() is None:
            for library, exact in ((first, False), (second, True)):
                names = [match.name for match in library.query(make_signature(2), exact=exact, explain=0)]
                assert len(names) in (0, 5)
                assert len(set(names)) <= 1
                seen |= set(names)
    end(writer)
    assert len(seen) >= 20
    check_file(made)


def test_two_writers_take_turns(made: Path) -> None:
    code = """
        with Library.open(path) as library:
            for number in range(15):
                library.add_signature(make_signature(library.model, number), f"{number}", source=sys.argv[1])
    """
    for writer in [start(code, made), start(code, made)]:
        end(writer)
    with Library.open(made) as library:
        assert len(library) == 15
    check_file(made)


def test_two_makers_of_one_library_agree(
    path: Path, model: ShapeModel, make_signature: SignatureMaker
) -> None:
    """Both find no file; one makes the tables, the other finds them made."""
    errors: list[BaseException] = []
    barrier = threading.Barrier(2)

    def make(seed: int) -> None:
        try:
            barrier.wait()
            with Library.open(path, model) as library:
                library.add_signature(make_signature(seed), f"{seed}")
        except BaseException as error:
            errors.append(error)

    threads = [threading.Thread(target=make, args=(seed,)) for seed in (1, 2)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert errors == []
    with Library.open(path) as library:
        assert sorted(shape.name for shape in library.shapes()) == ["1", "2"]


def test_a_writer_that_waits_too_long_says_so(made: Path, make_signature: SignatureMaker) -> None:
    holder = sqlite3.connect(made, isolation_level=None)
    holder.execute("BEGIN IMMEDIATE")
    with Library.open(made, timeout=0.1) as library:
        assert len(library) == 0  # reading goes on
        with pytest.raises(
            LibraryError, match=r"shapes\.sglib' is in use by another program .*waited 0\.1 s"
        ):
            library.add_signature(make_signature(1), "one")
        holder.execute("ROLLBACK")
        library.add_signature(make_signature(1), "one")
        assert len(library) == 1
    holder.close()


def test_a_reader_that_waits_too_long_says_so(made: Path, make_signature: SignatureMaker) -> None:
    holder = sqlite3.connect(made, isolation_level=None)
    holder.execute("BEGIN EXCLUSIVE")
    with pytest.raises(LibraryError, match="is in use by another program"):
        Library.open(made, read_only=True, timeout=0.1)
    holder.close()


def test_another_thread_is_told_to_open_its_own(made: Path) -> None:
    messages = []

    def use(library: Library) -> None:
        try:
            len(library)
        except LibraryError as error:
            messages.append(str(error))

    with Library.open(made) as library:
        thread = threading.Thread(target=use, args=(library,))
        thread.start()
        thread.join()
    assert len(messages) == 1
    assert "open the library again in each thread" in messages[0]


def test_a_full_disk_keeps_what_was_added(made: Path, make_signature: SignatureMaker) -> None:
    with Library.open(made) as library:
        store = library._store
        assert isinstance(store, SqliteStore)
        pages = store.value("PRAGMA page_count")
        store.value(f"PRAGMA max_page_count = {pages + 40}")
        added, message = 0, ""
        while not message:
            try:
                library.add_signature(make_signature(added), f"{added}", thumbnail=b"p" * 20_000)
                added += 1
            except LibraryError as error:
                message = str(error)
        assert "the disk is full; make room" in message
        assert 0 < added == len(library)
        assert library.query(make_signature(0), top=1, explain=0)[0].name == "0"
        # Room again: the same object goes on.
        store.value("PRAGMA max_page_count = 1000000")
        library.add_signature(make_signature(added), "one more")
    with Library.open(made) as library:
        assert len(library) == added + 1
    check_file(made)


LIMITED = """
    import resource
    limit = int(sys.argv[2])
    resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))
    added = 0
    with Library.open(path) as library:
        try:
            while True:
                signature = make_signature(library.model, added)
                library.add_signature(signature, f"{added}", thumbnail=b"p" * 20_000)
                added += 1
        except LibraryError as error:
            assert "make room" in str(error) and "safe" in str(error), error
        assert len(library) == added
    print(added)
"""


@pytest.mark.skipif(os.name == "nt", reason="no limit on the size of files")
def test_the_operating_system_refuses_to_write_more(made: Path, make_signature: SignatureMaker) -> None:
    """The write itself fails, as on a full disk or at a quota."""
    process = subprocess.run(
        [
            sys.executable,
            "-c",
            PRELUDE + textwrap.dedent(LIMITED),
            str(made),
            str(made.stat().st_size + 300_000),
        ],
        capture_output=True,
        text=True,
    )
    assert process.returncode == 0, process.stderr
    added = int(process.stdout)
    assert 3 <= added <= 15
    with Library.open(made) as library:
        assert len(library) == added
        assert library.query(make_signature(2), top=1, explain=0)[0].name == "2"
        library.replace_source(
            "b", size=1, mtime_ns=1, sha256="ab", shapes=[NewShape(make_signature(50), "more")]
        )
    check_file(made)


@pytest.mark.skipif(os.name == "nt", reason="no limit on the size of files")
def test_no_room_to_make_a_library(path: Path, model: ShapeModel, tmp_path: Path) -> None:
    model.save(tmp_path / "model.npz")
    code = """
        import resource
        from pathlib import Path
        from shapegoogle_core.model import ShapeModel
        model = ShapeModel.from_bytes(Path(sys.argv[2]).read_bytes())
        resource.setrlimit(resource.RLIMIT_FSIZE, (1000, 1000))
        try:
            Library.open(path, model)
        except LibraryError as error:
            print(error)
    """
    process = subprocess.run(
        [sys.executable, "-c", PRELUDE + textwrap.dedent(code), str(path), str(tmp_path / "model.npz")],
        capture_output=True,
        text=True,
    )
    assert process.returncode == 0, process.stderr
    assert "make room" in process.stdout
    with Library.open(path, model) as library:  # whatever was left there does not stand in the way
        assert len(library) == 0
