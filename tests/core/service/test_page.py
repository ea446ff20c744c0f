# SPDX-License-Identifier: MIT
"""The web page in a real browser: searching, comparing, turning, deciding."""

from __future__ import annotations

import re
import shutil
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
import trimesh
from playwright.sync_api import Browser, Page, Route, expect, sync_playwright

from shapegoogle_core.library.evidence import KINDS, Evidence
from shapegoogle_core.library.origin import SHAPE_TYPES
from shapegoogle_core.rendering.text import evidence_text
from shapegoogle_core.service.app import PAGE
from shapegoogle_core.service.tokens import TokenFile
from tests.core.service.conftest import SHAPES
from tests.core.service.running import Running, running_service

CHROMIUM = shutil.which("chromium")
# Without a graphics card; and as root there is no sandbox.
OPTIONS = ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist"]
WAIT = 60_000

SAID_AS_ELSEWHERE = (
    Evidence("identical"),
    Evidence("scaled", factor=2.541),
    Evidence("re-posed", factor=1.001, probability=0.9),
    Evidence("part of", factor=0.2, share=0.494),
    Evidence("contains", share=0.1),
    Evidence("nothing in common", factor=1.88),
)

needs_chromium = pytest.mark.skipif(
    CHROMIUM is None, reason="there is no chromium (Debian: apt install chromium)"
)
Open = Callable[..., Page]


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    with sync_playwright() as playwright:
        opened = playwright.chromium.launch(executable_path=CHROMIUM, args=OPTIONS)
        yield opened
        opened.close()


@pytest.fixture
def service(library_path: Path) -> Iterator[Running]:
    with running_service(library_path, "--allow-download") as running:
        yield running


@pytest.fixture
def open_page(browser: Browser) -> Iterator[Open]:
    """Open pages; nothing may fail in them, or be asked of any other server."""
    faults: list[str] = []
    contexts = []

    def elsewhere(url: str, address: str) -> None:
        if not url.startswith((address, "blob:")):
            faults.append(url)

    def open_at(address: str, **options: Any) -> Page:
        context = browser.new_context(**options)
        contexts.append(context)
        page = context.new_page()
        page.set_default_timeout(WAIT)
        page.on("pageerror", lambda error: faults.append(str(error)))
        page.on(
            "request",
            lambda sent: None if sent.url.startswith((address, "blob:")) else faults.append(sent.url),
        )
        page.goto(address)
        return page

    yield open_at
    for context in contexts:
        context.close()
    assert faults == []


def find(page: Page, name: str) -> None:
    page.fill("#find", name)
    page.locator("#found button").first.click()


@needs_chromium
def test_searching_comparing_and_turning(open_page: Open, service: Running) -> None:
    page = open_page(service.address)
    expect(page.locator("#library")).to_have_text("shapes.sglib: 7 shapes")
    # By the keyboard: Enter takes the first shape found, also if it comes later; the arrows another one.
    page.fill("#find", "r")
    page.keyboard.press("Enter")
    cards = page.locator("#matches .card")
    expect(cards).to_have_count(7, timeout=WAIT)
    expect(page.locator("#find")).to_be_focused()
    page.keyboard.type("ring")
    expect(page.locator("#found button")).to_have_count(1)
    page.keyboard.press("ArrowDown")
    page.keyboard.press("ArrowUp")
    page.keyboard.press("ArrowDown")
    page.keyboard.press("Enter")
    expect(page.locator("#examples")).to_contain_text("ring")
    expect(cards).to_have_count(7, timeout=WAIT)
    expect(cards.first).to_contain_text("identical")
    words = "async (evidence) => (await import('/words.js')).kindText(evidence)"
    for evidence in SAID_AS_ELSEWHERE:
        assert page.evaluate(words, evidence.to_json()) == evidence_text(evidence)
    cards.nth(2).locator(".open").click()
    canvases = page.locator("#viewers canvas")
    expect(canvases).to_have_count(2, timeout=WAIT)
    before = [canvases.nth(side).screenshot() for side in (0, 1)]
    canvases.first.focus()
    page.keyboard.press("ArrowUp")
    page.keyboard.press("ArrowRight")
    after = [canvases.nth(side).screenshot() for side in (0, 1)]
    assert before[0] != after[0]
    assert before[1] != after[1]  # they turn together


