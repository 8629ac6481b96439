"""How the program begins, and what the options of the command line are for."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from heatlens.camera.into_shot import first_values
from heatlens.camera.samples import CameraSamples
from heatlens.model.framing import SceneTiming
from heatlens.model.lens_kit import LensKit
from heatlens.model.plate_options import PlateOptions
from heatlens.model.settings import DefocusSettings
from heatlens.model.view import ViewState
from heatlens.ring.ring_input import RingInput
from heatlens.ring.sender import LensSender
from heatlens.scene.placing import Placing
from heatlens.source.stream_source import StreamSource


@dataclass(frozen=True)
class Start:
    """What the command line gave.

    source         a file, pattern, folder, scene or shot, or the name of `stream`; "" lets the
                   user choose in the window
    plate_options  how the plate is read
    lens           fields of Lens that were given
    stream         a renderer that sends frames; closed with the program
    camera         tells what `lens` does not tell of the lens
    timing         puts the seconds of a scene into frames
    lens_in        a camera or a controller that the lens follows; closed with the program
    lens_out       what the lens at the playhead is sent to; closed with the program
    placing        tells of a scene's file what it does not say
    kit            bounds the lens of what is named, else of what opens first
    """

    source: str
    plate_options: PlateOptions = field(default_factory=PlateOptions)
    lens: Mapping[str, Any] = field(default_factory=dict)
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
    """The options of the command line: they are for what it named, else for what opens first."""

    def __init__(self, start: Start) -> None:
        self.start = start
        self._source = start.source
        self.has_opened = False  # anything, since the program began

    def opened(self, text: str) -> None:
        """Note that `text` was opened."""
        self._source, self.has_opened = self._source or text, True

    def are_for(self, text: str) -> bool:
        """Return True where the options count for what is called `text`."""
        return self._source in (text, "")

    def timing_of(self, text: str) -> SceneTiming | None:
        """Return the timing given for the scene `text`."""
        return self.start.timing if self.start.source == text else None

    def placing_of(self, text: str) -> Placing:
        """Return what was said of the unit and the direction of the scene called `text`."""
        return self.start.placing if self.are_for(text) else Placing()

    def lens_of(self, text: str) -> Mapping[str, Any]:
        """Return the fields of Lens given for `text`, those of a camera as they are first."""
        if not self.are_for(text):
            return {}
        camera, kept = self.start.camera, self.start.lens
        first = {} if camera is None else first_values(camera, kept)
        return {**first, **kept}
