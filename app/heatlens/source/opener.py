"""Open sources on threads, so that the loop of the window never waits."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from heatlens.background import Background
from heatlens.errors import HeatlensError, InputError
from heatlens.faults import faults_reported
from heatlens.files.apart import Stop
from heatlens.frame_cache.cache import Damaged, FrameCache
from heatlens.frame_cache.reader import SequenceReader
from heatlens.model.framing import SceneTiming
from heatlens.model.plate_options import PlateOptions
from heatlens.scene.placing import Placing
from heatlens.sequence.sequence import Sequence
from heatlens.source.kind import SourceKind, kind_of
from heatlens.source.one_size import sequence_of_one_size
from heatlens.source.opened import News, Opened, OpenedPlates, OpenedStream, opened_scene
from heatlens.source.plate_source import PlateSource
from heatlens.source.stream_source import StreamSource

_BUDGET_BYTES = 2 << 30  # plates kept in memory: some eighty frames of 1080p


@dataclass(frozen=True)
class Refused:
    """A source that could not be opened, and why."""

    text: str
    options: PlateOptions
    sentence: str


class SourceOpener:
    """Opens one source at a time; the caller keeps the one before until the new one arrives.

    Each is opened on a thread of its own, so that a disk that does not answer holds up no other.
    """

    def __init__(self, wake: Callable[[], None], stream: StreamSource | None = None) -> None:
        """Set `wake`, which is called on a thread when a source has been opened.

        `stream` is a running renderer that may send frames.
        """
        self._wake = wake
        self._stream = stream
        self._coming: Background[Opened] = Background(wake, drop=lambda opened: opened.close())
        self._stop = Stop()
        self.opening: str | None = None  # the name of the source that is being opened
        self.refused: Refused | None = None  # the last failure, until another source is opened
        self._options = PlateOptions()
        # What the user said of a scene whose file does not say its unit and which way is up.
        self.placing_of: Callable[[str], Placing] = lambda text: Placing()

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
        self.opening, self._options, self.refused = text, options, None
        self._stop = Stop()
        when, placing = (frame, timing), self.placing_of(text)
        self._coming.start(partial(_opened, text, options, when, placing, self._wake, self._stop))

    def cancel(self) -> None:
        """Cancel the opening without waiting, and end the process that reads a scene."""
        self._stop.ask()
        self._coming.cancel()
        self.opening = None

    def poll(self) -> Opened | None:
        """Return a source once when it has been opened. Raises HeatlensError if that failed."""
        try:
            opened = self._coming.poll()
        except HeatlensError as error:
            self.refused = Refused(self.opening or "", self._options, str(error))
            self.opening = None
            raise
        if opened is None:
            return self._first_of_stream()
        self.opening = None
        return opened

    def _first_of_stream(self) -> OpenedStream | None:
        """Return the stream when its first frame arrives; None if that is not awaited."""
        stream = self._stream
        plate = None if stream is None or stream.is_shown else stream.poll()
        return None if stream is None or plate is None else OpenedStream(stream, plate)

    def close(self) -> None:
        """Cancel the opening, without waiting."""
        self.cancel()


@faults_reported("The file could not be opened")
def _opened(
    text: str,
    options: PlateOptions,
    when: tuple[int | None, SceneTiming | None],
    placing: Placing,
    wake: Callable[[], None],
    stop: Stop,
) -> Opened:
    frame, timing = when
    if kind_of(text) is SourceKind.SCENE:
        with stop.heard():
            return opened_scene(text, options, timing, placing)
    source = PlateSource(text, sequence_of_one_size(text), options)
    first, news = _first_frame(source.sequence, text, frame), News(wake)
    reader = SequenceReader(options, source.first_file)  # as an export reads the sequence
    # A fault of the program in one frame makes that frame damaged; the others are still shown.
    read = faults_reported("A frame could not be read")(reader)
    cache = FrameCache(
        source.sequence, read, _BUDGET_BYTES, on_ready=news.tell, files_of=source.files_of
    )
    try:
        found = cache.wait(first, window=0)
        if isinstance(found, Damaged):
            raise InputError(found.sentence)
        if found is None:
            raise InputError(f"{source.sequence.path_at(first)} is not there.")
    except Exception:
        cache.close()
        raise
    return OpenedPlates(source, cache, first, found, news)


def _first_frame(sequence: Sequence, text: str, wanted: int | None) -> int:
    """Return the wanted frame if it exists, else that of the named file, else the first."""
    if wanted is not None and sequence.has(wanted):
        return wanted
    named = sequence.frame_at(Path(text))
    return named if named is not None and sequence.has(named) else sequence.present[0]
