"""A list of pixels on the GPU that a later pass runs on alone (lib/pixel_list.lib.glsl)."""

import struct

import moderngl

_HEAD = struct.pack("4I", 0, 1, 1, 0)  # workgroups x, y, z of the later pass; count


def list_bytes(size: tuple[int, int]) -> int:
    """Bytes of a list that can hold every pixel of a picture."""
    return len(_HEAD) + 4 * size[0] * size[1]


def clear_list(pixels: moderngl.Buffer) -> None:
    """Empty the list; before the pass that appends to it."""
    pixels.write(_HEAD)
