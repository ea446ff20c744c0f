# SPDX-License-Identifier: MIT
"""Pictures for the documentation."""
