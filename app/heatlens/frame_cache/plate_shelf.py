"""Plates in memory, never more of them than a budget of bytes allows."""

from dataclasses import dataclass
from pathlib import Path

from heatlens.frame_cache.play_order import PlayOrder
from heatlens.plate.plate import Plate
from heatlens.sequence.sequence import Stamp

Stamps = tuple[Stamp | None, ...]  # of the files that one plate is read from


@dataclass(frozen=True)
class Damaged:
    """A frame whose file cannot be read: why, in a sentence."""

    path: Path
    sentence: str


@dataclass(frozen=True, eq=False)
class Held:
    """A plate that was read, and the `stamps` of its files before it was read."""

    content: Plate | Damaged
    stamps: Stamps

    @property
    def size_bytes(self) -> int:
        """Bytes of colour, depth and what lies behind; notes are too small to count."""
        return plate_bytes(self.content) if isinstance(self.content, Plate) else 0


def plate_bytes(plate: Plate) -> int:
    """Return the memory that the pixels of `plate` take, and what is known behind them."""
    depth = plate.depth_m if plate.depth_m is not None else plate.coc_px
    lists = 0 if plate.fragments is None else plate.fragments.nbytes
    return plate.color.nbytes + (0 if depth is None else depth.nbytes) + lists


class PlateShelf:
    """Plates by frame, and room reserved for those that are being read.

    The frame at the playhead may be larger than the whole budget: it is then held alone, because it
    must be seen. Not safe for several threads at once: the caller locks.
    """

    def __init__(self, budget_bytes: int):
        self.budget_bytes = budget_bytes
        self.held: dict[int, Held] = {}
        self.reserved: dict[int, int] = {}
        self._known_bytes: dict[int, int] = {}  # of frames read before, as they were then
        self._usual_bytes = budget_bytes  # nothing read yet: the first frame is read alone

    @property
    def bytes_in_use(self) -> int:
        """Pixels held, and room set aside."""
        held_bytes = sum(held.size_bytes for held in self.held.values())
        return held_bytes + sum(self.reserved.values())

    def reserve(self, frame: int, order: PlayOrder) -> bool:
        """Set room aside for `frame`, at the cost of frames worth less; False where they free none.

        Its size is taken to be what it was before, else that of the last frame read.
        """
        size_bytes = self._known_bytes.get(frame, self._usual_bytes)
        victims = [f for f in self._by_rank(order) if order.rank(f) > order.rank(frame)]
        kept_bytes = self.bytes_in_use - sum(self.held[f].size_bytes for f in victims)
        fits = kept_bytes + size_bytes <= self.budget_bytes
        if not fits and (kept_bytes > 0 or frame != order.playhead):
            return False
        while victims and self.bytes_in_use + size_bytes > self.budget_bytes:
            del self.held[victims.pop()]
        self.reserved[frame] = size_bytes
        return True

    def put(self, frame: int, held: Held, order: PlayOrder) -> None:
        """Put `held` into the room reserved for `frame`.

        Correct a reservation that was too small.
        """
        del self.reserved[frame]
        self.held[frame] = held
        if held.size_bytes:
            self._known_bytes[frame] = self._usual_bytes = held.size_bytes
        self.trim(order)

    def trim(self, order: PlayOrder) -> None:
        """Give up what is worth least until the rest fits, but never the frame at the playhead."""
        victims = [frame for frame in self._by_rank(order) if frame != order.playhead]
        while victims and self.bytes_in_use > self.budget_bytes:
            del self.held[victims.pop()]

    def keep_only(self, frames: set[int]) -> None:
        """Let the pixels of all others go."""
        for frame in self.held.keys() - frames:
            del self.held[frame]

    def forget(self, frame: int) -> None:
        """Drop what is held of `frame`, for its file is another now."""
        self.held.pop(frame, None)
        self._known_bytes.pop(frame, None)

    def _by_rank(self, order: PlayOrder) -> list[int]:
        """Return the frames that hold pixels, the most wanted first."""
        return sorted((f for f, held in self.held.items() if held.size_bytes), key=order.rank)
