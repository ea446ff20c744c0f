# SPDX-License-Identifier: MIT
"""A real Blender in a window of its own on a screen that nobody sees, with a pointer that really clicks.

How is known where a button is? Blender does not say. So the pointer wanders down the sidebar, and at every
step Blender is asked what the button under it does: Copy Python Command and Copy Data Path of the menu that
every button has. Headers of panels have no such menu, but closed ones are one height apart, from the top.
"""

from __future__ import annotations

import json
import os
import select
import subprocess
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from itertools import count
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

ROOT = Path(__file__).resolve().parents[2]
SIZE = 1280, 800
# The panels from top to bottom, each with the first of its buttons.
PANELS = {
    "Library": "shape_google.choose_library",
    "Search": "shape_google.find_similar",
    "Signature": "shape_google_painting.kind",
    "Duplicates": "shape_google_duplicates.scope",
    "New Objects": "shape_google.check",
    "Decisions": "decision",
}
# In pixels, at a scale of the interface of 1: the middle of the first header below the top of the sidebar,
# the first button below a header's middle, the height of a closed panel with its gap, the tabs at the right,
# and steps down the sidebar that no button slips through.
FIRST_HEADER, FIRST_BUTTON, HEADER, TABS, STEP = 16, 32, 28, 20, 14
# Where in the width of the sidebar buttons are: in its left and right half, or the small ones of a row.
HALVES, FIRST, LAST = (0.25, 0.75), (0.12,), (0.9,)
# Pixels from one place to the next where a small button beside another one is looked for, and an entry of a
# menu, to the right of where the menu was opened.
SIDESTEP, MENU_STEP, MENU_INDENT = 6, 10, 30
# Seconds until Blender has copied what an entry of a menu does: first as on a quick machine, then patiently.
PAUSES = 0.05, 0.4
# Seconds: for anything at all on a slow machine; between two pictures of a window that is still changing.
LIMIT, STILL = 600.0, 1.0
# Before a click, as a person hesitates: Blender must have seen the pointer come before the button goes down.
HESITATION = 0.5


