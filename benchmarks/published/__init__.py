# SPDX-License-Identifier: MIT
"""Published collections of labelled shapes, read as they are distributed, and the measures they define."""
