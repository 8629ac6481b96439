"""Keep plates in memory within a budget of bytes."""

from bisect import bisect_left, bisect_right
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from heatlens.core.base.errors import HeatlensError, InputError
from heatlens.media.plate.estimate.trusted import UnknownNetworkError
from heatlens.media.plate.header.channel_choice import NoDepthError
from heatlens.media.plate.plate import Plate
from heatlens.media.sequence.sequence import Stamp

Direction = Literal[1, -1]


@dataclass(frozen=True)
class PlayOrder:
    """The order of playback: a playhead on sorted `frames`, and `window` frames to read ahead.

    The playhead moves in `direction`. Playback loops, so the first frame follows the last.
    """

    frames: tuple[int, ...]
    playhead: int  # one of `frames`
    direction: Direction
    window: int

    @staticmethod
    def at(frames: tuple[int, ...], frame: int, direction: Direction, window: int) -> "PlayOrder":
        """Return the order for a playhead on `frame`, else on the nearest earlier or first one."""
        playhead = frames[max(bisect_right(frames, frame) - 1, 0)]
        return PlayOrder(frames, playhead, direction, window)

    def frames_to_read(self) -> Iterator[int]:
        """Yield the playhead and the frames ahead of it, in the order of playback."""
        start, count = self._index(self.playhead), len(self.frames)
        for steps in range(min(self.window + 1, count)):
            yield self.frames[(start + steps * self.direction) % count]

    def rank(self, frame: int) -> tuple[int, int]:
        """Return a sort key; frames with a low rank are kept longest.

        Frames ahead come first, in order of playback, then those behind, the nearest first.
        """
        steps = self.direction * (self._index(frame) - self._index(self.playhead))
        ahead = steps % len(self.frames)
        return (0, ahead) if ahead <= self.window else (1, len(self.frames) - ahead)

    def _index(self, frame: int) -> int:
        return bisect_left(self.frames, frame)


Stamps = tuple[Stamp | None, ...]  # stamps of the files of one plate


@dataclass(frozen=True)
class Damaged:
    """A frame whose file cannot be read, a sentence that says why, and the kind of the error."""

    path: Path
    sentence: str
    kind: type[InputError] = InputError

    @classmethod
    def of(cls, path: Path, error: HeatlensError) -> "Damaged":
        """Return a file that cannot be read because of this error."""
        kinds_asked_about = (NoDepthError, UnknownNetworkError)
        kind = next((it for it in kinds_asked_about if isinstance(error, it)), InputError)
        return cls(path, str(error), kind)

    @property
    def error(self) -> InputError:
        """The error to raise where the frame is needed."""
        return self.kind(self.sentence)


@dataclass(frozen=True, eq=False)
class CachedPlate:
    """A plate that was read, and the `stamps` of its files before it was read."""

    content: Plate | Damaged
    stamps: Stamps

    @property
    def size_bytes(self) -> int:
        """Bytes of the color, the depth and the deep samples; notes are too small to count."""
        return plate_bytes(self.content) if isinstance(self.content, Plate) else 0


def plate_bytes(plate: Plate) -> int:
    """Return the bytes of memory that the pixels and the deep samples of `plate` take."""
    depth = plate.depth_m if plate.depth_m is not None else plate.coc_px
    deep_bytes = 0 if plate.fragments is None else plate.fragments.nbytes
    deep_bytes += 0 if plate.with_border is None else plate_bytes(plate.with_border)
    pixels = plate.color.nbytes + (0 if depth is None else depth.nbytes)
    # Each of the two parts of a cutout has as many pixels, and there is one share for each pixel.
    cutout_bytes = 0 if plate.cutout is None else 2 * pixels + plate.cutout.share.nbytes
    return pixels + cutout_bytes + deep_bytes


# Frames ahead of the playhead are kept, not those used last as in `ByteLru`: in a loop longer than
# the memory, the frame used longest ago is the one that is shown next. Space is reserved before a
# read begins, so that several threads cannot exceed the budget together.
class PlateShelf:
    """Plates by frame, and space reserved for those that are being read.

    If the frame at the playhead is larger than the whole budget, it is held alone, because it must
    be shown. Not thread-safe: the caller holds a lock.
    """

    def __init__(self, budget_bytes: int):
        self.budget_bytes = budget_bytes
        self.cached: dict[int, CachedPlate] = {}
        self.reserved: dict[int, int] = {}
        self._last_read_bytes: dict[int, int] = {}  # sizes of frames when they were last read
        self._expected_bytes = budget_bytes  # until a size is known, the first frame is read alone

    @property
    def bytes_in_use(self) -> int:
        """Bytes of the pixels held, and of the reserved space."""
        cached_bytes = sum(cached.size_bytes for cached in self.cached.values())
        return cached_bytes + sum(self.reserved.values())

    def reserve(self, frame: int, order: PlayOrder) -> bool:
        """Reserve space for `frame`, dropping frames of higher rank; return False if it cannot fit.

        Its size is assumed to be that of its last read, else that of the last frame read.
        """
        size_bytes = self._last_read_bytes.get(frame, self._expected_bytes)
        droppable = [
            candidate
            for candidate in self._by_rank(order)
            if order.rank(candidate) > order.rank(frame)
        ]
        kept_bytes = self.bytes_in_use - sum(
            self.cached[candidate].size_bytes for candidate in droppable
        )
        fits = kept_bytes + size_bytes <= self.budget_bytes
        if not fits and (kept_bytes > 0 or frame != order.playhead):
            return False
        while droppable and self.bytes_in_use + size_bytes > self.budget_bytes:
            del self.cached[droppable.pop()]
        self.reserved[frame] = size_bytes
        return True

    def put(self, frame: int, cached: CachedPlate, order: PlayOrder) -> None:
        """Put `cached` into the space reserved for `frame`, and drop others if it is larger."""
        del self.reserved[frame]
        self.cached[frame] = cached
        if cached.size_bytes:
            self._last_read_bytes[frame] = self._expected_bytes = cached.size_bytes
        self.trim(order)

    def trim(self, order: PlayOrder) -> None:
        """Drop the frames of the highest rank until the rest fits, but never the playhead's."""
        droppable = [frame for frame in self._by_rank(order) if frame != order.playhead]
        while droppable and self.bytes_in_use > self.budget_bytes:
            del self.cached[droppable.pop()]

    def keep_only(self, frames: set[int]) -> None:
        """Drop the pixels of all other frames."""
        for frame in self.cached.keys() - frames:
            del self.cached[frame]

    def drop_changed(self, frame: int) -> None:
        """Drop `frame` and its known size, because its file has changed."""
        self.cached.pop(frame, None)
        self._last_read_bytes.pop(frame, None)

    def _by_rank(self, order: PlayOrder) -> list[int]:
        """Return the frames with pixels in memory; the lowest rank, kept longest, comes first."""
        return sorted(
            (frame for frame, cached in self.cached.items() if cached.size_bytes), key=order.rank
        )
