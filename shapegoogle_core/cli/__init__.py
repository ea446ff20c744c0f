# SPDX-License-Identifier: MIT
"""The `shapegoogle` command."""
