# SPDX-License-Identifier: MIT
"""The tables of a library file.

A shape's row is spread over six tables, so that loading all codes touches about 40 bytes for each shape and
neither bags and samples (kilobytes) nor thumbnails (tens of kilobytes).
"""

import numpy as np

__all__ = ["APPLICATION_ID", "BAG_TYPE", "SCHEMA", "SCHEMA_VERSION", "UNREADABLE_VERSION"]

# Half floats, little-endian. On 70 PSB shapes (2,448 entries, square-rooted, L1) they move
# distances by less than 0.05 % and leave the order of the ten nearest as it is, for half the room.
BAG_TYPE = np.dtype("<f2")

# "SGLB": tells a library from any other SQLite database (the `file` command shows it).
APPLICATION_ID = 0x53474C42
# 2: with samples; they had no eigenfunctions and cannot be read any more. 3: with them. 4: with codes of bags
# of local words. 5: with local words. One of version 1, 3 or 4 stays as it is: without samples, or words.
SCHEMA_VERSION, UNREADABLE_VERSION = 5, 2

SCHEMA = """
CREATE TABLE meta (key TEXT PRIMARY KEY, value TEXT NOT NULL);
CREATE TABLE model (identifier TEXT NOT NULL, content BLOB NOT NULL);
CREATE TABLE sources (
    id INTEGER PRIMARY KEY,
    path TEXT NOT NULL UNIQUE,
    size INTEGER,
    mtime_ns INTEGER,
    sha256 TEXT,
    error TEXT
);
CREATE TABLE shapes (
    id INTEGER PRIMARY KEY AUTOINCREMENT, -- an id that was shown to a user must never mean another shape
    source_id INTEGER REFERENCES sources (id) ON DELETE CASCADE,
    object_name TEXT NOT NULL,
    name TEXT NOT NULL,
    vertex_count INTEGER NOT NULL,
    face_count INTEGER NOT NULL,
    area REAL NOT NULL
);
CREATE INDEX shapes_of_source ON shapes (source_id);
CREATE TABLE codes (
    shape_id INTEGER PRIMARY KEY REFERENCES shapes (id) ON DELETE CASCADE,
    code BLOB NOT NULL
);
CREATE TABLE bags (
    shape_id INTEGER PRIMARY KEY REFERENCES shapes (id) ON DELETE CASCADE,
    halves BLOB NOT NULL
);
CREATE TABLE samples (
    shape_id INTEGER PRIMARY KEY REFERENCES shapes (id) ON DELETE CASCADE,
    content BLOB NOT NULL
);
CREATE TABLE local_words (
    shape_id INTEGER PRIMARY KEY REFERENCES shapes (id) ON DELETE CASCADE,
    code BLOB NOT NULL
);
CREATE TABLE thumbnails (
    shape_id INTEGER PRIMARY KEY REFERENCES shapes (id) ON DELETE CASCADE,
    png BLOB NOT NULL
);
"""
