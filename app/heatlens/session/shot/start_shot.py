"""Make the first shot of a plate, scene or stream that has been opened."""

from collections.abc import Collection
from dataclasses import replace

from heatlens.base.errors import HeatlensError, LensError
from heatlens.camera.into_shot import with_camera
from heatlens.camera.samples import CameraSamples
from heatlens.camera.shoot_timecode import at_timecode
from heatlens.model.shot.shot import Shot
from heatlens.model.timecode import Timecode
from heatlens.plate.header.header_lens import StartLens
from heatlens.session.shot.start import GivenOptions
from heatlens.source.opened import Opened


def first_lens(opened: Opened, given: GivenOptions) -> tuple[StartLens, str]:
    """Return the first lens for a source, and a sentence about an unusable given lens, or "".

    The lens of the command line is used if it is for this source; if it is impossible it is left
    out, and the sentence says why.
    """
    try:
        return opened.lens(given.lens_of(opened.text)), ""
    except LensError as error:
        return opened.lens({}), str(error)


def with_given_camera(
    shot: Shot, given: GivenOptions, first: tuple[int, Timecode] | None = None
) -> tuple[Shot, str]:
    """Return the shot with the command line's camera, if that applies, and a message or "".

    A lens kit of the command line limits the lens first. `first` is a frame and its timecode, by
    which the rows of a table are placed.
    """
    camera, source = given.start.camera, shot.source or ""
    kit = given.start.kit
    if kit is not None and given.are_for(source):
        shot = replace(shot, kit=kit, lens=kit.followed(None, shot.lens))
    if camera is None or not given.are_for(source):
        return shot, ""
    if any(getattr(shot.lens, name) != value for name, value in given.lens_of(source).items()):
        return shot, ""  # the lens is impossible, which `first_lens` has reported
    placed = at_timecode(camera, first, camera.frames_per_second, shot.frames)
    try:
        filmed = shot_with_camera(shot, placed, given.start.lens)
    except HeatlensError as error:
        return shot, str(error)
    return filmed, " ".join(placed.notes[len(camera.notes) :])


def shot_with_camera(shot: Shot, camera: CameraSamples | None, kept: Collection[str]) -> Shot:
    """Return the shot with lens, keys and rate of `camera`, and its frames if the shot has none.

    Fields of Lens in `kept` stay. Raise LensError if they are impossible with the camera's values.
    """
    if camera is None:
        return shot
    return replace(
        with_camera(shot, camera, kept),
        frames=shot.frames or camera.frame_range,
        frames_per_second=camera.frames_per_second,
    )
