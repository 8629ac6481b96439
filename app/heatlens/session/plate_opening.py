"""From a name to plates in memory: opening and reading happen on threads, the loop only asks."""

from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

from heatlens.errors import HeatlensError, InputError
from heatlens.faults import faults_told
from heatlens.frame_cache.cache import Damaged, FrameCache
from heatlens.frame_cache.reader import SequenceReader, settled_options
from heatlens.model.plate_options import PlateOptions
from heatlens.plate.plate import Plate
from heatlens.scene.scene_source import is_scene_source
from heatlens.sequence.sequence import Sequence, find_sequence
from heatlens.session.scene_opening import OpenedScene, opened_scene

_BUDGET_BYTES = 2 << 30  # plates kept in memory: some eighty frames of 1080p


class News:
    """Counts what a cache tells, and passes it on."""

    def __init__(self, wake: Callable[[], None]) -> None:
        self.count = 0
        self._wake = wake

    def tell(self) -> None:
        """On one of the threads of the cache."""
        self.count += 1
        self._wake()


@dataclass(frozen=True, eq=False)
class Opened:
    """A sequence of which one frame has been read."""

    text: str  # as it was asked for
    options: PlateOptions
    cache: FrameCache
    frame: int
    plate: Plate
    news: "News"

    @property
    def settled(self) -> PlateOptions:
        """How every frame is read: as the first one was found to be."""
        return settled_options(self.options, self.plate)


@dataclass(frozen=True)
class Refused:
    """What could not be opened, and why."""

    text: str
    options: PlateOptions
    sentence: str


class PlateOpener:
    """Opens one thing at a time; what is open already stays until the new one has a picture."""

    def __init__(self, wake: Callable[[], None]) -> None:
        """`wake` is called on a thread whenever it is worth asking."""
        self._wake = wake
        self._thread = ThreadPoolExecutor(1, thread_name_prefix="open")
        self._coming: Future[Opened | OpenedScene] | None = None
        self.opening: str | None = None  # what is being opened
        self.refused: Refused | None = None  # until something else is
        self._options = PlateOptions()

    def open(self, text: str, options: PlateOptions, frame: int | None = None) -> None:
        """Begin to open a file, a pattern, a folder or a scene, its first picture being `frame`."""
        self.cancel()
        self.opening, self._options, self.refused = text, options, None
        self._coming = self._thread.submit(_opened, text, options, frame, self._wake)
        self._coming.add_done_callback(lambda _: self._wake())

    def cancel(self) -> None:
        """Forget what is being opened."""
        if self._coming is not None:
            self._coming.add_done_callback(_close_unused)
            self._coming = self.opening = None

    def poll(self) -> Opened | OpenedScene | None:
        """What has been opened since, once. Raises HeatlensError where that failed."""
        coming = self._coming
        if coming is None or not coming.done():
            return None
        text, self._coming, self.opening = self.opening, None, None
        try:
            return coming.result()
        except HeatlensError as error:
            self.refused = Refused(text or "", self._options, str(error))
            raise

    def close(self) -> None:
        """Open no more."""
        self.cancel()
        self._thread.shutdown(wait=True, cancel_futures=True)


@faults_told("The file could not be opened")
def _opened(
    text: str, options: PlateOptions, frame: int | None, wake: Callable[[], None]
) -> Opened | OpenedScene:
    if is_scene_source(text):
        return opened_scene(text)
    sequence = find_sequence(text)
    first = _first_frame(sequence, text, frame)
    news = News(wake)
    # A frame that its reader has no answer to is one that is damaged, and the others are seen.
    read = faults_told("A frame could not be read")(SequenceReader(options))
    cache = FrameCache(sequence, read, _BUDGET_BYTES, on_ready=news.tell)
    try:
        found = cache.wait(first, window=0)
        if isinstance(found, Damaged):
            raise InputError(found.sentence)
        if found is None:
            raise InputError(f"{sequence.path_at(first)} is not there.")
    except Exception:
        cache.close()
        raise
    return Opened(text, options, cache, first, found, news)


def _first_frame(sequence: Sequence, text: str, wished: int | None) -> int:
    """The wished frame where there is one, else the file that was named, else the first."""
    if wished is not None and sequence.has(wished):
        return wished
    named = sequence.frame_at(Path(text))
    return named if named is not None and sequence.has(named) else sequence.present[0]


def _close_unused(future: "Future[Opened | OpenedScene]") -> None:
    if not future.cancelled() and future.exception() is None:
        opened = future.result()
        if isinstance(opened, Opened):
            opened.cache.close()
