# SPDX-License-Identifier: MIT
"""Binary codes in memory, and Hamming search over them."""
