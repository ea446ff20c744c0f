# SPDX-License-Identifier: GPL-3.0-or-later
"""Which shapes a .blend file has: read by a Blender of its own, or from the open scene."""
