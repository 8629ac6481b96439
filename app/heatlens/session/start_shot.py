"""The shot that begins when a plate, a scene or a stream has been opened."""

from collections.abc import Collection
from dataclasses import replace

from heatlens.camera.into_shot import with_camera
from heatlens.camera.samples import CameraSamples
from heatlens.camera.shoot_timecode import at_timecode
from heatlens.errors import HeatlensError, LensError
from heatlens.model.shot import Shot
from heatlens.model.timecode import Timecode
from heatlens.plate.start_lens import StartLens
from heatlens.session.start import GivenOptions
from heatlens.source.opened import Opened


def first_lens(opened: Opened, given: GivenOptions) -> tuple[StartLens, str]:
    """Return the lens that what was opened begins with, and what is wrong with the given one.

    The lens of the command line counts for what it came with; one that cannot be is left out, and
    the sentence says why.
    """
    try:
        return opened.lens(given.lens_of(opened.text)), ""
    except LensError as error:
        return opened.lens({}), str(error)


def with_given_camera(
    shot: Shot, given: GivenOptions, first: tuple[int, Timecode] | None = None
) -> tuple[Shot, str]:
    """Return the shot with the command line's camera, where that is for it; and what is to be said.

    A lens kit of the command line bounds the lens first. `first` is a frame with its timecode, on
    which the rows of a table are placed.
    """
    camera, source = given.start.camera, shot.source or ""
    kit = given.start.kit
    if kit is not None and given.are_for(source):
        shot = replace(shot, kit=kit, lens=kit.followed(None, shot.lens))
    if camera is None or not given.are_for(source):
        return shot, ""
    if any(getattr(shot.lens, name) != value for name, value in given.lens_of(source).items()):
        return shot, ""  # they make no lens, which was said
    placed = at_timecode(camera, first, camera.frames_per_second, shot.frames)
    try:
        filmed = shot_with_camera(shot, placed, given.start.lens)
    except HeatlensError as error:
        return shot, str(error)
    return filmed, " ".join(placed.notes[len(camera.notes) :])


def shot_with_camera(shot: Shot, camera: CameraSamples | None, kept: Collection[str]) -> Shot:
    """Return the shot with lens, keys and rate of `camera`, and its frames where it has none.

    Fields of Lens in `kept` stay. Raises LensError where what stays makes no lens with the rest.
    """
    if camera is None:
        return shot
    return replace(
        with_camera(shot, camera, kept),
        frames=shot.frames or camera.frame_range,
        frames_per_second=camera.frames_per_second,
    )
