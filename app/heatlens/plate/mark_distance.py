"""Measure how far focus marks are on plates."""

from collections.abc import Iterable

from heatlens.model.following import Distances
from heatlens.model.marks import DistanceMark, Mark, MatteMark, ObjectMark, TrackMark
from heatlens.plate.focus_pick import depth_at_m
from heatlens.plate.mattes.matte_distance import thing_m
from heatlens.plate.mattes.mattes import UnknownThingError
from heatlens.plate.plate import Plate


def mark_on_plate_m(plate: Plate, mark: Mark) -> float | None:
    """Return the distance of a mark in metres; None for a thing that is hidden or not in the plate.

    A thing that is found by its matte has the plate's file read again. Raises InputError for a
    point outside the picture, for a plate without distances, and where there is no such thing.
    """
    if isinstance(mark, DistanceMark):
        return mark.distance_m
    if isinstance(mark, ObjectMark | TrackMark):  # these are known without the plate
        return None
    if isinstance(mark, MatteMark):
        return thing_m(plate, mark.matte, mark.part)
    return depth_at_m(plate, int(mark.x_px), int(mark.y_px))


def mark_over_plates_m(plates: Iterable[tuple[int, Plate]], mark: Mark) -> Distances:
    """Return the distance of a mark on each plate, by frame.

    Raises InputError as `mark_on_plate_m` does, but for an unknown thing only where every plate
    lacks it: some renderers name only the things in the picture.
    """
    found: dict[int, float | None] = {}
    unknown: list[UnknownThingError] = []
    for frame, plate in plates:
        found[frame] = None
        try:
            found[frame] = mark_on_plate_m(plate, mark)
        except UnknownThingError as error:
            unknown.append(error)
    if unknown and len(unknown) == len(found):
        raise unknown[0]
    return found
