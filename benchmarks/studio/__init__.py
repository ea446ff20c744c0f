# SPDX-License-Identifier: MIT
"""Libraries in a database, services and clusters: servers for them, and what they can do."""
