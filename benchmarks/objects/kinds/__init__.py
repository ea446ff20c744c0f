# SPDX-License-Identifier: MIT
"""The kinds of procedural things, by what they are for."""