class Window:
    """A Blender with a window, and what a person does with it.

    Parameters
    ----------
    process : Popen
    display : str
        Of the screen, such as ":99".
    requests : Path
        The folder that `driver.py` watches.
    """

    def __init__(self, process: subprocess.Popen[bytes], display: str, requests: Path) -> None:
        self.process, self._requests = process, requests
        self._environment = {**os.environ, "DISPLAY": display}
        self._numbers = count()
        self._panel = ""
        self._places: dict[tuple[object, ...], tuple[float, float]] = {}
        # Every button that the pointer came past: by panel, scrolling, column and height.
        self._seen: dict[tuple[str, float, float, int], str] = {}

    def ask(self, function: str, *arguments: Any) -> Any:
        """Call a function of `driver.py` inside Blender."""
        path = self._requests / f"{next(self._numbers):06}.request"
        written = path.with_suffix(".part")
        written.write_text(json.dumps([function, arguments]))
        written.rename(path)
        answer = path.with_suffix(".answer")
        end = time.monotonic() + LIMIT
        while not answer.exists():
            assert self.process.poll() is None, f"Blender ended with exit code {self.process.returncode}"
            assert time.monotonic() < end, f"Blender does not answer {function}{arguments}"
            time.sleep(0.01)
        content = json.loads(answer.read_text())
        answer.unlink()
        assert "error" not in content, content["error"]
        return content["result"]

    def run(self, code: str) -> Any:
        """Run code inside Blender, for what no click is needed; `result` is returned."""
        return self.ask("run", code)

    def wait(self, condition: Callable[[dict[str, Any]], object], what: str) -> dict[str, Any]:
        """Wait until the state of the add-on and the scene is as it should become."""
        end = time.monotonic() + LIMIT
        state: dict[str, Any]
        while not condition(state := self.ask("state")):
            assert time.monotonic() < end, f"not within {LIMIT:.0f} s: {what}\n{json.dumps(state, indent=1)}"
            time.sleep(0.05)
        return state

    def wait_for_kinds(self) -> dict[str, Any]:
        """Wait for the answer to a query, until every match has been compared."""
        self.wait(lambda state: state["matches"] and not state["session"]["searching"], "an answer")
        return self.wait(
            lambda state: all("Comparing" not in match["kind"] for match in state["matches"]),
            "kinds of matches",
        )

    # -- pointer and keys

    def tool(self, *words: object) -> None:
        """Call xdotool."""
        subprocess.run(["xdotool", *map(str, words)], env=self._environment, check=True, timeout=60)

    def move(self, x: float, y: float) -> None:
        """Put the pointer somewhere, and wait until Blender has noticed."""
        place = [round(x), round(y)]
        self.tool("mousemove", *place)
        end = time.monotonic() + LIMIT
        while (seen := self.ask("pointer")) != place:
            assert time.monotonic() < end, f"the pointer is at {place}, and for Blender at {seen}"
            time.sleep(0.01)

    def click(self, x: float, y: float, *, key: str = "") -> None:
        """Click somewhere, perhaps with a key held down."""
        self.move(x, y)
        time.sleep(HESITATION)
        held = (["keydown", key], ["keyup", key]) if key else ([], [])
        self.tool(*held[0], "click", 1, *held[1])

    def drag(self, x: float, y: float, dx: float, dy: float, *, button: int = 1) -> None:
        """Drag with a button of the mouse held down, in steps as a hand does."""
        self.move(x, y)
        time.sleep(HESITATION)
        self.tool("mousedown", button)
        # A busy Blender takes the button to go down where the pointer is by then: wait until it has seen it.
        for _ in range(2):
            self.ask("regions")
        for step in range(1, 9):
            # While a slider is dragged, Blender keeps the pointer in one place.
            self.tool("mousemove", round(x + dx * step / 8), round(y + dy * step / 8))
            time.sleep(0.07)
        self.tool("mouseup", button)

    def undo(self) -> None:
        """Press Ctrl-Z above the 3D view."""
        left, top, right, bottom = self.ask("regions")["window"]
        self.move(left + 0.3 * (right - left), (top + bottom) / 2)
        time.sleep(0.3)
        self.tool("key", "ctrl+z")

    def redo(self) -> None:
        """Press Shift-Ctrl-Z, where `undo` was."""
        self.tool("key", "ctrl+shift+z")

    def rest(self) -> None:
        """Take the pointer to where it is above nothing."""
        self.move(SIZE[0] * 0.35, SIZE[1] - 10)

    # -- the sidebar

    def open(self, panel: str) -> None:
        """Open one panel of the tab by clicking headers, and close all others."""
        left, top, right, _ = self.ask("regions")["ui"]
        x, first = left + (right - left) / 4, top + FIRST_HEADER
        header = first + HEADER * list(PANELS).index(panel)
        for _ in range(4):  # a click that came while Blender was busy may have been for nothing
            # On a header: where the sidebar is empty, the wheel is for the 3D view behind it.
            self.move(x, first)
            self.tool("click", "--repeat", 40, "--delay", 5, 4)
            self.settle()
            if panel == self._panel and PANELS[panel] in self._button_at(x, header + FIRST_BUTTON):
                return
            self.click(x, first, key="ctrl")  # closes all others; itself it opens or closes
            self.settle()
            if PANELS["Library"] in self._button_at(x, first + FIRST_BUTTON):
                self.click(x, first)
                self.settle()
            self.click(x, header)
            self.settle()
            self._panel = panel
            if PANELS[panel] in self._button_at(x, header + FIRST_BUTTON):
                return
        raise AssertionError(f"the panel {panel} cannot be opened")

    def settle(self) -> None:
        """Wait until Blender has drawn what was clicked."""
        time.sleep(0.4)
        self.ask("regions")

    def _button_at(self, x: float, y: float) -> str:
        self.move(x, y)
        return self.ask("button") or ""

    def find(
        self, action: str, *, occurrence: int = 0, columns: Sequence[float] = HALVES
    ) -> tuple[float, float]:
        """Find a button by what it does, scrolling down if need be.

        Parameters
        ----------
        action : str
            Part of what Copy Python Command or Copy Data Path gives.
        occurrence : int
            How many such buttons to pass over.
        columns : sequence of float
            Where to look, as shares of the width, one after the other.

        Returns
        -------
        x, y : float
            On the button, where the pointer is.
        """
        # Nothing in a panel moves, so a button is looked for where it was, or where the pointer came past it.
        known = self._panel, self.ask("scrolled"), action, occurrence, tuple(columns)
        place = self._places.get(known) or (self._passed(action, columns) if occurrence == 0 else None)
        if place is not None and (place := self._confirmed(action, place[0], (place[1], place[1] - STEP))):
            self._places[known] = place
            return place
        others: dict[str, None] = {}
        wrapped = False
        while True:
            left, top, right, bottom = self.ask("regions")["ui"]
            seen, scrolled = 0, self.ask("scrolled")
            places = [(share, y) for share in columns for y in range(top + 8, bottom - 4, STEP)]
            if occurrence == 0:
                # First where the pointer has not been yet.
                places.sort(key=lambda place: (self._panel, scrolled, *place) in self._seen)
            before: tuple[str, float] | None = None
            for share, y in places:
                x = left + share * (right - TABS - left)
                button = self._button_at(x, y)
                others[f"{button} at {x:.0f}, {y}"] = None
                self._seen[self._panel, scrolled, share, y] = button
                if action in button and (button, share) != before:
                    # A slow Blender may have answered for the place before.
                    place = self._confirmed(action, x, (y, y - STEP))
                    if place is not None:
                        if seen == occurrence:
                            known = self._panel, self.ask("scrolled"), action, occurrence, tuple(columns)
                            self._places[known] = place
                            return place
                        seen += 1
                before = button, share
            self._scroll(x, 5, 12)
            if self.ask("scrolled") == scrolled:
                # At the end: it may be above where the search began.
                assert not wrapped, f"nothing does {action!r}: {', '.join(others)}"
                wrapped = True
                self._scroll(x, 4, 40)

    def _scroll(self, x: float, button: int, times: int) -> None:
        """Turn the wheel above the first header: up (button 4) or down (5)."""
        self.move(x, self.ask("regions")["ui"][1] + FIRST_HEADER)
        self.tool("click", "--repeat", times, "--delay", 10, button)
        self.settle()

    def _passed(self, action: str, columns: Sequence[float]) -> tuple[float, float] | None:
        """Find out where the pointer once came past a button, without moving it."""
        left, _, right, _ = self.ask("regions")["ui"]
        scrolled = self.ask("scrolled")
        for share in columns:
            for (panel, offset, column, y), button in self._seen.items():
                if (panel, offset, column) == (self._panel, scrolled, share) and action in button:
                    return left + share * (right - TABS - left), y
        return None

    def _confirmed(self, action: str, x: float, heights: Sequence[float]) -> tuple[float, float] | None:
        """Find out with patience at which of some places a button is; the pointer stays there."""
        for y in heights:
            self.move(x, y)
            time.sleep(0.3)
            if action in (self.ask("button") or ""):
                return x, y
        return None

    def press(
        self, action: str, *, occurrence: int = 0, columns: Sequence[float] = HALVES
    ) -> tuple[float, float]:
        """Click a button that is found by what it does; where it was."""
        x, y = self.find(action, occurrence=occurrence, columns=columns)
        self.click(x, y)
        return x, y

    def press_beside(self, neighbor: str, action: str) -> None:
        """Click a small button on the right of another one, wherever the texts of both have put it."""
        x, y = self.find(neighbor)
        right = self.ask("regions")["ui"][2] - TABS
        seen = ""
        while action not in seen:
            assert x < right, f"nothing on the right of {neighbor} does {action}"
            x += SIDESTEP
            seen = self._button_at(x, y)
        self.click(x, y)

    # -- menus

    def choose(self, action: str) -> None:
        """Click an entry of the menu that is open at the pointer, found by what Ctrl-C copies of it."""
        x, y = self.ask("pointer")
        seen: list[str] = []
        for pause in PAUSES:
            for place in [*range(y, SIZE[1], MENU_STEP), *range(y, 0, -MENU_STEP)]:
                self.move(x + MENU_INDENT, place)
                self.ask("empty_clipboard")
                self.tool("key", "ctrl+c")
                time.sleep(pause)
                copied = self.ask("clipboard")
                if action in copied:
                    self.click(x + MENU_INDENT, place)
                    return
                seen.append(f"{copied.strip()} at {place}")
        raise AssertionError(f"no entry does {action!r}: {', '.join(seen)}")

    # -- pictures

    def picture(self, part: str | tuple[int, int, int, int] = "") -> Image.Image:
        """Photograph the window once it has stopped changing.

        Parameters
        ----------
        part : str or (left, top, right, bottom)
            A region, such as "ui", the sidebar; none: all.
        """
        self.rest()
        end = time.monotonic() + LIMIT
        before, image = None, self._photograph()
        while before is None or before.tobytes() != image.tobytes():
            assert time.monotonic() < end, "the window never stops changing"
            time.sleep(STILL)
            before, image = image, self._photograph()
        return self._crop(image, part)

    def photograph(self, part: str | tuple[int, int, int, int] = "") -> Image.Image:
        """Photograph the window, or a region of it, as it is now."""
        return self._crop(self._photograph(), part)

    def _crop(self, image: Image.Image, part: str | tuple[int, int, int, int]) -> Image.Image:
        return image.crop(self.ask("regions")[part] if isinstance(part, str) else part) if part else image

    def _photograph(self) -> Image.Image:
        command = ["import", "-silent", "-window", "root", "-depth", "8", "rgb:-"]
        result = subprocess.run(
            command, env=self._environment, stdout=subprocess.PIPE, check=True, timeout=60
        )
        image = Image.frombytes("RGB", SIZE, result.stdout)
        # To look at where a test fails.
        image.save(self._requests.parent / f"picture-{next(self._numbers):06}.png", compress_level=1)
        return image

    def clean_scene(self, query: Path, name: str) -> None:
        """Start with nothing but the query, selected and in view."""
        self.ask("empty_scene")
        self.ask("add_object", str(query), name)
        self.ask("look")


def colorful(image: Image.Image) -> float:
    """Share of the pixels of a picture that have a decided colour."""
    pixels = np.asarray(image, np.int16)
    return float(((pixels.max(-1) - pixels.min(-1)) > 60).mean())


@contextmanager
def screen(log: Path) -> Iterator[str]:
    """Start a screen that exists only in memory; its name, such as ":99"."""
    reading, writing = os.pipe()
    depth = "x".join(map(str, (*SIZE, 24)))
    options = ["-screen", "0", depth, "+extension", "GLX", "-nolisten", "tcp"]
    with log.open("wb") as output:
        server = subprocess.Popen(
            ["Xvfb", "-displayfd", str(writing), *options],
            pass_fds=[writing],
            stdout=output,
            stderr=output,
        )
    os.close(writing)
    try:
        ready, _, _ = select.select([reading], [], [], LIMIT)
        number = os.read(reading, 16).decode().strip() if ready else ""
        assert number, f"Xvfb does not start: {log.read_text(errors='replace')}"
        yield f":{number}"
    finally:
        os.close(reading)
        server.terminate()
        server.wait(LIMIT)
