"""Compute how much overscan the blur of a lens needs around the frame, and how much a plate has.

A lens that breathes shows another section of the plate at each focus distance.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise

from heatlens.core.base.messages import Explained
from heatlens.core.model.boxes import Box
from heatlens.core.model.curves.frames import FrameRange
from heatlens.core.model.lens.breathing import plate_ratio
from heatlens.core.model.lens.disc_shape import DiscShape
from heatlens.core.model.lens.lens import Lens
from heatlens.media.plate.coc_line import line_of
from heatlens.media.plate.plate import Plate

_STEP_PX = 8  # the suggested overscan is rounded up to a multiple of this


@dataclass(frozen=True)
class OverscanNeed:
    """The overscan that a shot needs.

    needed_px   the radius of the widest disc, the larger of its width and height
    at_frame    the frame with this widest disc
    has_px      overscan of the plate outside its display window, on the side with the least
    short       ranges of frames that need more overscan than the plate has
    """

    needed_px: float
    at_frame: int
    has_px: int
    short: tuple[FrameRange, ...]

    @property
    def sentence(self) -> Explained:
        """What to render, as the plate has too little overscan, and how much is needed where."""
        frames = ", ".join(
            str(frame_range) if frame_range.count > 1 else str(frame_range.first)
            for frame_range in self.short
        )
        suggested_px = _STEP_PX * math.ceil(self.needed_px / _STEP_PX)
        wider_px = suggested_px - self.has_px
        overscan = f"{self.has_px} px of overscan" if self.has_px else "no overscan"
        advice = f"Render it {wider_px} px wider on every side."
        why = f"what lies up to {self.needed_px:.0f} px outside blurs into frame {self.at_frame}"
        return Explained(
            f"Borders are guessed: the plate has {overscan}. {advice}",
            f"Overscan: {why}; it is too small in frames {frames}.",
        )


def overscan_need(plate: Plate, lenses: Mapping[int, Lens]) -> OverscanNeed | None:
    """Return the overscan that a plate with these depths needs for `lenses`, by frame number.

    Returns None without lenses, and if the plate has no distances.
    """
    if not lenses or not plate.has_distances:
        return None
    radii_px = {frame: _widest_radius_px(plate, lens) for frame, lens in lenses.items()}
    at_frame = max(radii_px, key=lambda frame: radii_px[frame])
    has_px = overscan_px(plate)
    short_frames = [frame for frame, needed_px in radii_px.items() if needed_px > has_px + 1]
    return OverscanNeed(
        radii_px[at_frame], at_frame, has_px, _group_in_ranges(sorted(short_frames))
    )


def overscan_px(plate: Plate) -> int:
    """Return the overscan of a plate in pixels, on the side with the least of it."""
    data, display = plate.data_window, plate.display_window
    sides = (display.x0 - data.x0, display.y0 - data.y0, data.x1 - display.x1, data.y1 - display.y1)
    return max(0, min(sides))


def _widest_radius_px(plate: Plate, lens: Lens) -> float:
    """Return the largest radius in pixels of all discs: of the nearest or the farthest point."""
    line = line_of(plate, lens)
    report = plate.depth
    farthest = math.inf if report.infinite_count else report.far_m
    diameters = [line.at_infinity_px + line.per_dioptre_px / z for z in (report.near_m, farthest)]
    half_extents = DiscShape(lens.aperture, plate.pixel_aspect_ratio).half_extents
    data = plate.data_window
    tilts = line.focus_offset_limits_px(Box(0, 0, data.width, data.height))
    return (
        max(half_extents)
        * max(abs(diameter + tilt) for diameter in diameters for tilt in tilts)
        / 2
    )


def _group_in_ranges(frames: list[int]) -> tuple[FrameRange, ...]:
    """Return sorted frame numbers as ranges without gaps."""
    if not frames:
        return ()
    ends = [a for a, b in pairwise(frames) if b != a + 1] + [frames[-1]]
    starts = [frames[0]] + [b for a, b in pairwise(frames) if b != a + 1]
    return tuple(FrameRange(first, last) for first, last in zip(starts, ends, strict=True))


def overscan_ratio(plate: Plate) -> float:
    """Return the width of the plate with its symmetric overscan, divided by that of its frame."""
    return 1.0 + 2.0 * overscan_px(plate) / plate.display_window.width


def frame_centre_px(plate: Plate, scale: float = 1.0) -> tuple[float, float]:
    """Return the center (x, y) of the frame in pixels from the corner of the data window.

    `scale` is the proxy scale by which the result is multiplied.
    """
    data, display = plate.data_window, plate.display_window
    x, y = (display.x0 + display.x1) / 2 - data.x0, (display.y0 + display.y1) / 2 - data.y0
    return x * scale, y * scale


def plate_pixel(plate: Plate, lens: Lens, pixel: tuple[int, int]) -> tuple[int, int]:
    """Return the pixel of the plate's display window that is seen at `pixel` of the picture."""
    ratio = plate_ratio(lens, overscan_ratio(plate))
    if ratio == 1.0:
        return pixel
    sides = plate.display_window.width, plate.display_window.height
    x, y = (
        side / 2 + (coordinate + 0.5 - side / 2) * ratio
        for coordinate, side in zip(pixel, sides, strict=True)
    )
    return int(x // 1), int(y // 1)


def picture_point(plate: Plate, lens: Lens, point: tuple[float, float]) -> tuple[float, float]:
    """Return where `point` of the plate's display window appears in the picture."""
    ratio = plate_ratio(lens, overscan_ratio(plate))
    middle_x, middle_y = plate.display_window.width / 2, plate.display_window.height / 2
    return middle_x + (point[0] - middle_x) / ratio, middle_y + (point[1] - middle_y) / ratio
