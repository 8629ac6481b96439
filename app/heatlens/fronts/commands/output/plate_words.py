"""Print how a plate was read, and doubts about the lens, before a command starts to work.

Also what the plates of a shot tell: the first of them, the surroundings that the lens needs, and
the timecode of frames, from the shot or else from the header of its first file.
"""

from collections.abc import Callable, Iterable

from heatlens.core.base.errors import InputError
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.core.model.shot.shot import Shot
from heatlens.core.model.timecode import Timecode
from heatlens.fronts.commands.output.say import say
from heatlens.media.camera.samples import CameraSamples
from heatlens.media.plate.header.entries import blurred_notes
from heatlens.media.plate.overscan_need import OverscanNeed, overscan_need
from heatlens.media.plate.parts.header_read import first_timecode
from heatlens.media.plate.plate import Plate
from heatlens.media.plate.plate_notes import breathing_notes, depth_note, lens_notes, shot_notes
from heatlens.media.plate.read import read_plate
from heatlens.media.sequence.sequence import find_sequence
from heatlens.render.source.named import source_of


def say_plate(plate: Plate, lens: Lens, said_of_lens: str, options: PlateOptions) -> None:
    """Print how the depth was read and why, all repairs, the lens, and doubts.

    Raises InputError for the first doubt if `options` are strict.
    """
    say_reading(plate, said_of_lens)
    say(*lens_notes(plate, lens, options.scene_unit_m, options.strict))


def say_breathing(lens: Lens, plate: Plate | None) -> None:
    """Print the effect of breathing on the picture of a plate or a scene, if there is any."""
    say(*breathing_notes(lens, plate))


def say_reading(plate: Plate, said_of_lens: str) -> None:
    """Print how the depth was read and why, all repairs, and the lens."""
    say(depth_note(plate), *plate.notes, said_of_lens)


def say_doubts_of_shot(
    shot: Shot, plate: Plate | None, camera: CameraSamples | None = None
) -> None:
    """Print doubts about a shot's lens at its keys, for the depths of its `first_plate`.

    Also print doubts about the unit of the focus in `camera`, and the effect of breathing.
    """
    if plate is None:
        say(*breathing_notes(shot.lens, None))
    else:
        say(*blurred_notes(plate.path, plate.attributes))
        say(*shot_notes(shot, plate, () if camera is None else camera.focus_without_unit_m))


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


def shot_timecodes(shot: Shot, first: int) -> Callable[[int], Timecode | None]:
    """Return a function for the timecode of a frame; `first` is the first frame of a still shot."""
    started = None if shot.start_timecode is not None else _first_of(shot)
    rate = shot.frames_per_second

    def timecode_at(frame: int) -> Timecode | None:
        of_plate = None if started is None else started[1].later(frame - started[0], rate)
        return shot.timecode_at(frame, of_plate, first)

    return timecode_at


def _first_of(shot: Shot) -> tuple[int, Timecode] | None:
    """Return a frame and its timecode; None for scenes and plates that cannot be read yet."""
    try:
        return None if shot.source is None else first_timecode(find_sequence(shot.source))
    except InputError:
        return None
