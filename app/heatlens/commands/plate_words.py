"""Print how a plate was read, and doubts about the lens, before a command starts to work."""

from collections.abc import Iterable

from heatlens.commands.say import say
from heatlens.errors import InputError
from heatlens.model.breathing import breathing_note
from heatlens.model.lens import Lens
from heatlens.model.plate_options import PlateOptions
from heatlens.model.plausibility import doubts
from heatlens.model.shot import Shot
from heatlens.plate.breathing_window import room_of
from heatlens.plate.overscan_need import OverscanNeed, overscan_need
from heatlens.plate.plate import Plate, depth_span
from heatlens.plate.read import read_plate
from heatlens.source.named import source_of


def say_plate(plate: Plate, lens: Lens, said_of_lens: str, options: PlateOptions) -> None:
    """Print how the depth was read and why, all repairs, the lens, and doubts.

    Raises InputError for the first doubt if `options` are strict.
    """
    say_reading(plate, said_of_lens)
    say_breathing(lens, plate)
    say_doubts(plate, lens, options)


def say_breathing(lens: Lens, plate: Plate | None) -> None:
    """Print the effect of breathing on the picture of a plate or a scene, if there is any."""
    note = breathing_note(lens, None if plate is None else room_of(plate))
    if note:
        say(note)


def say_reading(plate: Plate, said_of_lens: str) -> None:
    """Print how the depth was read and why, all repairs, and the lens."""
    depth = plate.depth
    say(f"depth: {depth.channel} taken as {depth.convention}, {depth.kind}. {depth.why}")
    say(*plate.notes, said_of_lens)


def say_doubts_of_shot(shot: Shot, plate: Plate | None) -> None:
    """Print doubts about a shot's lens at its keys, for the depths of its `first_plate`.

    The effect of breathing is printed too.
    """
    say_breathing(shot.lens, plate)
    if plate is None:
        return
    lenses = [shot.lens_at(frame) for frame in shot.key_frames] or [shot.lens]
    span = depth_span(plate, shot.plate_options.scene_unit_m)
    if all(doubts(lens, span) for lens in lenses):  # a pull may begin in front of all surfaces
        say_doubts(plate, lenses[0], shot.plate_options)


def overscan_of_shot(shot: Shot, plate: Plate | None, frames: Iterable[int]) -> OverscanNeed | None:
    """Return the overscan that some frames need, for the depths of the `first_plate`."""
    if plate is None:
        return None
    return overscan_need(plate, {frame: shot.lens_at(frame) for frame in frames})


def first_plate(shot: Shot) -> Plate | None:
    """Return the first plate of a shot; None for a scene, and if it cannot be read.

    An error is reported when the frame is rendered; the plates may appear later.
    """
    try:
        first = None if shot.source is None else source_of(shot).first_file
        return None if first is None else read_plate(first, shot.plate_options)
    except InputError:
        return None


def say_doubts(plate: Plate, lens: Lens, options: PlateOptions) -> None:
    """Print doubts about this lens for the depths of the plate.

    Raises InputError for the first one if `options` are strict.
    """
    if not plate.has_distances:
        return
    for doubt in doubts(lens, depth_span(plate, options.scene_unit_m)):
        if options.strict:
            raise InputError(f"{plate.path}: {doubt.sentence}")
        say(doubt.sentence)
