# SPDX-License-Identifier: MIT
"""The tables of a library file.

A shape's row is spread over several tables, so that reading all codes touches about 40 bytes for each shape
and neither bags and samples (kilobytes) nor thumbnails (tens of kilobytes).
"""

__all__ = ["APPLICATION_ID", "EARLIER_FORMAT", "FORMAT", "SCHEMA", "SCHEMA_OF_KINDS", "SCHEMA_OF_ORIGINS"]

# "SGLB": tells a library from any other SQLite database (the `file` command shows it).
APPLICATION_ID = 0x53474C42
FORMAT = 8
"""Version of the library format."""

EARLIER_FORMAT = 7
"""Version without the tables of `SCHEMA_OF_KINDS`, which the first change adds; all others are refused."""

# Key of the tables with one row for each shape.
_OF_SHAPE = "shape_id INTEGER PRIMARY KEY REFERENCES shapes (id) ON DELETE CASCADE"

SCHEMA = f"""
CREATE TABLE meta (key TEXT PRIMARY KEY, value TEXT NOT NULL);
CREATE TABLE model (identifier TEXT NOT NULL, content BLOB NOT NULL);
CREATE TABLE roots (id INTEGER PRIMARY KEY, name TEXT NOT NULL UNIQUE, path TEXT NOT NULL);
CREATE TABLE sources (
    id INTEGER PRIMARY KEY,
    root_id INTEGER REFERENCES roots (id), -- NULL: the path is a label, not an indexed file
    path TEXT NOT NULL,
    key TEXT NOT NULL, -- the path, without differences of case where they do not count
    size INTEGER,
    mtime_ns INTEGER,
    sha256 TEXT,
    error TEXT
);
CREATE UNIQUE INDEX source_keys ON sources (coalesce(root_id, 0), key);
CREATE TABLE shapes (
    id INTEGER PRIMARY KEY AUTOINCREMENT, -- an id that was shown to a user must never mean another shape
    source_id INTEGER REFERENCES sources (id) ON DELETE CASCADE,
    object_name TEXT NOT NULL,
    name TEXT NOT NULL,
    vertex_count INTEGER NOT NULL,
    face_count INTEGER NOT NULL,
    area REAL NOT NULL,
    extent_x REAL NOT NULL,
    extent_y REAL NOT NULL,
    extent_z REAL NOT NULL,
    placement_count INTEGER NOT NULL
);
CREATE INDEX shapes_of_source ON shapes (source_id);
CREATE TABLE tags (
    shape_id INTEGER NOT NULL REFERENCES shapes (id) ON DELETE CASCADE,
    tag TEXT NOT NULL,
    PRIMARY KEY (shape_id, tag)
) WITHOUT ROWID;
CREATE INDEX shapes_with_tag ON tags (tag);
CREATE TABLE placements (
    shape_id INTEGER NOT NULL REFERENCES shapes (id) ON DELETE CASCADE,
    position INTEGER NOT NULL,
    object_name TEXT NOT NULL,
    matrix BLOB NOT NULL, -- 16 float64, little-endian, row by row
    extent_x REAL NOT NULL,
    extent_y REAL NOT NULL,
    extent_z REAL NOT NULL,
    PRIMARY KEY (shape_id, position)
) WITHOUT ROWID;
CREATE TABLE codes ({_OF_SHAPE}, code BLOB NOT NULL);
CREATE TABLE local_words ({_OF_SHAPE}, code BLOB NOT NULL);
CREATE TABLE code_blocks (block INTEGER PRIMARY KEY, offsets BLOB NOT NULL, codes BLOB NOT NULL);
CREATE TABLE local_word_blocks (block INTEGER PRIMARY KEY, offsets BLOB NOT NULL, codes BLOB NOT NULL);
CREATE TRIGGER code_removed AFTER DELETE ON codes
    BEGIN DELETE FROM code_blocks WHERE block = (old.shape_id - 1) / {{block_ids}}; END;
CREATE TRIGGER local_words_removed AFTER DELETE ON local_words
    BEGIN DELETE FROM local_word_blocks WHERE block = (old.shape_id - 1) / {{block_ids}}; END;
CREATE TABLE bags ({_OF_SHAPE}, halves BLOB NOT NULL);
CREATE TABLE samples ({_OF_SHAPE}, content BLOB NOT NULL);
CREATE TABLE measures ({_OF_SHAPE}, content BLOB NOT NULL);
CREATE TABLE thumbnails ({_OF_SHAPE}, png BLOB NOT NULL);
"""
"""Statements, each ending a line; `block_ids` is the number of ids in a block of codes, see `CodeBlocks`."""

SCHEMA_OF_KINDS = f"""
CREATE TABLE views ({_OF_SHAPE}, descriptors BLOB NOT NULL);
CREATE TABLE view_codes ({_OF_SHAPE}, code BLOB NOT NULL);
CREATE TABLE view_code_blocks (block INTEGER PRIMARY KEY, offsets BLOB NOT NULL, codes BLOB NOT NULL);
CREATE TRIGGER view_code_removed AFTER DELETE ON view_codes
    BEGIN DELETE FROM view_code_blocks WHERE block = (old.shape_id - 1) / {{block_ids}}; END;
CREATE TABLE neighbours ({_OF_SHAPE}, ids BLOB NOT NULL, distances BLOB NOT NULL);
"""
"""Statements for what finds shapes of the same kind, new in format 8; written as `SCHEMA`."""

SCHEMA_OF_ORIGINS = f"""
CREATE TABLE IF NOT EXISTS origins (
    {_OF_SHAPE},
    shape_type TEXT NOT NULL,
    catalog TEXT NOT NULL,
    frame INTEGER
);
"""
"""What shapes are in their files. Made when the first shape needs it; a shape without a row is an object, or
a file if it has no object name, in no catalog."""
