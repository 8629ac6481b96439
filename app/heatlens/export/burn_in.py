"""Write frame, focus and f-stop into a picture, on a darkened strip at its lower edge."""

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from heatlens.model.lens import Lens
from heatlens.model.measured_distance import measured_text
from heatlens.model.timecode import Timecode
from heatlens.plate.plate import FloatImage, Plate

_TEXT_SHARE = 1 / 24  # text height, as a part of the picture's: legible on a phone
_LEAST_SIZE = 1.0  # FreeType has no smaller one
_STRIP_LIGHT = 0.35  # brightness of the picture behind the text, relative to its own


def burn_in_text(
    frame: int, lens: Lens, plate: Plate, unit: str, timecode: Timecode | None = None
) -> str:
    """Return `1001   10:00:00:00   focus 2.24 m   f/2.8`, without the timecode if there is none.

    The lens is left out if the plate holds circles of confusion.
    """
    counted = str(frame) if timecode is None else f"{frame}   {timecode}"
    if plate.coc_px is not None:
        return counted
    focus = measured_text(lens, lens.focus_distance_m, unit)
    return f"{counted}   focus {focus}   f/{lens.f_stop:.3g}"


def burned_in(display: FloatImage, text: str) -> FloatImage:
    """Return `display`, (H, W, 3) in 0..1, with `text`, which is smaller in a narrow picture."""
    height, width = display.shape[:2]
    mask = _mask(text, width, height * _TEXT_SHARE)[-height:]
    picture = display.copy()
    strip = picture[-mask.shape[0] :]
    strip *= _STRIP_LIGHT
    strip += mask[..., None] * (1.0 - strip)
    return picture


def _mask(text: str, width: int, size: float) -> FloatImage:
    """Return a strip (h, `width`) of 0..1, 1 in the letters."""
    font = _font(size)
    wide = font.getlength(text) + 2 * size
    if wide > width:
        size *= width / wide
        font = _font(size)
    ascent, descent = font.getmetrics()
    image = Image.new("L", (width, ascent + descent))
    ImageDraw.Draw(image).text((size, 0), text, fill=255, font=font)
    return np.asarray(image, np.float32) / np.float32(255)


def _font(size: float) -> ImageFont.FreeTypeFont:
    """Return the font that comes with Pillow, so that the text is the same on every machine."""
    font = ImageFont.load_default(max(_LEAST_SIZE, size))
    assert isinstance(font, ImageFont.FreeTypeFont)  # always so if a size is given
    return font
