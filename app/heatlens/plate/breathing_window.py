"""Find the part of a plate's frame that is visible through a lens that breathes."""

from heatlens.model.breathing import plate_ratio
from heatlens.model.lens import Lens
from heatlens.plate.overscan_need import overscan_px
from heatlens.plate.plate import Plate


def room_of(plate: Plate) -> float:
    """Return the width of the plate with its symmetric overscan, divided by that of its frame."""
    return 1.0 + 2.0 * overscan_px(plate) / plate.display_window.width


def frame_centre_px(plate: Plate, scale: float = 1.0) -> tuple[float, float]:
    """Return the centre (x, y) of the frame in pixels from the corner of the data window.

    `scale` is the proxy scale by which the result is multiplied.
    """
    data, shown = plate.data_window, plate.display_window
    x, y = (shown.x0 + shown.x1) / 2 - data.x0, (shown.y0 + shown.y1) / 2 - data.y0
    return x * scale, y * scale


def plate_pixel(plate: Plate, lens: Lens, pixel: tuple[int, int]) -> tuple[int, int]:
    """Return the pixel of the plate's display window that is seen at `pixel` of the picture."""
    ratio = plate_ratio(lens, room_of(plate))
    if ratio == 1.0:
        return pixel
    sides = plate.display_window.width, plate.display_window.height
    x, y = (side / 2 + (at + 0.5 - side / 2) * ratio for at, side in zip(pixel, sides, strict=True))
    return int(x // 1), int(y // 1)


def picture_point(plate: Plate, lens: Lens, point: tuple[float, float]) -> tuple[float, float]:
    """Return where `point` of the plate's display window appears in the picture."""
    ratio = plate_ratio(lens, room_of(plate))
    middle_x, middle_y = plate.display_window.width / 2, plate.display_window.height / 2
    return middle_x + (point[0] - middle_x) / ratio, middle_y + (point[1] - middle_y) / ratio
