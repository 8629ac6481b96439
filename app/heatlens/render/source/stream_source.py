"""A running renderer as a source: a thread turns the frames that it sends into plates."""

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial

from heatlens.core.base.background import Background
from heatlens.core.base.errors import HeatlensError
from heatlens.core.base.faults import faults_reported
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
class _Made:
    """A plate, or the reason why there is none, and its origin."""

    of: tuple[int, PlateOptions]  # version of the server's images, and how they were read
    plate: Plate | None
    problem: str


class StreamSource:
    """Listens from the start until `close`; the loop calls `poll` and never waits."""

    def __init__(self, host: str, port: int) -> None:
        """Listen at the address.

        Raises InputError if it is in use, or does not belong to this machine.
        """
        self.wake: Callable[[], None] = lambda: None  # called on threads when `poll` has news
        self.options = PlateOptions()  # how frames are read
        self.is_wanted = False  # arriving frames should be shown
        self.is_shown = False  # the first of them has arrived
        self.problem = ""  # a sentence on why the newest frame is not shown
        self.arriving = ""  # a sentence while a part of the frame has not arrived
        self._made_of: tuple[int, PlateOptions] | None = None
        self._due_s = 0.0
        self._maker: Background[_Made] = Background(lambda: self.wake())
        self._server = TevServer(host, port, on_news=lambda: self.wake())
        name, bound = self._server.address
        self.address = f"[{name}]:{bound}" if ":" in name else f"{name}:{bound}"
        self.text = f"{STREAM_PREFIX}{self.address}"

    def begin(self, options: PlateOptions) -> None:
        """Show the current and all later frames, read with `options`."""
        self.options, self.is_wanted, self._made_of = options, True, None

    def show(self, is_shown: bool) -> None:
        """Set whether the frames of this stream are shown, or those of another source."""
        self.is_wanted = self.is_shown = is_shown

    def poll(self) -> Plate | None:
        """Return the newest frame once; begin with the next one if the renderer has sent more."""
        made = self._maker.poll()
        if made is not None:
            self._made_of, self.problem = made.of, made.problem
            self.arriving = "" if made.plate is None else _arriving(made.plate)
            self._due_s = time.monotonic() + _PAUSE_S
        version = self._server.version
        is_new = version > 0 and (version, self.options) != self._made_of
        if self.is_wanted and is_new and not self._maker.is_busy:
            self._maker.start(partial(self._make, self.options, self._due_s))
        return made.plate if made is not None and self.is_wanted else None

    def _make(self, options: PlateOptions, due_s: float) -> _Made:
        """Copy the image that has arrived and read it as a plate; runs on a thread."""
        time.sleep(max(0.0, due_s - time.monotonic()))
        of = self._server.version, options
        try:
            with faults_reported("The frame that was sent could not be read"):
                plate = self._server.snapshot(options=options)
        except HeatlensError as error:
            return _Made(of, None, str(error))
        return _Made(of, None if plate is None else plate.counted(), self._server.problem or "")

    @property
    def words(self) -> str:
        """Return sentences on where it listens, what is missing, and what could not be used."""
        said = (f"Listening on {self.address} ...", self.arriving, self.refusal)
        return " ".join(part for part in said if part)

    @property
    def refusal(self) -> str:
        """Return sentences on what could not be used; "" if everything could."""
        return " ".join(part for part in (self.problem, self.losses) if part)

    @property
    def losses(self) -> str:
        """Return how many packets were rejected, and why the last one was; "" for none."""
        dropped, refused = self._server.dropped, self._server.refused
        if not (dropped or refused):
            return ""
        return f"Packets dropped: {dropped}, refused: {refused}. {self._server.fault or ''}".strip()

    def close(self) -> None:
        """Stop listening; a second call does nothing."""
        self.show(False)
        self._server.close()


def _arriving(plate: Plate) -> str:
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

    def lens(self, given: Mapping[str, object]) -> StartLens:
        """Return the given lens, completed from what the renderer sent."""
        return start_lens(self.plate, given)

    def shot(self, lens: Lens, defocus: DefocusSettings) -> Shot:
        """Return a shot of the newest frame."""
        return Shot(lens, defocus, self.text, self.options)

    # The base closes nothing: the stream keeps listening, because it may be shown again.
