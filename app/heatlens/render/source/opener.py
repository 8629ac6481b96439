"""Open sources on threads, so that the loop of the window never waits."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any

from heatlens.core.base.background import Background
from heatlens.core.base.errors import HeatlensError
from heatlens.core.base.faults import report_faults
from heatlens.core.model.shot.framing import SceneTiming
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.media.files.apart import Stop
from heatlens.media.scene.placing import Placing
from heatlens.render.source.kinds import kind_of
from heatlens.render.source.opened import Opened, Opening
from heatlens.render.source.stream_source import OpenedStream, StreamSource


@dataclass(frozen=True)
class Refused:
    """A source that could not be opened, the options that were given, and the error."""

    text: str
    options: PlateOptions
    error: HeatlensError

    @property
    def message(self) -> str:
        """A message why it could not be opened."""
        return str(self.error)


class SourceOpener:
    """Opens one source at a time; the caller keeps the previous one until the new one arrives.

    Each is opened on its own thread, so that a disk that does not answer delays no other.
    """

    def __init__(
        self,
        wake: Callable[[], None],
        stream: StreamSource | None = None,
        placing_of: Callable[[str], Placing] = lambda _text: Placing(),
    ) -> None:
        """Set `wake`, which is called on a thread when a source has been opened.

        `stream` is a running renderer that may send frames. `placing_of` returns the user's placing
        of a scene whose file defines no unit and up axis.
        """
        self._wake = wake
        self._stream = stream
        self._current: Background[Opened] = Background(wake, drop=lambda opened: opened.close())
        self._prepared: Background[Opened] = Background(wake, drop=lambda opened: opened.close())
        self._prepared_request: object = None  # the arguments of the last call of `prepare`
        self._stop = Stop()
        self.opening: str | None = None  # the name of the source that is being opened
        self.failure: Refused | None = None  # the last failure, until another source is opened
        self._options = PlateOptions()
        self._placing_of = placing_of

    def open(
        self,
        text: str,
        options: PlateOptions,
        frame: int | None = None,
        timing: SceneTiming | None = None,
    ) -> None:
        """Begin to open a file, a pattern, a folder, a scene or the stream, showing `frame` first.

        `timing` converts the seconds of a scene to frames.
        """
        self.cancel()
        if self._stream is not None and text == self._stream.text:
            self._stream.begin(options)
            return
        self.opening, self._options, self.failure = text, options, None
        if self._prepared_request == (text, options, frame):  # it is being opened already
            self._current, self._prepared = self._prepared, self._current
        else:
            self._stop = Stop()
            self._start(self._current, text, options, frame, timing)
        self._prepared.cancel()
        self._prepared_request = None

    def prepare(self, text: str, options: PlateOptions, frame: int | None) -> None:
        """Begin to open plates that will probably be opened next, with their first picture.

        They stay open until anything is opened.
        """
        request = (text, options, frame)
        if kind_of(text).reads_plates and request != self._prepared_request:
            self._prepared_request = request
            self._start(self._prepared, text, options, frame, None)

    def _start(
        self,
        background: Background[Opened],
        text: str,
        options: PlateOptions,
        frame: int | None,
        timing: SceneTiming | None,
    ) -> None:
        """Begin to open a source on a thread of `background`, which receives the result."""
        placing = self._placing_of(text)
        opening = Opening(
            text=text,
            options=options,
            frame=frame,
            timing=timing,
            placing=placing,
            wake=self._wake,
            stop=self._stop,
        )
        background.start(partial(_open, opening))

    def cancel(self) -> None:
        """Cancel the opening without waiting, and end the process that reads a scene."""
        self._stop.request()
        self._current.cancel()
        self.opening = None

    def poll(self) -> Opened | None:
        """Return an opened source, once. Stores a failure, and raises its HeatlensError."""
        try:
            opened = self._current.poll()
        except HeatlensError as error:
            self.failure = Refused(self.opening or "", self._options, error)
            self.opening = None
            raise
        if opened is None:
            return self._poll_stream()
        self.opening = None
        return opened

    def _poll_stream(self) -> OpenedStream | None:
        """Return the stream when its first frame has arrived; None if nobody waits for it."""
        stream = self._stream
        plate = None if stream is None or stream.is_shown else stream.poll()
        if stream is None or plate is None:
            return None
        return OpenedStream(stream.text, plate.notes, stream, plate)

    def close(self) -> None:
        """Cancel the opening, without waiting."""
        self.cancel()
        self._prepared.cancel()


@report_faults("The file could not be opened")
def _open(opening: Opening) -> Opened:
    """Open a source with its first picture; runs on a thread."""
    return kind_of(opening.text).open_source(opening)


def only_once_reason(opened: Opened) -> str:
    """Return why the frames of an opened source cannot be rendered again later; "" if they can."""
    return "" if opened.render_source is not None else kind_of(opened.text).refusal


def feed_of(opened: Opened, picture: object) -> Any:
    """Return the feed that brings the pictures of an opened source to the GPU, for the window."""
    return kind_of(opened.text).feed(picture, opened)
