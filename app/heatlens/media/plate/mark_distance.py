"""Measure how far focus marks are on plates."""

from collections.abc import Iterable

import numpy as np

from heatlens.core.base.errors import InputError
from heatlens.core.model.focus.live_focus import Distances
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.marks.mark import Mark
from heatlens.core.model.marks.marks import DistanceMark, MatteMark, PointMark, WorldMark
from heatlens.media.plate.coc_line import depth_at_m
from heatlens.media.plate.mattes.mattes import UnknownThingError, thing_distance_m
from heatlens.media.plate.plate import Plate

_STILL = 0.01  # relative difference of depths up to which a surface counts as the same


def mark_on_plate_m(plate: Plate, mark: Mark) -> float | None:
    """Return the distance of a mark in meters; None if the thing is hidden or not in the plate.

    For a thing that is found by its matte, the plate's file is read again. Raises InputError for a
    point outside the picture, for a plate without distances, and where there is no such thing.
    """
    if isinstance(mark, DistanceMark):
        return mark.distance_m
    distance_m: float | None = None if mark.on_plate is None else mark.on_plate(plate, mark)
    return distance_m


def point_m(plate: Plate, mark: PointMark) -> float:
    """Return the depth in meters of the surface at a point of the picture."""
    return depth_at_m(plate, int(mark.x_px), int(mark.y_px))


def matte_m(plate: Plate, mark: MatteMark) -> float | None:
    """Return the distance in meters of the thing in a matte; None if it is hidden."""
    return thing_distance_m(plate, mark.matte, mark.part)


def mark_distances_m(plates: Iterable[tuple[int, Plate]], mark: Mark) -> Distances:
    """Return the distance of a mark on each plate, by frame.

    Raises InputError as `mark_on_plate_m` does, but for an unknown thing only if every plate lacks
    it: some renderers name only the things in the picture.
    """
    distances_m: dict[int, float | None] = {}
    unknown_errors: list[UnknownThingError] = []
    for frame, plate in plates:
        distances_m[frame] = None
        try:
            distances_m[frame] = mark_on_plate_m(plate, mark)
        except UnknownThingError as error:
            unknown_errors.append(error)
    if unknown_errors and len(unknown_errors) == len(distances_m):
        raise unknown_errors[0]
    return distances_m


def world_m(plate: Plate, mark: WorldMark) -> float | None:
    """Return how far a point in the world lies in front of the camera; None behind it."""
    if plate.world_to_camera is None:
        raise _no_camera_error(plate, mark)
    row = plate.world_to_camera[2]
    depth_m = -float(row[:3] @ (mark.x_m, mark.y_m, mark.z_m) + row[3])
    return depth_m if depth_m > 0 else None


def make_world_mark(plate: Plate, mark: PointMark, lens: Lens) -> WorldMark:
    """Return a mark at the world position of the surface that a point of the picture shows.

    `lens` is used where the header has none. Raises InputError outside the picture, on the sky, and
    for a plate whose header does not hold the position of its camera.
    """
    depth_m = depth_at_m(plate, int(mark.x_px), int(mark.y_px))
    if plate.world_to_camera is None:
        raise _no_camera_error(plate, mark)
    if not np.isfinite(depth_m):
        raise InputError(f"Mark {mark.name} is on the sky, which has no place in the world.")
    box, pitch = plate.display_window, _tangent_per_px(plate, lens)
    right = (mark.x_px + 0.5 - box.width / 2) * pitch
    down = (mark.y_px + 0.5 - box.height / 2) * pitch / plate.pixel_aspect_ratio
    camera_point = np.array([right * depth_m, -down * depth_m, -depth_m, 1.0])
    x, y, z, _ = np.linalg.inv(plate.world_to_camera) @ camera_point
    return WorldMark(mark.name, float(x), float(y), float(z))


def _tangent_per_px(plate: Plate, lens: Lens) -> float:
    """Return the tangent of the angle that a pixel at the middle of the picture is wide."""
    camera = plate.camera
    focal_mm = camera.focal_length_mm or lens.focal_length_mm
    width_mm = camera.sensor_width_mm or lens.sensor_width_mm
    return width_mm / plate.display_window.width / focal_mm


def world_point(plate: Plate, mark: WorldMark, lens: Lens) -> PointMark | None:
    """Return the point of the picture at which a place in the world is; None beside the picture.

    `lens` is used where the header has none.
    """
    depth_m, box = world_m(plate, mark), plate.display_window
    if depth_m is None or plate.world_to_camera is None:
        return None
    right, up, _, _ = plate.world_to_camera @ np.array([mark.x_m, mark.y_m, mark.z_m, 1.0])
    per_px = depth_m * _tangent_per_px(plate, lens)
    x_px = float(right / per_px + box.width / 2 - 0.5)
    y_px = float(-up * plate.pixel_aspect_ratio / per_px + box.height / 2 - 0.5)
    is_inside = -0.5 <= x_px < box.width - 0.5 and -0.5 <= y_px < box.height - 0.5
    return PointMark(mark.name, x_px, y_px) if is_inside else None


def stands_still(plates: Iterable[Plate], mark: WorldMark, lens: Lens) -> bool:
    """Return True if all plates that show a place in the world have a surface there.

    A surface that moves, or that something hides, is at another depth than the place.
    """
    for plate in plates:
        point = None if plate.world_to_camera is None else world_point(plate, mark, lens)
        if point is not None:
            surface_m = depth_at_m(plate, round(point.x_px), round(point.y_px))
            place_m = world_m(plate, mark) or 0.0
            if not abs(surface_m - place_m) <= _STILL * place_m:
                return False
    return True


def _no_camera_error(plate: Plate, mark: Mark) -> InputError:
    """Return the error for a plate without the position of its camera, which a mark needs."""
    return InputError(
        f"{plate.path} does not tell where its camera stands: mark {mark.name} needs the entry "
        "worldToCamera in its header."
    )
