"""Keep the values of the command line, and decide which file its options apply to.

Make the first shot of a plate, scene or stream that has been opened.
"""

from collections.abc import Collection
from dataclasses import dataclass, field, replace

from heatlens.core.base.errors import HeatlensError, LensError
from heatlens.core.model.lens.lens_kit import LensKit
from heatlens.core.model.option import Values
from heatlens.core.model.shot.framing import SceneTiming
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.core.model.shot.settings import DefocusSettings
from heatlens.core.model.shot.shot import Shot
from heatlens.core.model.timecode import Timecode
from heatlens.core.model.view.view import ViewState
from heatlens.media.camera.into_shot import first_values, with_camera
from heatlens.media.camera.samples import CameraSamples
from heatlens.media.camera.shoot_timecode import match_by_timecode
from heatlens.media.live.ring.sender import LensSender
from heatlens.media.live.ring.sources import RingInput
from heatlens.media.plate.header.header_lens import StartLens
from heatlens.media.scene.placing import Placing
from heatlens.render.source.opened import Opened
from heatlens.render.source.stream_source import StreamSource


@dataclass(frozen=True)
class Start:
    """The values of the command line.

    source         a file, pattern, folder, scene or shot, or the name of `stream`; "" shows the
                   start screen
    plate_options  how to read the plate
    lens           the given fields of Lens
    stream         a renderer that sends frames; closed with the program
    camera         a camera file with lens values that `lens` does not give
    timing         the frame rate and clip of a scene
    lens_in        a camera or controller that the lens follows; closed with the program
    lens_out       where the lens at the playhead is sent; closed with the program
    placing        up axis and unit of a scene whose file does not say them
    kit            a lens kit that limits the lens
    """

    source: str
    plate_options: PlateOptions = field(default_factory=PlateOptions)
    lens: Values = field(default_factory=dict)
    defocus: DefocusSettings = field(default_factory=DefocusSettings)
    view: ViewState = field(default_factory=ViewState)
    ocio: str | None = None
    stream: StreamSource | None = None
    camera: CameraSamples | None = None
    timing: SceneTiming | None = None
    lens_in: RingInput | None = None
    lens_out: LensSender | None = None
    placing: Placing = field(default_factory=Placing)
    kit: LensKit | None = None


class CommandLineOptions:
    """The options of the command line, for the file that it names or else the first opened."""

    def __init__(self, start: Start) -> None:
        self.start = start
        self._source = start.source
        self.has_opened = False  # whether anything has been opened yet

    def note_opened(self, text: str) -> None:
        """Note that `text` was opened; the first is what the command line named."""
        self._source, self.has_opened = self._source or text, True

    def apply_to(self, text: str) -> bool:
        """Return True if the options apply to the source `text`."""
        return self._source in (text, "")

    def timing_of(self, text: str) -> SceneTiming | None:
        """Return the timing given for the scene `text`, or None."""
        return self.start.timing if self.start.source == text else None

    def placing_of(self, text: str) -> Placing:
        """Return the given up axis and unit for the scene `text`."""
        return self.start.placing if self.apply_to(text) else Placing()

    def lens_of(self, text: str) -> Values:
        """Return the fields of Lens given for `text`, and those of a camera at its first frame."""
        if not self.apply_to(text):
            return {}
        camera, given_lens = self.start.camera, self.start.lens
        first_camera_values = {} if camera is None else first_values(camera, given_lens)
        return {**first_camera_values, **given_lens}


def first_lens(opened: Opened, command_line: CommandLineOptions) -> tuple[StartLens, str]:
    """Return the first lens for a source, and a sentence about an unusable given lens, or "".

    The lens of the command line is used if it is for this source. If that lens is impossible, it is
    ignored, and the sentence gives the reason.
    """
    try:
        return opened.lens(command_line.lens_of(opened.text)), ""
    except LensError as error:
        return opened.lens({}), str(error)


def with_given_camera(
    shot: Shot, command_line: CommandLineOptions, first_timecode: tuple[int, Timecode] | None = None
) -> tuple[Shot, str]:
    """Return the shot with the command line's camera, if that applies, and a message or "".

    A lens kit of the command line limits the lens first. `first_timecode` is a frame and its
    timecode, by which the rows of a table are placed.
    """
    camera, source = command_line.start.camera, shot.source or ""
    kit = command_line.start.kit
    if kit is not None and command_line.apply_to(source):
        shot = replace(shot, kit=kit, lens=kit.limit_change(None, shot.lens))
    if camera is None or not command_line.apply_to(source):
        return shot, ""
    if any(
        getattr(shot.lens, name) != value for name, value in command_line.lens_of(source).items()
    ):
        return shot, ""  # the lens is impossible, which `first_lens` has reported
    placed_camera = match_by_timecode(camera, first_timecode, camera.frames_per_second, shot.frames)
    try:
        camera_shot = shot_with_camera(shot, placed_camera, command_line.start.lens)
    except HeatlensError as error:
        return shot, str(error)
    return camera_shot, " ".join(placed_camera.notes[len(camera.notes) :])


def shot_with_camera(
    shot: Shot, camera: CameraSamples | None, fixed_fields: Collection[str]
) -> Shot:
    """Return the shot with lens, keys and rate of `camera`, and its frames if the shot has none.

    Fields of Lens in `fixed_fields` stay. Raise LensError if they are impossible with the camera's
    values.
    """
    if camera is None:
        return shot
    return replace(
        with_camera(shot, camera, fixed_fields),
        frames=shot.frames or camera.frame_range,
        frames_per_second=camera.frames_per_second,
    )
