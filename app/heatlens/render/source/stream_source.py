"""A running renderer as a source: a thread turns the frames that it sends into plates."""

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial

from heatlens.core.base.background import Background
from heatlens.core.base.errors import HeatlensError
from heatlens.core.base.faults import report_faults
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.core.model.shot.settings import DefocusSettings
from heatlens.core.model.shot.shot import Shot
from heatlens.media.live.stream.server import TevServer
from heatlens.media.plate.header.header_lens import StartLens, start_lens
from heatlens.media.plate.plate import Plate
from heatlens.render.source.kinds import STREAM_PREFIX
from heatlens.render.source.opened import Opened

_PAUSE_S = 0.1  # shortest pause between two plates, so that the window can do other work


@dataclass(frozen=True, eq=False)
class _StreamPlate:
    """A plate, or the reason why there is none, and its origin."""

    origin: tuple[int, PlateOptions]  # version of the server's images, and how they were read
    plate: Plate | None
    problem: str


class StreamSource:
    """Listens from the start until `close`; the loop calls `poll` and never waits."""

    def __init__(self, host: str, port: int, wake: Callable[[], None] = lambda: None) -> None:
        """Listen at the address; threads call `wake` when `poll` has news.

        Raises InputError if the address is in use, or does not belong to this machine.
        """
        self.options = PlateOptions()  # how frames are read
        self.should_show = False  # arriving frames should be shown
        self.is_shown = False  # the first of them has arrived
        self.problem = ""  # message about why the newest frame is not shown
        self.arriving = ""  # message while a part of the frame has not arrived
        # the version of the server's images in the newest plate, and how they were read
        self._plate_origin: tuple[int, PlateOptions] | None = None
        self._due_s = 0.0  # time of the monotonic clock before which no plate is made
        self._plate_maker: Background[_StreamPlate] = Background(wake)
        self._server = TevServer(host, port, on_news=wake)
        name, bound_port = self._server.address
        self.address = f"[{name}]:{bound_port}" if ":" in name else f"{name}:{bound_port}"
        self.text = f"{STREAM_PREFIX}{self.address}"

    def begin(self, options: PlateOptions) -> None:
        """Show the current frame, which is read again, and all later ones, read with `options`."""
        # without an origin, the current frame counts as new and is read again
        self.options, self.should_show, self._plate_origin = options, True, None

    def show(self, is_shown: bool) -> None:
        """Set whether the frames of this stream are shown, or those of another source."""
        self.should_show = self.is_shown = is_shown

    def poll(self) -> Plate | None:
        """Return the newest frame once, and None until there is another one.

        Begin to make a plate of the next frame if the renderer has sent more.
        """
        result = self._plate_maker.poll()
        if result is not None:
            self._plate_origin, self.problem = result.origin, result.problem
            self.arriving = "" if result.plate is None else _arriving_text(result.plate)
            self._due_s = time.monotonic() + _PAUSE_S
        version = self._server.version
        is_new = version > 0 and (version, self.options) != self._plate_origin
        if self.should_show and is_new and not self._plate_maker.is_busy:
            self._plate_maker.start(partial(self._make, self.options, self._due_s))
        return result.plate if result is not None and self.should_show else None

    def _make(self, options: PlateOptions, due_s: float) -> _StreamPlate:
        """Copy the image that has arrived and read it as a plate; runs on a thread."""
        time.sleep(max(0.0, due_s - time.monotonic()))
        origin = self._server.version, options
        try:
            with report_faults("The frame that was sent could not be read"):
                plate = self._server.snapshot(options=options)
        except HeatlensError as error:
            return _StreamPlate(origin, plate=None, problem=str(error))
        return _StreamPlate(
            origin, None if plate is None else plate.count_bins(), self._server.problem or ""
        )

    @property
    def status_text(self) -> str:
        """The address, which pixels have not arrived, and which data could not be used."""
        messages = (f"Listening on {self.address} ...", self.arriving, self.refusal)
        return " ".join(message for message in messages if message)

    @property
    def refusal(self) -> str:
        """Messages about data that could not be used; "" if all could."""
        return " ".join(message for message in (self.problem, self.losses) if message)

    @property
    def left_at(self) -> str:
        """The local time at which the renderer left, such as 04:31; "" while it is connected."""
        left_s = self._server.left_s
        return "" if left_s is None else time.strftime("%H:%M", time.localtime(left_s))

    @property
    def losses(self) -> str:
        """How many packets were rejected, and why the last one was; "" for none."""
        dropped, refused = self._server.dropped, self._server.refused
        if not (dropped or refused):
            return ""
        return f"Packets dropped: {dropped}, refused: {refused}. {self._server.fault or ''}".strip()

    def close(self) -> None:
        """Stop listening; a second call does nothing."""
        self.show(False)
        self._server.close()


def _arriving_text(plate: Plate) -> str:
    """Return the message about pixels without depth so far; "" if there are none."""
    if not plate.missing_count:
        return ""
    count = plate.data_window.width * plate.data_window.height
    return f"{plate.missing_count} of {count} pixels of its depth have not arrived yet."


@dataclass(frozen=True, eq=False)
class OpenedStream(Opened):
    """A running renderer whose first frame has arrived."""

    text: str
    notes: tuple[str, ...]
    stream: StreamSource
    plate: Plate
    frame: int = 1

    @property
    def options(self) -> PlateOptions:
        """The options, which may change while frames arrive."""
        return self.stream.options

    def lens(self, lens_fields: Mapping[str, object]) -> StartLens:
        """Return the given lens, completed from the header that the renderer sent."""
        return start_lens(self.plate, lens_fields)

    def shot(self, lens: Lens, defocus: DefocusSettings) -> Shot:
        """Return a shot of the newest frame."""
        return Shot(lens, defocus, source=self.text, plate_options=self.options)

    # The base closes nothing: the stream keeps listening, because it may be shown again.
