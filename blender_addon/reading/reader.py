# SPDX-License-Identifier: GPL-3.0-or-later
"""A Blender that reads .blend files and what it imports for the worker processes of the core.

Run as a script, by `blender -b -P reader.py` or by a Python that has bpy; it answers the requests described
in `shapegoogle_core.indexing.reading.external_reader`. It imports nothing but bpy and its neighbours, since a
Blender started with factory settings has neither this add-on nor its wheels. Scripts inside the files never
run, and the files are only read.
"""

from __future__ import annotations

import ctypes
import importlib
import importlib.util
import json
import os
import signal
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import bpy
from bpy.app.handlers import persistent

__all__ = ["main"]

# As in shapegoogle_core.processes.messages, which cannot be imported here.
MESSAGES = "SHAPEGOOGLE_MESSAGES"
# Blender's z.
UP_AXIS = 2
# Name under which the package of this script is imported.
PACKAGE = "shapegoogle_reading"
# Option of Linux's prctl for the signal that a process gets when its parent ends.
PR_SET_PDEATHSIG = 1
# Seconds before the first word on how far a file has been read, and between two.
SECONDS_BEFORE_REPORTS, SECONDS_BETWEEN_REPORTS = 1.0, 0.5


def main() -> None:
    """Answer one request after the other until the input is closed."""
    _end_with_parent()
    answers = _message_pipe()
    _reply(answers, {"ready": True})
    limited = False
    # In binary, since the encoding of text differs under Windows and in the C locale.
    for line in sys.stdin.buffer:
        request = json.loads(line)
        if not limited and request.get("memory_limit") is not None:
            _limit_memory(request["memory_limit"])
            limited = True
        try:
            answer = read(request, _reporter(answers))
        except (RuntimeError, OSError, ValueError) as error:
            answer = {"error": _reason(request["path"], error)}
        except MemoryError:
            limit = request["memory_limit"]
            reason = f"needs more than {limit} MB of memory; simplify it or raise the memory limit"
            answer = {"error": f"{Path(request['path']).name!r} {reason}"}
        _reply(answers, answer)


def _message_pipe() -> int:
    """File descriptor for answers: Blender and other libraries print on the standard streams, from C too."""
    number = int(os.environ.pop(MESSAGES))
    if sys.platform == "win32":
        import msvcrt

        number = msvcrt.open_osfhandle(number, os.O_WRONLY)
    os.set_inheritable(number, False)
    return number


def _reply(answers: int, answer: dict[str, Any]) -> None:
    """Send an answer as one line; in ASCII, so that no name can break it."""
    rest = memoryview(json.dumps(answer).encode("ascii") + b"\n")
    while rest:
        rest = rest[os.write(answers, rest) :]


def _reporter(answers: int) -> Callable[[int, int], None]:
    """Make a function that says how far a file has been read, unless that is done at once."""
    next_time = time.monotonic() + SECONDS_BEFORE_REPORTS

    def report(done: int, total: int) -> None:
        nonlocal next_time
        if time.monotonic() >= next_time:
            next_time = time.monotonic() + SECONDS_BETWEEN_REPORTS
            _reply(answers, {"progress": [done, total]})

    return report


def _end_with_parent() -> None:
    """Have Linux end this process when its parent ends, even if the parent is killed and Blender is busy.

    On other systems it ends when it next reads its input, which is closed then, but not while Blender hangs
    over a file: no other thread of Python runs during a call into Blender.
    """
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGKILL, 0, 0, 0)


def _limit_memory(megabytes: int) -> None:
    """Limit the memory that this process may use on top of what it holds now; on Linux only."""
    if sys.platform == "linux":
        import resource

        pages = int(Path("/proc/self/statm").read_text().split()[0])
        limit = pages * resource.getpagesize() + megabytes * 2**20
        _, hard = resource.getrlimit(resource.RLIMIT_AS)
        if hard == resource.RLIM_INFINITY or limit < hard:
            resource.setrlimit(resource.RLIMIT_AS, (limit, hard))


def read(
    request: dict[str, Any], progress: Callable[[int, int], None] = lambda _done, _total: None
) -> dict[str, Any]:
    """Open a file and write its shapes.

    Parameters
    ----------
    request : dict
        "path", "output" and "objects": "all", or "assets" for only those marked as assets where there are
        any; "frames": numbers separated by commas, or empty for the current frame.
    progress : callable, optional
        Called now and then with the number of objects that have been read, and that of all.

    Returns
    -------
    answer : dict
        See `shapegoogle_core.indexing.reading.external_reader`.

    Raises
    ------
    RuntimeError
        If Blender cannot open the file.
    """
    path = Path(request["path"])
    is_blend = path.suffix.lower() == ".blend"
    if is_blend:
        _open(path)
    else:
        _neighbour("importers").import_file(path)
    frames = [int(frame) for frame in request.get("frames", "").split(",") if frame]
    with Path(request["output"]).open("wb") as output:
        contents = _neighbour("contents").read_contents(
            path,
            output,
            assets_only=request.get("objects") == "assets",
            frames=frames if is_blend else (),
            progress=progress,
        )
    if not is_blend:
        # Wholes repeat the meshes that they consist of.
        contents["shapes"] = [shape for shape in contents["shapes"] if len(shape["parts"]) == 1]
    # Like the other files for exchange, an imported one is one shape; a .blend is one for each object.
    return {**contents, "joined": not is_blend, "up_axis": UP_AXIS}


def _open(path: Path) -> None:
    """Open a .blend file without computing all of its scene, which may need more memory than there is."""
    handlers = bpy.app.handlers.load_post
    handlers.append(_leave_scene)
    try:
        bpy.ops.wm.open_mainfile(filepath=str(path), load_ui=False, use_scripts=False)
    finally:
        handlers.remove(_leave_scene)


@persistent
def _leave_scene(*_arguments: object) -> None:
    """Show an empty scene at the same frame: Blender computes what its windows show once this is done."""
    for window in bpy.context.window_manager.windows:
        frame = window.scene.frame_current
        window.scene = bpy.data.scenes.new("Shape Google")
        window.scene.frame_current = frame


def _neighbour(name: str) -> Any:
    """Import a module of the package that this script lies in; it is in none when it runs."""
    if PACKAGE not in sys.modules:
        folder = Path(__file__).parent
        spec = importlib.util.spec_from_file_location(
            PACKAGE, folder / "__init__.py", submodule_search_locations=[str(folder)]
        )
        assert spec is not None and spec.loader is not None  # noqa: PT018 - the path ends with .py
        sys.modules[PACKAGE] = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(sys.modules[PACKAGE])
    return importlib.import_module(f"{PACKAGE}.{name}")


def _reason(path: str, error: Exception) -> str:
    """Summarise Blender's report in one sentence."""
    name = Path(path).name
    if Path(path).stat().st_size == 0:
        return f"{name!r} cannot be opened by Blender: it is empty (0 bytes); copy or save it again"
    lines = [line.strip() for line in str(error).splitlines() if line.strip()]
    text = "; ".join(line.removeprefix("Error: ") for line in lines)
    if isinstance(error, OSError):
        text = error.strerror or ""
    elif not text or "Traceback (most recent call last)" in text:
        text = "its importer fails"
    # Blender repeats the whole path, which the user sees elsewhere.
    text = text.replace(path, name).rstrip(".")
    return (
        f"{name!r} cannot be opened by Blender: {text}; it is damaged or another kind of file: save it again"
    )


if __name__ == "__main__":
    main()
