"""The circle of confusion of each pixel of a plate, and the focus with which one is sharp."""

from dataclasses import replace

from heatlens.model.focus.coc import CocLine, coc_line
from heatlens.model.focus.lean import Lean, lean_of
from heatlens.model.lens.lens import Lens
from heatlens.plate.focus_pick import depth_at_m
from heatlens.plate.plate import Plate

_AT_INFINITY = 1e-4  # dioptres


def line_of(plate: Plate, lens: Lens) -> CocLine:
    """Return the line of a lens, whose lean counts pixels from the corner of the data window."""
    return replace(coc_line(lens, plate.display_window.width), lean=lean_in(plate, lens))


def lean_in(plate: Plate, lens: Lens) -> Lean:
    """Return where the focus is nearer, in pixels from the corner of the data window."""
    shown, data = plate.display_window, plate.data_window
    lean = lean_of(lens, (shown.width, shown.height), plate.pixel_aspect_ratio)
    return lean.moved((shown.x0 - data.x0, shown.y0 - data.y0))


def focused_at_pixel(plate: Plate, lens: Lens, x: int, y: int) -> Lens:
    """Return the lens focused on what pixel (x, y) of the display window shows.

    A lens that leans focuses at infinity where it cannot be sharp there. Raises InputError outside
    the picture, and for a plate without distances.
    """
    shown, data, depth_m = plate.display_window, plate.data_window, depth_at_m(plate, x, y)
    pixel = x + shown.x0 - data.x0, y + shown.y0 - data.y0
    return sharp_at(lens, lean_in(plate, lens), pixel, depth_m)


def sharp_at(lens: Lens, lean: Lean, pixel: tuple[float, float], depth_m: float) -> Lens:
    """Return the lens focused so that a depth is sharp at a pixel, or at infinity if it cannot be.

    `lean` counts pixels from the same corner.
    """
    if lean.is_level:
        return replace(lens, focus_distance_m=depth_m)
    nearer = float(lean.dioptres_at(pixel[0] + 0.5, pixel[1] + 0.5))
    return focused_at(lens, 1.0 / depth_m - nearer)


def focused_at(lens: Lens, dioptres: float) -> Lens:
    """Return the lens focused at `dioptres` (1/m); 0 is infinity.

    The focus distance always stays beyond the focal length.
    """
    if dioptres <= _AT_INFINITY:
        return replace(lens, focus_distance_m=float("inf"))
    least_m = 1.02e-3 * lens.focal_length_mm
    return replace(lens, focus_distance_m=max(1.0 / dioptres, least_m))
