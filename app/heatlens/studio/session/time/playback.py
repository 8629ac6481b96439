"""Playback timing: decide which frame is due. It reads no file, and its clock is a parameter."""

import time
from collections.abc import Callable
from dataclasses import dataclass

from heatlens.core.model.curves.frames import Ending, FrameRange

_MIN_WAIT_S = 0.001  # with 0, the loop would neither sleep nor draw
_ROUNDING = 1e-6  # tolerance in frames


@dataclass(frozen=True)
class CutTimes:
    """The frames of the source that a cut shows one after the other, if it retimes a shot.

    rate  frames of the cut per second
    """

    frames: tuple[int, ...]
    rate: float


class Playback:
    """Moves a playhead over frames at a rate.

    is_every_frame  True waits for each frame to be ready; False keeps time and drops frames
    ending          what happens after the last frame
    direction       1 forward, -1 backward, 0 while nothing plays
    is_new_shot     the frame is the first of a shot: its time begins at the next `next_frame`
    next_shot       plays on in the next shot of a reel; returns False if there is none
    cut             how the reel retimes the open shot; None if it shows each frame once
    """

    def __init__(
        self,
        clock: Callable[[], float] = time.perf_counter,
        next_shot: Callable[[], bool] = lambda: False,
    ) -> None:
        self._clock = clock
        self.is_every_frame = True
        self.ending = Ending.LOOP
        self.direction = 0
        self.is_new_shot = False
        self.next_shot = next_shot
        self.cut: CutTimes | None = None
        self._cut_index = 0  # of the current frame in `cut`
        self._frame_time_s = 0.0  # time of the clock at which the current frame was due

    def play(self, direction: int, frame: int, frames: FrameRange) -> int:
        """Begin to play; return the frame to begin with.

        With Ending.ONCE, playing from the last frame starts again at the first.
        """
        self.direction, self._frame_time_s = direction, self._clock()
        start, end = self._ends(frames)
        is_over = self.ending is Ending.ONCE and frame == end
        return frame if frame in frames and not is_over else start

    def stop(self) -> None:
        """Stop playing; the playhead stays on the current frame."""
        self.direction = 0

    def next_frame(self, frame: int, frames: FrameRange, rate: float, is_ready: bool) -> int:
        """Return the frame to show now, and time it; `is_ready` if `frame` can be shown."""
        if self.is_new_shot:
            self.is_new_shot, self._frame_time_s, self._cut_index = False, self._clock(), 0
        rate = self._rate_of(rate)
        steps = self._steps_due(rate)
        if not self.direction or steps < 1:
            return frame
        if self.is_every_frame:
            if not is_ready:
                return frame
            steps = 1
        if self._crosses_cut(frame, steps, frames) and self.next_shot():
            self.is_new_shot = True
            return frame
        if self.is_every_frame:
            # At most one frame late: playback that was delayed continues and does not rush.
            self._frame_time_s = max(self._frame_time_s + 1 / rate, self._clock() - 1 / rate)
        else:
            self._frame_time_s += steps / rate
        return self._frame_after(frame, steps, frames)

    @property
    def _played_cut(self) -> CutTimes | None:
        """The retimed cut that plays; None if frames follow one another."""
        return self.cut if self.ending is Ending.REEL and self.direction > 0 else None

    def _rate_of(self, rate: float) -> float:
        """Return the frames per second of what plays: of the cut, else the `rate` of the shot."""
        return rate if self._played_cut is None else self._played_cut.rate

    def _index_in(self, cut: CutTimes, frame: int) -> int:
        """Return where a cut shows a frame; -1, before the start, if it does not."""
        if cut.frames[self._cut_index : self._cut_index + 1] == (frame,):
            return self._cut_index
        return cut.frames.index(frame) if frame in cut.frames else -1

    def _crosses_cut(self, frame: int, steps: int, frames: FrameRange) -> bool:
        """Return True if a frame so many steps later is after the end of a shot of a reel."""
        cut = self._played_cut
        if cut is not None:
            return self._index_in(cut, frame) + steps >= len(cut.frames)
        return self.ending is Ending.REEL and self.direction > 0 and frame + steps > frames.last

    def is_due(self, rate: float) -> bool:
        """Return True if the next frame is due."""
        return bool(self.direction) and self._steps_due(self._rate_of(rate)) >= 1

    def seconds_until_due(self, rate: float) -> float | None:
        """Return the seconds until the next frame; None if nothing plays."""
        if not self.direction:
            return None
        return max(_MIN_WAIT_S, self._frame_time_s + 1 / self._rate_of(rate) - self._clock())

    def _steps_due(self, rate: float) -> int:
        """Return how many frames later it is than the time of the frame that is shown."""
        return int((self._clock() - self._frame_time_s) * rate + _ROUNDING)

    def _ends(self, frames: FrameRange) -> tuple[int, int]:
        """Return the frames at which playback starts and ends."""
        first, last = frames.first, frames.last
        return (first, last) if self.direction > 0 else (last, first)

    def _frame_after(self, frame: int, steps: int, frames: FrameRange) -> int:
        """Return the frame that is `steps` frames later in the direction of playback."""
        cut = self._played_cut
        if cut is not None:
            self._cut_index = (self._index_in(cut, frame) + steps) % len(cut.frames)
            return cut.frames[self._cut_index]
        start, end = self._ends(frames)
        if frame not in frames:
            return start
        if self.ending is Ending.BOUNCE:
            return self._frame_after_bounce(frame, steps, frames)
        position = (frame - start) * self.direction + steps
        if self.ending is Ending.ONCE and position >= frames.count - 1:
            self.stop()
            return end
        return start + self.direction * (position % frames.count)

    def _frame_after_bounce(self, frame: int, steps: int, frames: FrameRange) -> int:
        """Return the frame `steps` later, there and back again; set the direction."""
        turn = frames.count - 1
        if turn == 0:
            return frame
        position = frame - frames.first
        position = (position if self.direction > 0 else 2 * turn - position) + steps
        position %= 2 * turn
        self.direction = 1 if position < turn else -1
        return frames.first + (position if position < turn else 2 * turn - position)
