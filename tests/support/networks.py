"""Small networks in ONNX files, which compute a depth from the picture in a known way."""

from pathlib import Path

import numpy as np
import onnx
from onnx import TensorProto, helper, numpy_helper

# Weights of red, green and blue, whose sum of products is what a network gives.
RED = (1.0, 0.0, 0.0)


def write_network(
    path: Path,
    weights=RED,
    bias: float = 0.0,
    size: tuple[int | str, int | str] = ("h", "w"),
    reach: int = 0,
    channels: int = 3,
) -> Path:
    """Write a network of a weighted sum of the colors, averaged over 2 reach + 1 pixels."""
    side = 2 * reach + 1
    kernel = np.zeros((1, channels, side, side), np.float32)
    kernel[0, :, :, :] = np.array(weights, np.float32)[:channels, None, None] / side**2
    nodes = [
        helper.make_node("Pad", ["picture", "pads"], ["padded"], mode="edge"),
        helper.make_node("Conv", ["padded", "kernel", "bias"], ["depth"]),
    ]
    pads = np.array([0, 0, reach, reach, 0, 0, reach, reach], np.int64)
    graph = helper.make_graph(
        nodes,
        "depth",
        [helper.make_tensor_value_info("picture", TensorProto.FLOAT, [1, channels, *size])],
        [helper.make_tensor_value_info("depth", TensorProto.FLOAT, [1, 1, *size])],
        [
            numpy_helper.from_array(kernel, "kernel"),
            numpy_helper.from_array(np.array([bias], np.float32), "bias"),
            numpy_helper.from_array(pads, "pads"),
        ],
    )
    model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", 18)])
    model.ir_version = 9
    onnx.save(model, str(path))
    return path
