# SPDX-License-Identifier: MIT
"""The manual of the add-on as a page with its pictures, which the extension contains."""

from __future__ import annotations

import html
import os
import re
import shutil
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

from lib import bootstrap

__all__ = ["write_manual"]

QUIET = ("--no-input", "--disable-pip-version-check", "--progress-bar=off")
SOURCE = bootstrap.ROOT / "docs" / "blender" / "index.md"
# Run by a Python that may have no converter of its own: it finds the one that pip has put into a folder.
CONVERT = """
import sys
from markdown_it import MarkdownIt
text = open(sys.argv[1], encoding="utf-8").read()
sys.stdout.reconfigure(encoding="utf-8")
sys.stdout.write(MarkdownIt("commonmark").enable("table").render(text))
"""
PAGE = """<!doctype html>
<html lang="en"><head><meta charset="utf-8"><title>{title}</title><style>
body {{ max-width: 48rem; margin: 2rem auto; padding: 0 1rem; font: 1rem/1.5 sans-serif; }}
img {{ max-width: 100%; }} pre {{ overflow-x: auto; background: #f3f3f3; padding: 0.6rem; }}
td, th {{ text-align: left; vertical-align: top; padding: 0.2rem 0.8rem 0.2rem 0; }}
</style></head><body>
{body}
</body></html>
"""


def write_manual(folder: Path, packages: Path, pip: Sequence[str], pin: str) -> None:
    """Write the page and the pictures that it shows.

    Parameters
    ----------
    folder : Path
        Made if it does not exist; the page is `index.html` in it.
    packages : Path
        Folder for the converter of Markdown, which is downloaded once.
    pip : sequence of str
        The command of pip.
    pin : str
        The converter and its version, as pip takes it.

    Raises
    ------
    SetupError
        If the converter cannot be had.
    """
    if bootstrap.read_stamp(packages) != {"pin": pin}:
        shutil.rmtree(packages, ignore_errors=True)
        packages.mkdir(parents=True)
        bootstrap.run(
            "Downloading a converter of Markdown", [*pip, "install", *QUIET, f"--target={packages}", pin]
        )
        bootstrap.write_stamp(packages, {"pin": pin})
    environment = {**os.environ, "PYTHONPATH": str(packages)}
    command = [sys.executable, "-c", CONVERT, str(SOURCE)]
    body = subprocess.run(
        command, env=environment, stdout=subprocess.PIPE, encoding="utf-8", check=True
    ).stdout
    folder.mkdir(parents=True, exist_ok=True)
    page, pictures = _alone(body)
    for picture in pictures:
        shutil.copyfile(SOURCE.parent / picture, folder / Path(picture).name)
    (folder / "index.html").write_text(page, encoding="utf-8")


def _alone(body: str) -> tuple[str, list[str]]:
    """Make a page that needs nothing but its pictures; returns their paths beside the source, too."""
    # Other pages of the documentation are not in the zip.
    body = re.sub(r'<a href="\.\./[^"]*">(.*?)</a>', r"\1", body, flags=re.DOTALL)
    pictures = list(dict.fromkeys(re.findall(r'<img src="([^"]+)"', body)))
    for picture in pictures:
        body = body.replace(f'src="{picture}"', f'src="{Path(picture).name}"')
    body = re.sub(r"<h(\d)>(.*?)</h\1>", _with_anchor, body)
    (title,) = re.findall(r"<h1[^>]*>(.*?)</h1>", body)
    return PAGE.format(title=title, body=body), pictures


def _with_anchor(heading: re.Match[str]) -> str:
    """Give a heading the name by which links on the page find it."""
    level, text = heading.groups()
    name = re.sub(r"[^\w-]", "", html.unescape(text).lower().replace(" ", "-"))
    return f'<h{level} id="{name}">{text}</h{level}>'
