# SPDX-License-Identifier: MIT
"""Reading mesh files: one reader per format.

`reading` chooses the reader by suffix. A reader gets a `file.MeshFile` and returns `polygons.Polygons`, which
`polygons.triangulate` cuts into triangles for all formats alike. Text formats share `text` (lines)
and `numbers` (what is in them).
"""
