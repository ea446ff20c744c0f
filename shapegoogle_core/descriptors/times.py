# SPDX-License-Identifier: MIT
"""Default times of heat kernel signatures."""

from __future__ import annotations

import math

import numpy as np

from shapegoogle_core.api.arguments import check_count
from shapegoogle_core.errors import MeshError
from shapegoogle_core.mesh.mesh import FloatArray
from shapegoogle_core.spectral import Spectrum, check_spectrum

__all__ = ["default_exponents", "default_times", "time_at", "time_range"]

# At t = 4 ln 10 / λ the weight exp(-λt) has fallen to 1e-4 (Sun et al. 2009, section 4.3).
_DECAY = 4 * math.log(10)
# log2 t of the scale-invariant signature for a shape of area 1: start, end and step, as in the default model.
_EXPONENTS = (-13.0, 0.0, 0.125)


def time_range(spectrum: Spectrum) -> tuple[float, float]:
    """Shortest and longest time that tell vertices apart: 4 ln 10 / λ_k and 4 ln 10 / λ_2 (Sun et al. 2009).

    Parameters
    ----------
    spectrum : Spectrum
        Eigenpairs of the shape.

    Returns
    -------
    shortest, longest : float
        In squared mesh units. At shorter times the eigenpairs that were left out count, after longer ones all
        heat is spread evenly. λ_2 is the first positive eigenvalue.

    Raises
    ------
    ValueError
        If the spectrum is not a `Spectrum`.
    MeshError
        If all eigenvalues are 0: the shape has as many loose parts as the spectrum has eigenpairs, or more.

    Examples
    --------
    >>> import numpy as np
    >>> from shapegoogle_core.descriptors import time_range
    >>> from shapegoogle_core.spectral import Spectrum, check_spectrum
    >>> spectrum = Spectrum(np.array([0.0, 1.0, 10.0]), np.eye(3), np.ones(3))
    >>> shortest, longest = time_range(spectrum)
    >>> round(shortest, 3), round(longest, 3)
    (0.921, 9.21)
    """
    check_spectrum(spectrum)
    last = float(spectrum.eigenvalues[-1])
    # Each connected component has an eigenvalue 0.
    positive = spectrum.eigenvalues[spectrum.eigenvalues > 1e-8 * last] if last > 0 else np.empty(0)
    if not len(positive):
        count = len(spectrum.eigenvalues)
        raise MeshError(
            f"all {count} eigenvalues of the spectrum are 0, as the shape has {count} or more loose parts; "
            "compute more eigenpairs, or separate the parts"
        )
    return _DECAY / last, _DECAY / float(positive[0])


def time_at(spectrum: Spectrum, scale: float) -> float:
    """Time at a place in the range of times of a spectrum.

    Parameters
    ----------
    spectrum : Spectrum
        Eigenpairs of the shape.
    scale : float
        From 0 (shortest time of `time_range`) to 1 (longest), logarithmic in between.

    Returns
    -------
    time : float
        In squared mesh units. Heat has then spread over a distance of about its square root.

    Raises
    ------
    ValueError
        If the spectrum is not a `Spectrum`.
    MeshError
        If all eigenvalues are 0, see `time_range`.
    """
    shortest, longest = time_range(spectrum)
    return float(shortest * (longest / shortest) ** scale)


def default_times(spectrum: Spectrum, count: int = 100) -> FloatArray:
    """Space times of a heat kernel signature evenly on a logarithmic scale over `time_range`.

    Parameters
    ----------
    spectrum : Spectrum
        Eigenpairs of the shape.
    count : int
        Number of times; 100 as in Sun et al. (2009).

    Returns
    -------
    times : (count,) array
        Ascending, in squared mesh units.

    Raises
    ------
    ValueError
        If the spectrum is not a `Spectrum`, or the count is not a whole number ≥ 1.
    MeshError
        If all eigenvalues are 0, see `time_range`.

    Examples
    --------
    >>> import numpy as np
    >>> from shapegoogle_core.descriptors import default_times
    >>> from shapegoogle_core.spectral import Spectrum, check_spectrum
    >>> spectrum = Spectrum(np.array([0.0, 1.0, 100.0]), np.eye(3), np.ones(3))
    >>> default_times(spectrum, 3).round(3).tolist()
    [0.092, 0.921, 9.21]
    """
    check_count("count", count)
    return np.array([time_at(spectrum, float(scale)) for scale in np.linspace(0, 1, count)])


def default_exponents(area: float, alpha: float = 2.0) -> FloatArray:
    """Exponents τ of the times t = α^τ of the scale-invariant signature, for a shape of a given area.

    They follow the area, so that a shape of another size is seen at the same share of its truncated spectrum:
    the scale-invariant signature of a shape twice as large is then the same up to rounding.

    Parameters
    ----------
    area : float
        In squared mesh units.
    alpha : float
        α > 1.

    Returns
    -------
    exponents : (s,) array
        Evenly spaced, ascending.

    Examples
    --------
    >>> from shapegoogle_core.descriptors import default_exponents
    >>> exponents = default_exponents(area=4.0)
    >>> float(exponents[0]), float(exponents[-1]), len(exponents)
    (-11.0, 2.0, 105)
    """
    start, end, step = _EXPONENTS
    return (math.log2(area) + np.arange(start, end + step / 2, step)) / math.log2(alpha)
