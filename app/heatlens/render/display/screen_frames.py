"""Keep rendered frames as display values, so that playback need not transform them again.

This is for software rasterisers, on which the view transform of a frame takes longer than the frame
lasts; a GPU does it in less than a millisecond.
"""

from collections.abc import Callable, Collection
from dataclasses import dataclass

from heatlens.render.gpu.device import Device, Texture

ScreenLook = tuple[object, ...]
Draw = Callable[[Texture], None]

MOST_BYTES = 512 << 20


@dataclass(eq=False)
class _Frame:
    texture: Texture
    look: ScreenLook


# The view transform of 1920x1080 takes llvmpipe 94 to 257 ms, more than a frame lasts. What goes
# first is not the least recently used: the caller names what will be played, only other frames make
# room, and a frame that does not fit is refused, so that the others stay.
class ScreenFrames:
    """Textures by the key of their frame, within a limit of bytes."""

    def __init__(self, ctx: Device, most_bytes: int = MOST_BYTES) -> None:
        self._ctx = ctx
        self.most_bytes = most_bytes
        self._held: dict[str, _Frame] = {}
        self.bytes_in_use = 0

    def holds(self, key: str, look: ScreenLook) -> bool:
        """Return True if the frame is kept with this look."""
        return key in self._held and self._held[key].look == look

    def has_room(self, key: str, size: tuple[int, int], wanted: Collection[str]) -> bool:
        """Return True if a frame of this size fits after removing unwanted ones."""
        if key in self._held:
            return True
        kept = sum(_bytes(self._held[it].texture.size) for it in self._held if it in wanted)
        return kept + _bytes(size) <= self.most_bytes

    def texture(
        self, key: str, look: ScreenLook, size: tuple[int, int], wanted: Collection[str], draw: Draw
    ) -> Texture | None:
        """Return the frame, drawn by `draw` if it is missing; None if it does not fit.

        Frames that are not `wanted` are removed to make room.
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
        """Remove all frames."""
        for key in tuple(self._held):
            self._drop(key)

    def _make_room(self, size: tuple[int, int], wanted: Collection[str]) -> None:
        for key in [it for it in self._held if it not in wanted]:
            if self.bytes_in_use + _bytes(size) <= self.most_bytes:
                return
            self._drop(key)

    def _new(self, size: tuple[int, int]) -> Texture:
        texture = self._ctx.texture(size, 4)
        texture.build_mipmaps()  # a texture with missing levels would be black
        texture.repeats = False
        texture.label = "frame on the screen"
        return texture

    def _drop(self, key: str) -> None:
        frame = self._held.pop(key)
        self.bytes_in_use -= _bytes(frame.texture.size)
        frame.texture.release()


def _bytes(size: tuple[int, int]) -> int:
    """Return the bytes of an RGBA8 texture, with a third more for the mipmaps."""
    return size[0] * size[1] * 16 // 3
