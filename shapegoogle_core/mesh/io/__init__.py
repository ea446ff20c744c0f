# SPDX-License-Identifier: MIT
"""Reading mesh files: one module per format."""
