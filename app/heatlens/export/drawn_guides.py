"""Draw guides into the pixels of an exported picture, as the window draws them over its own."""

import numpy as np
from PIL import Image

from heatlens.model.guides import LINE_OPACITY, NO_GUIDES, Guides, Rect, guide_shapes
from heatlens.plate.plate import FloatImage

_LINE_SHARE = 1 / 720  # thickness of a line as a part of the picture's height


def with_guides(display: FloatImage, guides: Guides, pixel_aspect: float) -> FloatImage:
    """Return `display`, (H, W, 3) in 0..1, with the guides drawn into it.

    `pixel_aspect` is that of the file. A desqueeze widens the picture by its factor.
    """
    if guides == NO_GUIDES:
        return display
    if guides.desqueeze is not None:
        display, pixel_aspect = _stretched(display, guides.desqueeze), 1.0
    picture = display.copy()
    height, width = picture.shape[:2]
    shapes = guide_shapes(guides, (0.0, 0.0, width * pixel_aspect, float(height)))
    for rect in shapes.shades:
        x0, y0, x1, y1 = (round(value) for value in _in_pixels(rect, pixel_aspect))
        picture[y0:y1, x0:x1] *= np.float32(1.0 - guides.opacity)
    lines = [*shapes.lines, *(side for frame in shapes.frames for side in _sides(frame))]
    _draw_lines(picture, [_in_pixels(line, pixel_aspect) for line in lines], pixel_aspect)
    return picture


def _stretched(display: FloatImage, across: float) -> FloatImage:
    """Return the picture widened by the factor `across`; overshoot at edges is clipped."""
    height, width = display.shape[:2]
    size = max(1, round(width * across)), height
    planes = [
        np.asarray(Image.fromarray(display[..., i]).resize(size, Image.Resampling.LANCZOS))
        for i in range(3)
    ]
    stretched: FloatImage = np.clip(np.stack(planes, axis=-1), 0.0, 1.0, dtype=np.float32)
    return stretched


def _in_pixels(rect: Rect, pixel_aspect: float) -> Rect:
    return rect[0] / pixel_aspect, rect[1], rect[2] / pixel_aspect, rect[3]


def _sides(rect: Rect) -> tuple[Rect, ...]:
    x0, y0, x1, y1 = rect
    return (x0, y0, x1, y0), (x0, y1, x1, y1), (x0, y0, x0, y1), (x1, y0, x1, y1)


def _draw_lines(picture: FloatImage, lines: list[Rect], pixel_aspect: float) -> None:
    """Mix white into the pixels of all lines, once where two of them cross."""
    height, width = picture.shape[:2]
    thick = height * _LINE_SHARE
    mask = np.zeros((height, width), bool)
    for x0, y0, x1, y1 in lines:
        columns = _span(x0, x1, thick / pixel_aspect, width)
        mask[_span(y0, y1, thick, height), columns] = True
    picture[mask] += np.float32(LINE_OPACITY) * (1.0 - picture[mask])


def _span(first: float, last: float, thick: float, end: int) -> slice:
    """Return the pixels from `first` to `last`, at least one and within the picture."""
    count = max(1, round(max(last - first, thick)))
    start = round(first if last > first else first - count / 2)
    start = min(max(start, 0), end - 1)
    return slice(start, min(start + count, end))
