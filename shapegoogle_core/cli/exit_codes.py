# SPDX-License-Identifier: MIT
"""Exit codes of all commands."""

__all__ = ["CLOSED_PIPE", "DONE", "EXIT_CODES", "INTERRUPTED", "SOME_FAILED", "UNUSABLE"]

DONE = 0
SOME_FAILED = 1
"""Some inputs failed, each named on stderr; the others are done."""
UNUSABLE = 2
"""Nothing was done: wrong usage, or a library, model or file that cannot be opened or written."""
INTERRUPTED = 130
"""Interrupted by Ctrl-C (SIGINT) or SIGTERM."""
CLOSED_PIPE = 141
"""Output closed by the reader of a pipe, as in `shapegoogle query … | head`; shells report the same code."""

EXIT_CODES = """\
exit codes:
  0    everything done
  1    some inputs failed (a mesh that cannot be read, a folder that is missing or contains no meshes);
       each is named on stderr, and the others are done
  2    nothing was done: wrong usage, or the library or model cannot be opened or written
  130  interrupted by Ctrl-C or SIGTERM; everything stored so far is kept
"""
"""Section of every help text."""
