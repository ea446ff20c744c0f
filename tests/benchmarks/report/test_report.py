# SPDX-License-Identifier: MIT
"""The report: a page that is whole, and plots and pictures of what was measured."""

from __future__ import annotations

import html.parser
import math
import re
import xml.etree.ElementTree as ElementTree
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import trimesh

from benchmarks.protocol.collection import BenchmarkShape, Collection
from benchmarks.protocol.metrics import CategoryScores
from benchmarks.protocol.results import BenchmarkResult, CategoryResult, Problem, VariantResult
from benchmarks.protocol.scoring import score_variant
from benchmarks.protocol.tables import chosen_variants, text_table

pytest.importorskip("matplotlib")
pytest.importorskip("jinja2")

from benchmarks.report import write_report
from benchmarks.report.pictures import worst_failures, worst_outcomes
from benchmarks.report.plots import Plot, bit_plots, roc_plot, strength_plots, vocabulary_plots
from tests.benchmarks.conftest import relevant_columns

pytestmark = pytest.mark.filterwarnings("error")

EVIL = "<b>&'$x_1$\" · model"


@pytest.fixture(scope="module")
def collection(tmp_path_factory: pytest.TempPathFactory) -> Collection:
    folder = tmp_path_factory.mktemp("shapes")
    database = []
    for name, shape in {
        "ball": trimesh.creation.icosphere(2),
        "box": trimesh.creation.box().subdivide().subdivide(),
        "rod": trimesh.creation.cylinder(0.2, 2),
    }.items():
        shape.export(folder / f"{name}.ply")
        kind = "negative" if name == "rod" else "null"
        database.append(BenchmarkShape(name, folder / f"{name}.ply", name, kind, 0))
    queries = tuple(
        BenchmarkShape(f"{shape.name}.{kind}.{strength}", shape.path, shape.name, kind, strength, 0)
        for shape in database[:2]
        for kind in ("noise", "scale")
        for strength in (1, 2, 3)
    )
    return Collection("solids <&>", tuple(database), queries)


def variant(
    collection: Collection,
    name: str,
    family: str = "bags",
    seed: int = 0,
    quality: float = 1.0,
    **parameters: str | int | float,
) -> VariantResult:
    random = np.random.default_rng(seed)
    distances = random.random((len(collection.queries), len(collection.database)))
    distances[np.arange(len(distances)), relevant_columns(collection)] /= 1 + quality
    names = [shape.name for shape in collection.database]
    return score_variant(name, family, parameters, distances, collection.queries, names, 0.004, 192)


@pytest.fixture(scope="module")
def result(collection: Collection) -> BenchmarkResult:
    bags = [
        variant(
            collection,
            f"{descriptor} · {bag} · {words}",
            seed=words,
            descriptor=descriptor,
            bag=bag,
            words=words,
            preparation="paper",
        )
        for descriptor in ("hks", "si-hks")
        for bag in ("pairs", "words")
        for words in (4, 16, 48)
    ]
    codes = [
        variant(
            collection,
            f"hks · {bits} bits · {projection}",
            "codes",
            bits,
            descriptor="hks",
            bag="pairs",
            words=48,
            preparation="paper",
            bits=bits,
            projection=projection,
        )
        for projection in ("eigenvectors", "random")
        for bits in (16, 64)
    ]
    models = [
        variant(collection, "full bags", "model", 5, 8, model="default", stage="full bags"),
        variant(collection, "its codes", "codes", 6, 6, model="default", stage="codes", bits=256),
        variant(collection, EVIL, "model", 8, 0.1, model="default", stage="search"),
    ]
    return BenchmarkResult(
        collection.name,
        collection.counts(),
        "1.2.3",
        {"cores": 2, "python": "3.11"},
        17,
        (*bags, *codes, *models, variant(collection, "Shape-DNA", "baseline", 9, 0.1)),
        (CategoryResult("poses", "full bags", CategoryScores(0.987, 0.5, 0.75, 0.8)),),
        "2026-01-02T03:04",
        (Problem("cone", "failed", "it is <round>"),),
    )


