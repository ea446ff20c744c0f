# SPDX-License-Identifier: MIT
"""Shape Google: select a shape, find it again.

A library in five lines::

    import shapegoogle_core as sg

    with sg.Library.open("animals.sglib") as library:
        library.add(sg.read_mesh("horse.ply"), source="horse.ply")
        matches = library.query(sg.read_mesh("unknown.ply"), top=5)

Each step is a function of its own:

>>> import shapegoogle_core as sg
>>> vertices = [[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]]
>>> mesh = sg.Mesh(vertices, [[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]], name="tetrahedron")
>>> spectrum = sg.compute_spectrum(mesh, k=3)
>>> sg.heat_kernel_signature(spectrum, times=[1.0, 10.0]).shape
(4, 2)
"""

from shapegoogle_core.api.lazy_names import lazy_names

__version__ = "0.1.0"
__all__, __getattr__, __dir__ = lazy_names(__name__)
