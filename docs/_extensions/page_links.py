# SPDX-License-Identifier: MIT
"""Links that work on GitHub lead to the right page of the site, too.

A link to an example's source, ``examples/five_lines.py``, leads to its page in the gallery. Links to files of
the repository outside this folder become text: the site does not contain them.
"""

from __future__ import annotations

import os
import re
from pathlib import Path
from typing import Any

from sphinx.application import Sphinx

LINK = re.compile(r"(?<!!)\[([^]]*)\]\(([^)\s:#]+)(#[^)\s]*)?\)")


def lead_to_pages(app: Sphinx, name: str, source: list[str]) -> None:
    """Replace the links of one page."""
    if not str(app.env.doc2path(name)).endswith(".md"):
        return
    docs = Path(app.srcdir)
    folder = (docs / name).parent

    def replaced(link: re.Match[str]) -> str:
        text, path, anchor = link[1], link[2], link[3] or ""
        target = (folder / path).resolve()
        if target.is_relative_to(docs / "examples") and target.suffix == ".py":
            page = docs / "gallery" / f"{target.stem}.rst"
            return f"[{text}]({Path(os.path.relpath(page, folder)).as_posix()}{anchor})"
        if target.exists() and not target.is_relative_to(docs):
            return text
        return link[0]

    source[0] = LINK.sub(replaced, source[0])


def setup(app: Sphinx) -> dict[str, Any]:
    """Connect to the reading of pages."""
    app.connect("source-read", lead_to_pages)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