class Page(html.parser.HTMLParser):
    """Text, tags and addresses of a page; fails where tags do not close in order."""

    VOID = ("meta", "img", "input", "br", "link")

    def __init__(self, text: str) -> None:
        super().__init__()
        self.open: list[str] = []
        self.text: list[str] = []
        self.addresses: list[str] = []
        self.ids: list[str] = []
        self.tags: list[str] = []
        self.feed(text)
        self.close()

    def handle_starttag(self, tag: str, attributes: list[tuple[str, str | None]]) -> None:
        if tag not in self.VOID:
            self.open.append(tag)
        self.tags.append(tag)
        for name, value in attributes:
            if name in ("src", "href"):
                self.addresses.append(value or "")
            if name == "id":
                self.ids.append(value or "")

    def handle_startendtag(self, tag: str, attributes: list[tuple[str, str | None]]) -> None:
        self.handle_starttag(tag, attributes)
        if tag not in self.VOID:
            self.open.pop()

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        if not self.open or self.open[-1] not in ("style", "script"):
            self.text.append(data)

    @property
    def words(self) -> str:
        return " ".join(" ".join(self.text).split())


@pytest.fixture(scope="module")
def markup(collection: Collection, result: BenchmarkResult, tmp_path_factory: pytest.TempPathFactory) -> str:
    folder = tmp_path_factory.mktemp("report") / "new"
    path = write_report(result, collection, folder)
    assert path == folder / "index.html"
    assert [file.name for file in folder.iterdir()] == ["index.html"]
    return path.read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def page(markup: str) -> Page:
    return Page(markup)


def test_page_is_whole_and_needs_nothing_else(page: Page) -> None:
    assert page.open == []
    assert page.tags.count("html") == page.tags.count("h1") == 1
    assert all(address.startswith(("#", "data:image/")) for address in page.addresses)
    assert len(page.ids) == len(set(page.ids))
    inside = {address.removeprefix("#") for address in page.addresses if address.startswith("#")}
    assert inside <= set(page.ids)


def test_page_says_what_was_measured(page: Page) -> None:
    for words in (
        "Shape retrieval on solids <&>",
        "12 queries among 3 shapes (2 null shapes, 1 unrelated)",
        "20 variants · seed 17",
        "2026-01-02 03:04 · Shape Google 1.2.3 · cores 2 · python 3.11",
        "98.7 50.0 75.0 80.0",
        "it is <round>",
    ):
        assert words in page.words
    assert "What changed" not in page.words
    assert "benchmark.json" not in page.words


def texts(plot: Plot) -> list[str]:
    """Texts of an SVG file."""
    root = ElementTree.fromstring(plot.svg)
    return ["".join(element.itertext()) for element in root.iter("{http://www.w3.org/2000/svg}text")]


def test_names_are_shown_as_they_are(page: Page, result: BenchmarkResult) -> None:
    assert page.text.count(EVIL) >= 3
    # In the plots a dollar would begin a formula.
    curves = roc_plot(result.variants[-3:])
    assert curves is not None
    assert any(EVIL.split()[0] in text for text in texts(curves))


def test_plots_are_files_of_their_own(result: BenchmarkResult) -> None:
    plots = strength_plots(result.variants[:2], ["noise", "average"])
    assert [plot.title for plot in plots] == ["noise", "average"]
    for plot in plots:
        assert plot.source.startswith("data:image/svg+xml;base64,")
        assert {"1", "5", "100"} <= set(texts(plot))
    # The same result gives the same page.
    assert strength_plots(result.variants[:2], ["noise", "average"]) == plots


def test_vocabulary_and_bits_are_drawn_for_each_descriptor(result: BenchmarkResult) -> None:
    plots = vocabulary_plots(result.variants)
    assert [plot.title for plot in plots] == ["hks · paper", "si-hks · paper"]
    assert all({"pairs", "words", "mAP", "4", "16", "48"} <= set(texts(plot)) for plot in plots)
    (bits,) = bit_plots(result.variants)
    assert {"eigenvectors", "random", "the bag itself", "16", "64"} <= set(texts(bits))


def test_nothing_to_draw_gives_no_plot(collection: Collection) -> None:
    only = variant(collection, "only", "codes", bits=16, descriptor="hks")
    assert bit_plots([only]) == vocabulary_plots([only]) == []
    assert roc_plot([replace(only, roc=[])]) is None