@needs_chromium
@pytest.mark.long
def test_everything_else_on_the_page(
    open_page: Open, service: Running, made_library: Path, tmp_path: Path
) -> None:
    page = open_page(service.address)
    expect(page.locator("#formats")).to_contain_text(".obj")
    (tmp_path / "wrong.obj").write_text("v 1 2\n")
    two = trimesh.Scene({name: SHAPES[f"{name}.ply"] for name in ("ring", "rod")})
    two.export(tmp_path / "two.3mf")  # type: ignore[no-untyped-call]
    page.set_input_files("#file", str(tmp_path / "wrong.obj"))
    expect(page.locator("#state")).to_contain_text("wrong.obj", timeout=WAIT)
    page.set_input_files("#file", str(made_library.parent / "models" / "box.ply"))
    cards = page.locator("#matches .card")
    expect(cards.first).to_contain_text("identical", timeout=WAIT)
    # Filters.
    page.click("#filters summary")
    page.fill("[name=text]", "box")
    page.check("[name=families]")
    page.keyboard.press("Enter")
    expect(cards).to_have_count(1, timeout=WAIT)
    page.locator(".row button", has_text="1 version").click()
    expect(cards).to_have_count(2, timeout=WAIT)
    page.click("[type=reset]")
    expect(cards).to_have_count(7, timeout=WAIT)
    # A file of several shapes lets choose.
    page.set_input_files("#file", str(tmp_path / "two.3mf"))
    choices = page.locator("#found button")
    expect(choices).to_have_count(2, timeout=WAIT)
    choices.nth(1).click()
    expect(page.locator("#examples li")).to_have_count(1)
    expect(cards).to_have_count(7, timeout=WAIT)
    # More and less like this.
    cards.nth(1).locator("[title='More like this']").click()
    expect(page.locator("#examples li")).to_have_count(2)
    page.locator("#examples li button").last.click()
    expect(page.locator("#examples li")).to_have_count(1)
    expect(page.locator("#state")).to_contain_text("matches", timeout=WAIT)
    # A tag, once the page knows the shape; a download, and a decision that is undone.
    held: list[Route] = []
    page.route(re.compile(r"/api/shapes/\d+$"), lambda route: held.append(route))
    cards.nth(1).locator(".open").click()
    expect(page.locator("#compare")).to_be_visible()
    expect(page.locator("#compare canvas").first).to_be_visible(timeout=WAIT)
    expect(page.locator("#tagging")).to_be_hidden()
    for route in held:
        route.continue_()
    page.unroute_all()
    page.fill("#tagging input", "crate")
    page.click("#tagging button")
    expect(page.locator("#facts .tags")).to_contain_text("crate", timeout=WAIT)
    with page.expect_download() as download:
        page.locator("#actions a").click()
    assert Path(download.value.path()).read_bytes().startswith(b"ply")
    page.locator("#actions button", has_text="Not a match").click()
    expect(cards).to_have_count(6, timeout=WAIT)
    page.goto(f"{service.address}#decisions")
    made = page.locator("#made li")
    expect(made).to_have_count(2, timeout=WAIT)
    made.first.locator("button").click()
    expect(made).to_have_count(1, timeout=WAIT)
    # Duplicates and the map.
    page.goto(f"{service.address}#duplicates")
    groups = page.locator("#groups > li")
    expect(groups.first).to_be_visible(timeout=WAIT)
    count = groups.count()
    page.locator("#groups button", has_text="Keep both").first.click()
    expect(groups).to_have_count(count - 1, timeout=WAIT)
    page.goto(f"{service.address}#map")
    expect(page.locator("#points button")).to_have_count(7, timeout=WAIT)
    page.locator("#points button").first.press("Enter")
    expect(page.locator("#viewers canvas")).to_have_count(1, timeout=WAIT)


@needs_chromium
@pytest.mark.long
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_nothing_is_cut_off_on_a_phone(open_page: Open, service: Running, scheme: str) -> None:
    page = open_page(
        service.address, viewport={"width": 360, "height": 740}, color_scheme=scheme, has_touch=True
    )
    find(page, "box")
    expect(page.locator("#matches .card").first).to_be_visible(timeout=WAIT)
    for part in ("search", "duplicates", "map", "decisions"):
        page.locator(f"nav a[href='#{part}']").click()
        expect(page.locator(f"section#{part}")).to_be_visible()
        assert page.locator("body").evaluate("body => body.scrollWidth") <= 360


@needs_chromium
@pytest.mark.long
def test_the_page_asks_for_a_token(open_page: Open, library_path: Path, tmp_path: Path) -> None:
    tokens = TokenFile(tmp_path / "tokens.json")
    token = tokens.create("ana", "read")
    with running_service(library_path, "--token-file", str(tokens.path)) as running:
        page = open_page(running.address)
        page.fill("#sign-in input", "wrong")
        page.click("#sign-in button")
        expect(page.locator("#sign-in-state")).to_contain_text("not valid", timeout=WAIT)
        page.fill("#sign-in input", token)
        page.click("#sign-in button")
        expect(page.locator("#library")).to_have_text("shapes.sglib: 7 shapes", timeout=WAIT)
        find(page, "ring")
        page.locator("#matches .open").nth(1).click()
        # It may read only.
        expect(page.locator("#tagging")).to_be_hidden()
        expect(page.locator("#actions button")).to_have_count(1)


def test_the_page_knows_all_kinds_and_types() -> None:
    text = (PAGE / "words.js").read_text("utf-8")
    lists = dict(re.findall(r"export const (\w+) = \[(.*?)\];", text, re.DOTALL))
    assert re.findall(r'"([^"]+)"', lists["KINDS"]) == list(KINDS)
    assert re.findall(r'"([^"]+)"', lists["TYPES"]) == list(SHAPE_TYPES)


def test_the_page_is_complete_and_loads_nothing_from_elsewhere() -> None:
    files = {
        path.relative_to(PAGE).as_posix(): path.read_text(encoding="utf-8") for path in PAGE.rglob("*.*")
    }
    assert "vendor/three.LICENSE.txt" in files
    for name, text in files.items():
        if name.startswith("vendor/"):
            continue
        assert not re.search(r"https?://(?!www\.w3\.org/2000/svg)", text), name
        assert not re.search(r"innerHTML|eval\(|style=|onclick=\"", text), name
        for imported in re.findall(r'from "\./([\w/.]+)"', text):
            assert imported in files, f"{name} imports {imported}"
