"""Keep rendered frames as display values, so that playback need not transform them again.

This is for software rasterizers, on which the view transform of a frame takes longer than the frame
lasts; a GPU does it in less than a millisecond.
"""

from collections.abc import Callable, Collection
from dataclasses import dataclass
from typing import NamedTuple

from heatlens.render.gpu.device import Device
from heatlens.render.gpu.resources import Texture

Draw = Callable[[Texture], None]  # draws the display values of a frame into a texture

MOST_BYTES = 512 << 20  # memory of all cached frames


class ScreenTransform(NamedTuple):
    """All that decides how scene-linear light looks on the screen."""

    exposure_stops: float
    gamma: float
    transform_version: int  # of the view transform
    has_mipmaps: bool  # smaller levels, for a picture that is drawn much smaller


@dataclass(eq=False)
class _Frame:
    """The display values of a frame, and the look with which they were drawn."""

    texture: Texture
    transform: ScreenTransform | None  # None until it is drawn


# The view transform of 1920x1080 takes llvmpipe 94 to 257 ms, more than a frame lasts. The caller
# names the frames that will be played. Only other frames are removed, in place of the least
# recently used ones, and a frame that does not fit is refused.
class ScreenFrames:
    """Textures by the key of their frame, within a limit of bytes."""

    def __init__(self, ctx: Device, most_bytes: int = MOST_BYTES) -> None:
        self._ctx = ctx
        self.most_bytes = most_bytes
        self._frames: dict[str, _Frame] = {}
        self.bytes_in_use = 0

    def has_frame(self, key: str, transform: ScreenTransform) -> bool:
        """Return True if the frame is kept with this look."""
        return key in self._frames and self._frames[key].transform == transform

    def can_fit(self, key: str, size: tuple[int, int], planned: Collection[str]) -> bool:
        """Return True if a frame of this size fits beside the cached frames among `planned`.

        `planned` are the keys of the frames that will be played.
        """
        if key in self._frames:
            return True
        planned_bytes = sum(
            _bytes(self._frames[planned_key].texture.size)
            for planned_key in self._frames
            if planned_key in planned
        )
        return planned_bytes + _bytes(size) <= self.most_bytes

    def texture(
        self,
        key: str,
        transform: ScreenTransform,
        size: tuple[int, int],
        planned: Collection[str],
        draw: Draw,
    ) -> Texture | None:
        """Return the frame, drawn by `draw` if it is missing; None if it does not fit.

        Frames that are not `planned` are removed to free memory.
        """
        if key in self._frames and self._frames[key].texture.size != size:
            self._drop(key)
        if key not in self._frames:
            if not self.can_fit(key, size, planned):
                return None
            self._free_memory(size, planned)
            self._frames[key] = _Frame(self._new_texture(size), None)
            self.bytes_in_use += _bytes(size)
        frame = self._frames[key]
        if frame.transform != transform:
            draw(frame.texture)
            frame.transform = transform
        return frame.texture

    def clear(self) -> None:
        """Remove all frames."""
        for key in tuple(self._frames):
            self._drop(key)

    def _free_memory(self, size: tuple[int, int], planned: Collection[str]) -> None:
        """Remove frames that are not `planned` until a frame of this size fits."""
        for key in [frame_key for frame_key in self._frames if frame_key not in planned]:
            if self.bytes_in_use + _bytes(size) <= self.most_bytes:
                return
            self._drop(key)

    def _new_texture(self, size: tuple[int, int]) -> Texture:
        """Return a new RGBA8 texture."""
        texture = self._ctx.texture(size, 4)
        texture.repeats = False
        texture.label = "frame on the screen"
        return texture

    def _drop(self, key: str) -> None:
        """Remove a frame, and release its texture."""
        frame = self._frames.pop(key)
        self.bytes_in_use -= _bytes(frame.texture.size)
        frame.texture.release()


def _bytes(size: tuple[int, int]) -> int:
    """Return the bytes of an RGBA8 texture, with a third more for the mipmaps."""
    return size[0] * size[1] * 16 // 3
