"""Rendered frames in the colours of the screen, so that a frame played again is drawn no more.

For software rasterisers, where the view transform of one frame takes longer than a frame of the
film; a GPU does it in less than a millisecond.
"""

from collections.abc import Callable, Collection
from dataclasses import dataclass

import moderngl

Look = tuple[object, ...]
Draw = Callable[[moderngl.Texture], None]

MOST_BYTES = 512 << 20


@dataclass(eq=False)
class _Frame:
    texture: moderngl.Texture
    look: Look


class ScreenFrames:
    """Textures by the key of their frame, within a bound of bytes."""

    def __init__(self, ctx: moderngl.Context, most_bytes: int = MOST_BYTES) -> None:
        self._ctx = ctx
        self.most_bytes = most_bytes
        self._held: dict[str, _Frame] = {}
        self.bytes_in_use = 0

    def holds(self, key: str, look: Look) -> bool:
        """Return True where the frame is there in these colours."""
        return key in self._held and self._held[key].look == look

    def has_room(self, key: str, size: tuple[int, int], wanted: Collection[str]) -> bool:
        """Return True where a frame of this size fits, after the removal of unwanted ones."""
        if key in self._held:
            return True
        kept = sum(_bytes(self._held[it].texture.size) for it in self._held if it in wanted)
        return kept + _bytes(size) <= self.most_bytes

    def texture(
        self, key: str, look: Look, size: tuple[int, int], wanted: Collection[str], draw: Draw
    ) -> moderngl.Texture | None:
        """Return the frame, drawn by `draw` where it is missing; None without room for it.

        Frames that are not `wanted` are removed for it.
        """
        if key in self._held and self._held[key].texture.size != size:
            self._drop(key)
        if key not in self._held:
            if not self.has_room(key, size, wanted):
                return None
            self._make_room(size, wanted)
            self._held[key] = _Frame(self._new(size), ())
            self.bytes_in_use += _bytes(size)
        frame = self._held[key]
        if frame.look != look:
            draw(frame.texture)
            frame.look = look
        return frame.texture

    def clear(self) -> None:
        """Let go of every frame."""
        for key in tuple(self._held):
            self._drop(key)

    def _make_room(self, size: tuple[int, int], wanted: Collection[str]) -> None:
        for key in [it for it in self._held if it not in wanted]:
            if self.bytes_in_use + _bytes(size) <= self.most_bytes:
                return
            self._drop(key)

    def _new(self, size: tuple[int, int]) -> moderngl.Texture:
        texture = self._ctx.texture(size, 4)
        texture.build_mipmaps()  # without all levels a texture that asks for them is black
        texture.repeat_x = texture.repeat_y = False
        texture.label = "frame on the screen"
        return texture

    def _drop(self, key: str) -> None:
        frame = self._held.pop(key)
        self.bytes_in_use -= _bytes(frame.texture.size)
        frame.texture.release()


def _bytes(size: tuple[int, int]) -> int:
    """Return the bytes of four a pixel, and a third more for the mipmaps."""
    return size[0] * size[1] * 16 // 3
