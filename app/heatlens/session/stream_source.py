"""Frames from a running renderer for the window: plates of them are made beside the loop."""

import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

from heatlens.background import Background
from heatlens.errors import HeatlensError
from heatlens.faults import faults_told
from heatlens.model.plate_options import PlateOptions
from heatlens.plate.plate import Plate
from heatlens.stream.server import TevServer

NO_FILES = (
    "These frames come from a renderer and have no files: have it write an EXR, and open that."
)

_PAUSE_S = 0.1  # at least, between two plates: the window has other things to do


@dataclass(frozen=True, eq=False)
class OpenedStream:
    """A renderer of which the first frame has come."""

    text: str  # as it is asked for: tev://HOST:PORT
    options: PlateOptions
    plate: Plate
    frame: int = 1


@dataclass(frozen=True, eq=False)
class _Made:
    """A plate, or why there is none, and what it was made of."""

    of: tuple[int, PlateOptions]  # version of the server's images, and how they were read
    plate: Plate | None
    problem: str


class StreamSource:
    """Listens from the start until `close`; the loop asks `poll` and never waits."""

    def __init__(self, host: str, port: int) -> None:
        """Raises InputError where the address cannot be had."""
        self.wake: Callable[[], None] = lambda: None  # called on threads when it is worth asking
        self.options = PlateOptions()  # how frames are read
        self.is_wanted = False  # what comes is to be shown
        self.problem = ""  # why there is no plate of what came last, in a sentence
        self._made_of: tuple[int, PlateOptions] | None = None
        self._due_s = 0.0
        self._maker: Background[_Made] = Background(self._tell)
        self._server = TevServer(host, port, on_news=self._tell)
        name, bound = self._server.address
        self.address = f"[{name}]:{bound}" if ":" in name else f"{name}:{bound}"
        self.text = f"tev://{self.address}"

    def begin(self, options: PlateOptions) -> None:
        """Show what is there, and what comes from now on."""
        self.options, self.is_wanted, self._made_of = options, True, None

    def poll(self) -> Plate | None:
        """The newest frame, once; begins to make the next where the renderer has sent more."""
        made = self._maker.poll()
        if made is not None:
            self._made_of, self.problem = made.of, made.problem
            self._due_s = time.monotonic() + _PAUSE_S
        version = self._server.version
        is_new = version > 0 and (version, self.options) != self._made_of
        if self.is_wanted and is_new and not self._maker.is_busy:
            self._maker.start(partial(self._make, self.options, self._due_s))
        return made.plate if made is not None and self.is_wanted else None

    def _make(self, options: PlateOptions, due_s: float) -> _Made:
        """On a thread: copy what has come and read it."""
        time.sleep(max(0.0, due_s - time.monotonic()))
        of = self._server.version, options
        try:
            with faults_told("The frame that was sent could not be read"):
                plate = self._server.snapshot(options=options)
        except HeatlensError as error:
            return _Made(of, None, str(error))
        return _Made(of, plate, "" if plate is not None else self._server.problem or "")

    @property
    def words(self) -> str:
        """That it listens, and what came and could not be used."""
        said = (f"Listening on {self.address} ...", self.problem, self.losses)
        return " ".join(part for part in said if part)

    @property
    def losses(self) -> str:
        """How many packets were not taken and why the last of them was not; "" without any."""
        dropped, refused = self._server.dropped, self._server.refused
        if not (dropped or refused):
            return ""
        return f"Packets dropped: {dropped}, refused: {refused}. {self._server.fault or ''}".strip()

    def _tell(self) -> None:
        self.wake()

    def close(self) -> None:
        """Listen no more; a second time does nothing."""
        self.is_wanted = False
        self._server.close()
