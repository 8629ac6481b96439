"""Interface scale per screen, and panel layouts that follow it.

Panels keep their size in letters and not in pixels: ImGui writes pixels, and `scaled_layout` turns
them into those of another screen.
"""

import re
from collections.abc import Mapping

SCALES = (0.75, 0.9, 1.0, 1.1, 1.25, 1.5, 1.75, 2.0, 2.5, 3.0)
_PIXELS = re.compile(r"\b(Pos|Size|SizeRef)=(-?\d+),(-?\d+)")
_SCREENS_MOST = 20


def scaled_layout(layout: str, factor: float) -> str:
    """Return an ImGui layout (ini text) with all pixel values multiplied by `factor`."""
    if factor == 1.0:
        return layout

    def scale_pixels(pixels: re.Match[str]) -> str:
        return f"{pixels[1]}={round(int(pixels[2]) * factor)},{round(int(pixels[3]) * factor)}"

    return _PIXELS.sub(scale_pixels, layout)


def next_scale(scale: float, steps: int) -> float:
    """Return the scale that is `steps` larger, or smaller if `steps` is negative."""
    nearest = min(range(len(SCALES)), key=lambda index: abs(SCALES[index] - scale))
    return SCALES[min(max(nearest + steps, 0), len(SCALES) - 1)]


def with_scale(scales: Mapping[str, float], screen: str, scale: float) -> dict[str, float]:
    """Return the scales by screen name with that of one screen changed; a scale of 1 is dropped."""
    other_scales = {name: value for name, value in scales.items() if name != screen}
    remembered = {**other_scales, screen: scale} if scale != 1.0 else other_scales
    return dict(list(remembered.items())[-_SCREENS_MOST:])


def fitted_size(size: tuple[int, int], area: tuple[int, int]) -> tuple[int, int]:
    """Return the window size limited to the usable area of a screen."""
    return min(size[0], area[0]), min(size[1], area[1])
