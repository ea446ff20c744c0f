# SPDX-License-Identifier: MIT
"""Settings of all tests."""

from __future__ import annotations

from hypothesis import settings

# No time limit that a busy machine can miss.
settings.register_profile("no deadline", deadline=None)
settings.load_profile("no deadline")
