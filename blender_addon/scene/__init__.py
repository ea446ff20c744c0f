# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's objects and meshes: selecting objects, reading meshes into the core and back."""