def test_worst_come_first_and_right_ones_not_at_all(collection: Collection, result: BenchmarkResult) -> None:
    search = result.search
    assert search is not None
    assert search.name == EVIL
    worst = worst_outcomes(search, 3)
    assert [outcome.rank for outcome in worst] == sorted((o.rank for o in search.outcomes), reverse=True)[:3]
    assert all(outcome.rank > 1 for outcome in worst_outcomes(search, 99))
    failures = list(worst_failures(search, collection, 2))
    assert len(failures) == 2
    for failure in failures:
        for picture in (failure.query, failure.relevant, failure.first):
            assert picture.startswith("data:image/png;base64,")


def test_a_shape_that_is_gone_has_no_picture(
    collection: Collection, result: BenchmarkResult, tmp_path: Path
) -> None:
    assert result.search is not None
    gone = tuple(replace(shape, path=tmp_path / "gone.ply") for shape in collection.database)
    moved = Collection("moved", gone, collection.queries)
    failure = next(worst_failures(result.search, moved, 1))
    assert failure.query
    assert failure.relevant == failure.first == ""
    few = replace(result, variants=(result.search,))
    text = write_report(few, moved, tmp_path).read_text(encoding="utf-8")
    assert "no picture" in text


def test_a_failed_query_is_no_picture(collection: Collection) -> None:
    distances = np.ones((len(collection.queries), 3))
    distances[0] = math.inf
    names = [shape.name for shape in collection.database]
    scored = score_variant("v", "model", {}, distances, collection.queries, names, 0, 0)
    assert len(worst_outcomes(scored, 99)) == len(collection.queries) - 1


def test_comparison_shows_what_changed(
    collection: Collection, result: BenchmarkResult, tmp_path: Path
) -> None:
    better = variant(collection, EVIL, "model", 8, 50, model="default", stage="search")
    after = replace(result, variants=(result.variants[0], better))
    (tmp_path / "benchmark.json").write_text("{}")
    page = Page(write_report(after, collection, tmp_path, result).read_text(encoding="utf-8"))
    assert "What changed since 2026-01-02 03:04" in page.words
    assert re.search(r"average [\d.]+ [\d.]+ \+[\d.]+", page.words)
    assert "do not have the same queries" not in page.words
    assert "benchmark.json" in page.addresses
    other = write_report(replace(after, seed=18), collection, tmp_path, result)
    other_seed = Page(other.read_text(encoding="utf-8"))
    assert "do not have the same queries" in other_seed.words


def test_a_result_without_variants_or_search_still_makes_a_page(
    collection: Collection, result: BenchmarkResult, tmp_path: Path
) -> None:
    for variants in ((), result.variants[:2]):
        bare = replace(result, variants=variants, categories=(), problems=(), date="")
        page = Page(write_report(bare, collection, tmp_path, bare).read_text(encoding="utf-8"))
        assert "Worst failures" not in page.words


def test_chosen_are_the_search_and_the_best_of_each_family(result: BenchmarkResult) -> None:
    chosen = chosen_variants(result)
    assert len(chosen) == 6
    assert chosen[0] is result.search
    assert {entry.family for entry in chosen} == {"model", "bags", "codes", "baseline"}
    averages = [entry.average for entry in chosen[1:]]
    assert averages == sorted(averages, reverse=True)
    assert [entry.name for entry in chosen_variants(result, 1)] == [EVIL]


def test_what_it_costs_stands_before_the_classes(markup: str) -> None:
    titles = re.findall(r"<button>(.*?)</button>", markup)
    first = ["variant", "average", "found first %", "equal error %", "bytes per shape", "ms per query"]
    assert titles[:7] == [*first, "CPU ms to describe"]
    assert {"noise", "scale", "family", "descriptor"} <= set(titles[7:])


def test_text_table_lines_up(result: BenchmarkResult) -> None:
    assert result.search is not None
    lines = text_table(result).splitlines()
    table = lines[next(i for i, line in enumerate(lines) if line.startswith("─")) :]
    assert [line.split()[0] for line in table if not line.startswith("─")] == ["scale", "noise", "average"]
    assert len({len(line) for line in table}) == 1
    assert max(map(len, lines)) <= 100
    assert f"{result.search.average:.1f}" in table[-1]
    assert text_table(replace(result, variants=())) == "nothing was measured"
