"""A finished picture on its way to browsers, and its encoding, once for each size and quality."""

from dataclasses import dataclass, field
from io import BytesIO
from threading import Lock

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from heatlens.core.model.boxes import Box
from heatlens.media.plate.picture.picture_write import scaled_window

# The widths of encoded pictures go in steps, and few of them are kept. Otherwise a client that
# requests every width would fill the memory.
_WIDTH_STEP = 160  # pixels; clients scale what they get to what they show
_MOST_ENCODED = 8  # sizes of a picture that are kept
Pixels = NDArray[np.uint8]


@dataclass(frozen=True, slots=True)
class Coding:
    """The coding of a sent picture: its largest width in pixels, and the JPEG quality.

    A quality of None stands for PNG.
    """

    width: int
    quality: int | None


@dataclass(eq=False)
class Picture:
    """The pixels of the display window, (H, W, 4) display values, and the frame that they show.

    number       counts the pictures of a server
    is_whole     True for a picture at rest in the quality of `heatlens render`, sent without loss
    lens_number  that of the state whose lens and frame it shows; 0 if a picture of these follows
    """

    number: int
    frame: int
    pixels: Pixels
    is_whole: bool
    lens_number: int = 0
    _encoded: dict[Coding, bytes] = field(default_factory=dict)
    _lock: Lock = field(default_factory=Lock)

    def encode(self, coding: Coding) -> bytes:
        """Return the picture as a PNG or JPEG file, encoded once for all clients.

        Its width is rounded up to a multiple of `_WIDTH_STEP`, to limit the number of widths.
        """
        with self._lock:  # other clients wait for the result instead of encoding it again
            step = -(-coding.width // _WIDTH_STEP) * _WIDTH_STEP
            coding = Coding(min(step, self.pixels.shape[1]), coding.quality)
            file = self._encoded.pop(coding, None) or _encode(self.pixels, coding)
            self._encoded[coding] = file  # the latest last
            while len(self._encoded) > _MOST_ENCODED:
                del self._encoded[next(iter(self._encoded))]
            return file


def _encode(pixels: Pixels, coding: Coding) -> bytes:
    """Return pixels as a PNG or JPEG file, at most as wide as `coding` says."""
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


def crop_to_display(pixels: Pixels, data: Box, display: Box) -> Pixels:
    """Return the pixels of the display window from those of the data window, at any scale.

    Pixels outside the data window are 0.
    """
    if data == display:
        return pixels
    height, width = pixels.shape[:2]
    scale = width / data.width
    data_px, display_px = scaled_window(data, scale, (width, height)), scaled_window(display, scale)
    common_px = data_px.intersection(display_px)
    display_pixels = np.zeros((*display_px.shape, pixels.shape[2]), np.uint8)
    shown = common_px.relative_to(display_px).slices
    display_pixels[shown] = pixels[common_px.relative_to(data_px).slices]
    return display_pixels


@dataclass
class ConnectionSpeed:
    """Chooses size and quality for a client's connection by how soon pictures are acknowledged.

    There are few levels of (scale, JPEG quality), because clients then share encoded pictures.
    """

    _level: int = 1
    _levels: tuple[tuple[float, int], ...] = ((1.0, 92), (1.0, 80), (0.7, 75), (0.5, 70), (0.3, 60))
    _slow_s: float = 0.15
    _fast_s: float = 0.04

    def coding(self, width: int, is_whole: bool) -> Coding:
        """Return how to send a picture to a client that shows it `width` pixels wide."""
        if is_whole:
            return Coding(width, None)
        share, quality = self._levels[self._level]
        return Coding(max(16, round(width * share)), quality)

    def note_round_trip(self, seconds: float) -> None:
        """Note the time from sending a picture to its acknowledgement."""
        if seconds > self._slow_s:
            self._level = min(self._level + 1, len(self._levels) - 1)
        elif seconds < self._fast_s:
            self._level = max(self._level - 1, 0)
