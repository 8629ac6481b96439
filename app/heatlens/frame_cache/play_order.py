"""Decide which frames a player needs next, and which it can drop first."""

from bisect import bisect_left, bisect_right
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

Direction = Literal[1, -1]


@dataclass(frozen=True)
class PlayOrder:
    """A playhead on sorted `frames` that moves in `direction` and reads `window` frames ahead.

    Playback loops, so the first frame follows the last.
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

    def wanted(self) -> Iterator[int]:
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
