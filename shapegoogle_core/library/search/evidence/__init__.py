# SPDX-License-Identifier: MIT
"""Fourth stage of a search: what the query and each of the best matches have in common."""
