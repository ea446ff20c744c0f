# SPDX-License-Identifier: MIT
"""What people decided about shapes of a library, kept with it."""
