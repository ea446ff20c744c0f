# SPDX-License-Identifier: MIT
"""Build the documentation site into docs/_build/html; warnings are errors.

    python3 scripts/build_docs.py [--without-examples]

Runs every example of the gallery and draws the figures of the concepts with the product as it is. Checks the
links and anchors between pages; nothing is downloaded.
"""

from __future__ import annotations

import argparse
import os
import shutil
import subprocess
import sys
import time
from collections.abc import Sequence
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

from lib import bootstrap

__all__ = ["broken_links", "main"]

DOCS = bootstrap.ROOT / "docs"
BUILD = DOCS / "_build"
PAGES = BUILD / "html"
# Written into the sources by the build.
GENERATED = (
    DOCS / "gallery",
    *(DOCS / "reference" / name for name in ("api", "addresses.rst", "commands.rst")),
)


class _Page(HTMLParser):
    """Collects the anchors of a page, and what its links and pictures lead to."""

    def __init__(self) -> None:
        super().__init__()
        self.anchors: set[str] = set()
        self.targets: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Read one tag."""
        for name, value in attrs:
            if not value:
                continue
            if name == "id" or (tag == "a" and name == "name"):
                self.anchors.add(value)
            elif name in ("href", "src"):
                self.targets.append(value)


def broken_links(folder: Path) -> list[str]:
    """List the links of a site that lead nowhere, and what it would load from elsewhere.

    Parameters
    ----------
    folder : Path
        Of the .html files.

    Returns
    -------
    problems : list of str
        Such as "start/index.html: ../limits.html#size".
    """
    pages: dict[Path, _Page] = {}
    for path in sorted(folder.rglob("*.html")):
        pages[path] = _Page()
        pages[path].feed(path.read_text(encoding="utf-8"))
    problems = []
    for path, page in pages.items():
        for target in page.targets:
            parts = urlsplit(target)
            if parts.scheme or parts.netloc:
                continue
            linked = (path.parent / unquote(parts.path)).resolve() if parts.path else path
            anchor = unquote(parts.fragment)
            found = linked.exists() and (not anchor or linked not in pages or anchor in pages[linked].anchors)
            if not found:
                problems.append(f"{path.relative_to(folder).as_posix()}: {target}")
    return problems


def main(arguments: Sequence[str] | None = None) -> int:
    """Build the site.

    Parameters
    ----------
    arguments : sequence of str, optional
        Those of the command line when left out.

    Returns
    -------
    exit_code : int
    """
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0], allow_abbrev=False)
    parser.add_argument(
        "--without-examples", action="store_true", help="do not run the examples, for a quick look at pages"
    )
    options = parser.parse_args(arguments)
    bootstrap.enter(["benchmark", "demo", "docs", "serve"])
    started = time.monotonic()
    for path in (PAGES, *GENERATED):
        if path.is_dir():
            shutil.rmtree(path)
        else:
            path.unlink(missing_ok=True)
    command = [sys.executable, "-m", "sphinx", "--fresh-env", "--fail-on-warning", "--keep-going", "--quiet"]
    if options.without_examples:
        command += ["--tag", "without_examples"]
    command += ["--doctree-dir", str(BUILD / "doctrees"), str(DOCS), str(PAGES)]
    # One thread: numerical libraries with threads of their own would compete with what else runs.
    environment = {**os.environ, "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", "MPLBACKEND": "agg"}
    if subprocess.run(command, env=environment, check=False).returncode != 0:
        print("The documentation has faults; see the messages above.", file=sys.stderr)
        return 1
    # Without examples there are no pictures of them.
    broken = [
        problem
        for problem in broken_links(PAGES)
        if not (options.without_examples and "/sphx_glr_" in problem)
    ]
    for problem in broken:
        print(f"link that leads nowhere: {problem}", file=sys.stderr)
    if broken:
        return 1
    index = (PAGES / "index.html").relative_to(bootstrap.ROOT)
    print(f"{index.as_posix()}: {len(list(PAGES.rglob('*.html')))} pages, {time.monotonic() - started:.0f} s")
    return 0


if __name__ == "__main__":
    sys.exit(main())
