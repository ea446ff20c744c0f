# SPDX-License-Identifier: MIT
"""The library on disk: records, schema, and the SQLite file."""
