# SPDX-License-Identifier: MIT
"""Features that a small network finds in pictures: EfficientNet-Lite0, trained on photographs.

The network and its licence (Apache-2.0) are in `shipped`; `python -m benchmarks network-weights` wrote it. It
runs on ONNX Runtime, in one thread: shapes are described in several processes side by side.
"""

from __future__ import annotations

import hashlib
from functools import cache
from importlib import resources
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from shapegoogle_core.errors import ModelError

if TYPE_CHECKING:
    from onnxruntime import InferenceSession

__all__ = ["FEATURES", "NETWORK_DIGEST", "network_features", "read_network"]

Floats = NDArray[np.float32]

FEATURES = 1280
"""Number of features of a picture."""

NETWORK_DIGEST = "211d71bfc5c71a86"
"""First 16 hexadecimal digits of the network's SHA-256; only features of the same network can be compared."""

# Pictures at once. The intermediate results of three fit into the processor's cache; of twelve they do not,
# and the same features take a fifth longer.
_BATCH = 3

# Errors only: warnings are about processors and graphics cards, and would reach the user's terminal.
_LOG_LEVEL = 3


def network_features(pictures: Floats) -> Floats:
    """Compute the network's features of pictures of normals.

    Parameters
    ----------
    pictures : (n, size, size, 3) array of float32
        From `normal_pictures`. The network sees them on white.

    Returns
    -------
    features : (n, 1280) array of float32
        Square roots of the means over each picture, so that few strong ones do not drown the others.

    Raises
    ------
    ModelError
        If the network's file is missing or damaged, or ONNX Runtime cannot be loaded.

    Examples
    --------
    >>> import numpy as np
    >>> from shapegoogle_core.views.network import network_features
    >>> network_features(np.zeros((2, 128, 128, 3), np.float32)).shape
    (2, 1280)
    """
    nothing = ~np.any(pictures, axis=3, keepdims=True)
    images = np.ascontiguousarray(np.moveaxis(pictures, 3, 1), np.float32)
    np.copyto(images, np.float32(1), where=np.moveaxis(nothing, 3, 1))
    session = _session()
    batches = [images[first : first + _BATCH] for first in range(0, len(images), _BATCH)]
    features = [session.run(["features"], {"pictures": batch})[0] for batch in batches]
    return np.asarray(np.sqrt(np.maximum(np.concatenate(features), 0)), np.float32)


@cache
def _session() -> InferenceSession:
    """Load the network, once in each process."""
    content = read_network()
    try:
        import onnxruntime
    except ImportError as error:
        raise ModelError(
            "the package onnxruntime, which describes pictures of shapes, is missing or does not fit this "
            "computer; install it again, for instance with: pip install --force-reinstall onnxruntime"
        ) from error
    # Releases for Windows report that they are used, unless told not to.
    onnxruntime.disable_telemetry_events()
    options = onnxruntime.SessionOptions()
    options.intra_op_num_threads = options.inter_op_num_threads = 1
    options.log_severity_level = _LOG_LEVEL
    return onnxruntime.InferenceSession(content, options, providers=["CPUExecutionProvider"])


def read_network() -> bytes:
    """Read the network, and check that it is whole.

    Returns
    -------
    content : bytes
        An ONNX model.

    Raises
    ------
    ModelError
        If the file is missing or damaged.
    """
    path = resources.files("shapegoogle_core") / "views" / "shipped" / "efficientnet_lite0.onnx"
    try:
        content = path.read_bytes()
    except OSError as error:
        raise ModelError(f"cannot read '{path}': {error.strerror}; install Shape Google again") from error
    if hashlib.sha256(content).hexdigest()[:16] != NETWORK_DIGEST:
        raise ModelError(f"'{path}' is damaged; install Shape Google again")
    return content
