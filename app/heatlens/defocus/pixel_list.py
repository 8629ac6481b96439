"""Manage GPU lists of pixels, for passes that process only these (lib/pixel_list.lib.glsl)."""

import struct
from collections.abc import Iterator

import moderngl

WHOLE_LIST: dict[str, object] = {"list_slice": (0, 1)}  # see lib/list_slice.lib.glsl
_HEAD = struct.pack("4I", 0, 1, 1, 0)  # workgroups x, y, z of the later pass; count


def list_bytes(size: tuple[int, int]) -> int:
    """Return the bytes of a list with room for every pixel of a picture."""
    return len(_HEAD) + 4 * size[0] * size[1]


def clear_list(pixels: moderngl.Buffer) -> None:
    """Empty the list; call this before the pass that appends to it."""
    pixels.write(_HEAD)


_PIXELS_A_SLICE = 1 << 19  # pixels of the picture per part: some ten milliseconds without a GPU


def slice_count(size: tuple[int, int]) -> int:
    """Return the number of parts of a long pass, between which a window can handle input."""
    return max(1, -(-size[0] * size[1] // _PIXELS_A_SLICE))


def slices(size: tuple[int, int]) -> Iterator[dict[str, object]]:
    """Yield the uniform of each part, see lib/list_slice.lib.glsl."""
    count = slice_count(size)
    for part in range(count):
        yield {"list_slice": (part, count)}
