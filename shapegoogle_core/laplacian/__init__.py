# SPDX-License-Identifier: MIT
"""Discrete Laplace–Beltrami operators (paper, section 3.3).

Sign convention: the operator is positive semi-definite, so its eigenvalues are ≥ 0.
"""

from shapegoogle_core.laplacian.cotangent import cotangent, cotangent_voronoi
from shapegoogle_core.laplacian.fem import fem1, fem2, fem3
from shapegoogle_core.laplacian.heat_step import factor_definite, heat_step
from shapegoogle_core.laplacian.operator import BOUNDARIES, Operator
from shapegoogle_core.laplacian.registry import LAPLACIANS, POINT_CLOUD, build_operator
from shapegoogle_core.laplacian.tufted import point_cloud, robust

__all__ = [
    "BOUNDARIES",
    "LAPLACIANS",
    "POINT_CLOUD",
    "Operator",
    "build_operator",
    "cotangent",
    "cotangent_voronoi",
    "factor_definite",
    "fem1",
    "fem2",
    "fem3",
    "heat_step",
    "point_cloud",
    "robust",
]
