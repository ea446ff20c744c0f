# SPDX-License-Identifier: MIT
"""The commands of `shapegoogle`, a file each: its options, the call of the core, and its output."""
