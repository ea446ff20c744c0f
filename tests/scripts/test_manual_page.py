# SPDX-License-Identifier: MIT
"""The page of the manual in the extension needs nothing but its pictures."""

from __future__ import annotations

import re

from lib.manual import _alone

BODY = """<h1>Title</h1>
<p><a href="../concepts/index.md#the-models">model</a> <a href="#a--b">below</a>
<img src="../images/library.png" alt="x" /></p>
<h2>A &amp; B</h2>"""


def test_links_to_other_pages_become_text_and_headings_get_their_names() -> None:
    page, pictures = _alone(BODY)
    assert pictures == ["../images/library.png"]
    assert 'src="library.png"' in page
    assert "model <a" in page
    names = re.findall(r'id="([^"]+)"', page)
    assert names == ["title", "a--b"]
    assert set(re.findall(r'href="#([^"]+)"', page)) <= set(names)
    assert "<title>Title</title>" in page
