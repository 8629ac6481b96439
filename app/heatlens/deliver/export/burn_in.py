"""Write frame, timecode and lens into a picture, on a darkened strip at its lower edge."""

import re
from functools import cache
from typing import TYPE_CHECKING

import numpy as np

from heatlens.core.base.errors import InputError
from heatlens.core.base.paths import data_dir
from heatlens.core.model.lens.lens import Lens, measured_text
from heatlens.core.model.timecode import Timecode
from heatlens.media.plate.plate import FloatImage, Plate

if TYPE_CHECKING:  # few pictures get a burn-in
    from PIL import ImageFont

FIELDS = ("frame", "timecode", "focus", "f_stop", "shot")
DEFAULT_TEMPLATE = "F {frame}   {timecode}   {focus}   f/{f_stop}   {shot}"
_TEXT_SHARE = 1 / 24  # text height, as a part of the picture's: legible on a phone
_LEAST_SIZE = 1.0  # FreeType has no smaller one
_STRIP_LIGHT = 0.35  # brightness of the picture behind the text, relative to its own
_FIELD = re.compile(r"\{([^{}]*)\}")


def check_template(template: str) -> str:
    """Return the template unchanged. Raises InputError if it names an unknown field."""
    unknown = [name for name in _FIELD.findall(template) if name not in FIELDS]
    if unknown:
        known = ", ".join(f"{{{name}}}" for name in FIELDS)
        raise InputError(f"The burn-in has no {{{unknown[0]}}}; it has {known}.")
    return template


def burn_in_text(
    template: str,
    frame: int,
    lens: Lens,
    plate: Plate,
    unit: str,
    timecode: Timecode | None = None,
    shot: str = "",
) -> str:
    """Return the template with its fields filled in, for example `F 1001   2.24 m   f/2.8`.

    Two or more spaces separate the parts of the template; a part is left out if one of its fields
    is empty. Plates that hold circles of confusion have no lens values.
    """
    field_values = {"frame": str(frame), "timecode": str(timecode or ""), "shot": shot}
    has_lens = plate.coc_px is None
    field_values["focus"] = measured_text(lens, lens.focus_distance_m, unit) if has_lens else ""
    field_values["f_stop"] = f"{lens.f_stop:.3g}" if has_lens else ""
    parts = re.split(r"(\s{2,})", template)  # parts and the gaps between them
    text = ""
    for gap, part in zip(["", *parts[1::2]], parts[::2], strict=True):
        if all(field_values[name] for name in _FIELD.findall(part)):
            filled = _FIELD.sub(lambda match: field_values[match[1]], part)
            text += (gap if text else "") + filled
    return text


def draw_burn_in(display: FloatImage, text: str) -> FloatImage:
    """Return a copy of `display`, (H, W, 3) in 0..1, with `text` on a dark strip at its lower edge.

    The text is smaller in a narrow picture, so that it fits.
    """
    height, width = display.shape[:2]
    text_mask = _text_strip(text, width, height * _TEXT_SHARE)[-height:]
    picture = display.copy()
    strip = picture[-text_mask.shape[0] :]
    strip *= _STRIP_LIGHT
    strip += text_mask[..., None] * (1.0 - strip)
    return picture


def _text_strip(text: str, width: int, size: float) -> FloatImage:
    """Return `text` as a coverage mask (h, `width`) in 0..1: 1 in the letters, 0 around them."""
    from PIL import Image, ImageDraw

    font = _font(size)
    needed_width = font.getlength(text) + 2 * size
    if needed_width > width:
        size *= width / needed_width
        font = _font(size)
    ascent, descent = font.getmetrics()
    image = Image.new("L", (width, ascent + descent))
    ImageDraw.Draw(image).text((size, 0), text, fill=255, font=font)
    return np.asarray(image, np.float32) / np.float32(255)


@cache
def _font(size: float) -> "ImageFont.FreeTypeFont":
    """Return a font that comes with heatlens, so that the text is the same on every machine.

    All of its characters are as wide as a space, so that numbers stand still from frame to frame.
    """
    from PIL import ImageFont

    path = data_dir("assets") / "fonts" / "DejaVuSansMono.ttf"
    basic = ImageFont.Layout.BASIC
    return ImageFont.truetype(path, max(_LEAST_SIZE, size), layout_engine=basic)
