# SPDX-License-Identifier: MIT
"""A program that reads files which the package does not, and the reader that asks it."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from shapegoogle_core.indexing import ExternalReader, ReaderOption

# No test comes near it.
LONG = 3600.0

# Reads files of numbers: one shape for each, an octahedron as large as the number; with the word "shared" one
# for all. What another word stands for happens instead.
PROGRAM = """
import json, os, sys, time
from array import array

VERTICES = [1, 0, 0, -1, 0, 0, 0, 1, 0, 0, -1, 0, 0, 0, 2, 0, 0, -1]
FACES = [0, 2, 4, 2, 1, 4, 1, 3, 4, 3, 0, 4, 2, 0, 5, 1, 2, 5, 3, 1, 5, 0, 3, 5]
messages = open(int(os.environ["SHAPEGOOGLE_MESSAGES"]), "w")
print("a banner")
print(json.dumps({"ready": True}), file=messages, flush=True)
for line in sys.stdin:
    request = json.loads(line)
    words = open(request["path"]).read().split()
    print("reading", request["path"], "warning: noise on the other stream", file=sys.stderr)
    answer = {"shapes": [], "problems": [], "joined": "joined" in words}
    answer["up_axis"] = 2
    with open(request["output"], "wb") as output:
        for word in words:
            if word == "crash" or "FAIL" in os.environ:
                print("something is wrong", flush=True)
                os._exit(3)
            elif word.startswith("step"):  # a part of a large file, which takes as many seconds
                number = words.index(word) + 1
                print(json.dumps({"progress": [number, len(words)]}), file=messages, flush=True)
                time.sleep(float(word.removeprefix("step").partition("-")[0]))
            elif word == "hang":
                time.sleep(3600)
            elif word == "swell":
                import resource
                limit, _ = resource.getrlimit(resource.RLIMIT_AS)
                answer["problems"].append(f"limit {limit} asked {request['memory_limit']}")
            elif word == "error":
                answer = {"error": "the program does not like it"}
            elif word == "problem":
                answer["problems"].append("'Part' is no good")
            elif word not in ("joined", "shared"):
                scale = float(word)
                s = abs(scale)
                matrix = [scale, 0, 0, 0, 0, s, 0, 0, 0, 0, s, 5, 0, 0, 0, 1]
                name = request["prefix"] + word
                placement = {"object": name, "matrix": matrix}
                if answer["shapes"] and "shared" in words:
                    answer["shapes"][0]["placements"].append(placement)
                    continue
                array("f", VERTICES).tofile(output)
                array("i", FACES).tofile(output)
                record = {"name": name, "placements": [placement]}
                record.update(vertices=6, faces=8)
                answer["shapes"].append(record)
    print(json.dumps(answer), file=messages, flush=True)
"""


@pytest.fixture
def reader(tmp_path: Path) -> ExternalReader:
    program = tmp_path / "program.py"
    program.write_text(PROGRAM)
    return ExternalReader(
        suffixes=frozenset({".numbers"}),
        command=(sys.executable, str(program)),
        title="the program",
        offers=(ReaderOption("prefix", ("x", "y"), "what names begin with"),),
        options=(("prefix", "x"),),
        time_limit=LONG,
    )


def write_numbers(folder: Path, name: str, text: str) -> Path:
    folder.mkdir(exist_ok=True)
    path = folder / f"{name}.numbers"
    path.write_text(text)
    return path
