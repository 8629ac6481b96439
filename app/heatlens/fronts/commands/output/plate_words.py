"""Print how a plate was read, and doubts about the lens, before a command starts to work.

Also read values from the plates of a shot: the first plate, the overscan that the lens needs, and
the timecode of frames, from the shot or else from the header of its first file.
"""

from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING

from heatlens.core.base.errors import InputError
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.core.model.shot.shot import Shot
from heatlens.core.model.timecode import Timecode
from heatlens.fronts.commands.output.say import print_messages
from heatlens.media.camera.samples import CameraSamples
from heatlens.media.plate.header.entries import blurred_notes
from heatlens.media.plate.parts.header_read import first_timecode
from heatlens.media.plate.plate import Plate
from heatlens.media.plate.plate_notes import breathing_notes, depth_note, lens_notes, shot_notes
from heatlens.media.plate.read import read_plate
from heatlens.media.sequence.sequence_search import find_sequence

if TYPE_CHECKING:
    from heatlens.media.plate.overscan_need import OverscanNeed


def print_plate_notes(plate: Plate, lens: Lens, lens_sentence: str, options: PlateOptions) -> None:
    """Print how the depth was read and why, all repairs, the lens, and doubts.

    Raises InputError for the first doubt if `options` are strict.
    """
    print_reading(plate, lens_sentence)
    print_messages(*lens_notes(plate, lens, options.scene_unit_m, options.strict))


def print_breathing(lens: Lens, plate: Plate | None) -> None:
    """Print the effect of breathing on the picture of a plate or a scene, if there is any."""
    print_messages(*breathing_notes(lens, plate))


def print_reading(plate: Plate, lens_sentence: str) -> None:
    """Print how the depth was read and why, all repairs, and the lens."""
    print_messages(depth_note(plate), *plate.notes, lens_sentence)


def print_shot_doubts(shot: Shot, plate: Plate | None, camera: CameraSamples | None = None) -> None:
    """Print doubts about a shot's lens at its keys, for the depths of its `first_plate`.

    Also print doubts about the unit of the focus in `camera`, and the effect of breathing.
    """
    if plate is None:
        print_messages(*breathing_notes(shot.lens, plate=None))
    else:
        print_messages(*blurred_notes(plate.path, plate.attributes))
        print_messages(
            *shot_notes(shot, plate, () if camera is None else camera.focus_without_unit_m)
        )


def overscan_of_shot(
    shot: Shot, plate: Plate | None, frames: Iterable[int]
) -> "OverscanNeed | None":
    """Return the overscan that some frames need, for the depths of the `first_plate`."""
    from heatlens.media.plate.overscan_need import overscan_need

    if plate is None:
        return None
    return overscan_need(plate, {frame: shot.lens_at(frame) for frame in frames})


def first_plate(shot: Shot) -> Plate | None:
    """Return the first plate of a shot; None for a scene, and if it cannot be read.

    An error is reported when the frame is rendered; the plates may appear later.
    """
    from heatlens.render.source.named import source_of

    try:
        first_file = None if shot.source is None else source_of(shot).first_file
        return None if first_file is None else read_plate(first_file, shot.plate_options)
    except InputError:
        return None


def shot_timecodes(shot: Shot, first: int) -> Callable[[int], Timecode | None]:
    """Return a function for the timecode of a frame; `first` is the first frame of a still shot."""
    first_timecode_of_plate = (
        None if shot.start_timecode is not None else _first_frame_timecode(shot)
    )
    rate = shot.frames_per_second

    def timecode_at(frame: int) -> Timecode | None:
        """Return the timecode of a frame, counted on from that of the first plate."""
        plate_timecode = (
            None
            if first_timecode_of_plate is None
            else first_timecode_of_plate[1].add_frames(frame - first_timecode_of_plate[0], rate)
        )
        return shot.timecode_at(frame, plate_timecode, first)

    return timecode_at


def _first_frame_timecode(shot: Shot) -> tuple[int, Timecode] | None:
    """Return a frame and its timecode; None for scenes and plates that cannot be read yet."""
    try:
        return None if shot.source is None else first_timecode(find_sequence(shot.source))
    except InputError:
        return None
