# SPDX-License-Identifier: MIT
"""Libraries in PostgreSQL databases."""
