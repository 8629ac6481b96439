"""A finished picture on its way to browsers, and its encoding, once for each size and quality."""

from dataclasses import dataclass, field
from io import BytesIO
from threading import Lock

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from heatlens.core.model.boxes import Box
from heatlens.media.plate.picture.picture_write import scaled_window

# A client that asked for each width once kept an encoded picture of each. Widths go in steps, and
# few are kept.
_WIDTH_STEP = 160  # pixels; clients scale what they get to what they show
_ENCODED_MOST = 8  # sizes of a picture that are kept
Pixels = NDArray[np.uint8]


@dataclass(frozen=True, slots=True)
class Coding:
    """How a picture is sent: `width` in pixels at most, and the quality of JPEG, None for PNG."""

    width: int
    quality: int | None


@dataclass(eq=False)
class Picture:
    """The pixels of the display window, (H, W, 4) display values, and what they show.

    number    counts the pictures of a server
    is_whole  it is what `heatlens render` makes, and nothing moves: worth sending without loss
    """

    number: int
    frame: int
    pixels: Pixels
    is_whole: bool
    _encoded: dict[Coding, bytes] = field(default_factory=dict)
    _lock: Lock = field(default_factory=Lock)

    def coded(self, coding: Coding) -> bytes:
        """Return the picture as a PNG or JPEG file, encoded once for all clients.

        Its width is the next step above that of `coding`, so that widths are few.
        """
        with self._lock:  # other clients wait for the result instead of encoding it again
            step = -(-coding.width // _WIDTH_STEP) * _WIDTH_STEP
            coding = Coding(min(step, self.pixels.shape[1]), coding.quality)
            file = self._encoded.pop(coding, None) or _encoded(self.pixels, coding)
            self._encoded[coding] = file  # the latest last
            while len(self._encoded) > _ENCODED_MOST:
                del self._encoded[next(iter(self._encoded))]
            return file


def _encoded(pixels: Pixels, coding: Coding) -> bytes:
    picture = Image.fromarray(np.ascontiguousarray(pixels[..., :3]))
    if coding.width < picture.width:
        height = max(1, round(picture.height * coding.width / picture.width))
        picture = picture.resize((coding.width, height), Image.Resampling.BOX, reducing_gap=2.0)
    file = BytesIO()
    if coding.quality is None:
        picture.save(file, "PNG", compress_level=1)
    else:
        picture.save(file, "JPEG", quality=coding.quality, subsampling=1)
    return file.getvalue()


def in_display(pixels: Pixels, data: Box, display: Box) -> Pixels:
    """Return pixels over the data window, at any scale, as those over the display window."""
    if data == display:
        return pixels
    height, width = pixels.shape[:2]
    scale = width / data.width
    have, want = scaled_window(data, scale, (width, height)), scaled_window(display, scale)
    both = have.intersection(want)
    shown = np.zeros((*want.shape, pixels.shape[2]), np.uint8)
    shown[_part(both, want)] = pixels[_part(both, have)]
    return shown


def _part(box: Box, of: Box) -> tuple[slice, slice]:
    return (
        slice(box.y0 - of.y0, box.y1 - of.y0),
        slice(box.x0 - of.x0, box.x1 - of.x0),
    )


@dataclass
class Line:
    """What a client's line carries, measured by how soon pictures are acknowledged.

    The rungs are few, so that clients share encoded pictures.
    """

    _rung: int = 1
    _rungs: tuple[tuple[float, int], ...] = ((1.0, 92), (1.0, 80), (0.7, 75), (0.5, 70), (0.3, 60))
    _slow_s: float = 0.15
    _quick_s: float = 0.04

    def coding(self, width: int, is_whole: bool) -> Coding:
        """Return how to send a picture to a client that shows it `width` pixels wide."""
        if is_whole:
            return Coding(width, None)
        share, quality = self._rungs[self._rung]
        return Coding(max(16, round(width * share)), quality)

    def arrived(self, seconds: float) -> None:
        """Note the time from sending a picture to its acknowledgement."""
        if seconds > self._slow_s:
            self._rung = min(self._rung + 1, len(self._rungs) - 1)
        elif seconds < self._quick_s:
            self._rung = max(self._rung - 1, 0)
