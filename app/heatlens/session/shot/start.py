"""Keep what the command line gave, and decide which file its options apply to."""

from dataclasses import dataclass, field

from heatlens.camera.into_shot import first_values
from heatlens.camera.samples import CameraSamples
from heatlens.live.ring.ring_input import RingInput
from heatlens.live.ring.sender import LensSender
from heatlens.model.lens.lens_kit import LensKit
from heatlens.model.option import Values
from heatlens.model.shot.framing import SceneTiming
from heatlens.model.shot.plate_options import PlateOptions
from heatlens.model.shot.settings import DefocusSettings
from heatlens.model.view.view import ViewState
from heatlens.scene.placing import Placing
from heatlens.source.stream_source import StreamSource


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


class GivenOptions:
    """The options of the command line; they apply to the file it named, or to the first opened."""

    def __init__(self, start: Start) -> None:
        self.start = start
        self._source = start.source
        self.has_opened = False  # whether anything has been opened yet

    def opened(self, text: str) -> None:
        """Note that `text` was opened."""
        self._source, self.has_opened = self._source or text, True

    def are_for(self, text: str) -> bool:
        """Return True if the options apply to the source `text`."""
        return self._source in (text, "")

    def timing_of(self, text: str) -> SceneTiming | None:
        """Return the timing given for the scene `text`."""
        return self.start.timing if self.start.source == text else None

    def placing_of(self, text: str) -> Placing:
        """Return the given up axis and unit for the scene `text`."""
        return self.start.placing if self.are_for(text) else Placing()

    def lens_of(self, text: str) -> Values:
        """Return the fields of Lens given for `text`, and those of a camera at its first frame."""
        if not self.are_for(text):
            return {}
        camera, kept = self.start.camera, self.start.lens
        first = {} if camera is None else first_values(camera, kept)
        return {**first, **kept}
