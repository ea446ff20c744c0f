# SPDX-License-Identifier: MIT
"""A library in one SQLite file: all SQL for it is in this folder."""
