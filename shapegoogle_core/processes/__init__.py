# SPDX-License-Identifier: MIT
"""Running work in other processes."""
