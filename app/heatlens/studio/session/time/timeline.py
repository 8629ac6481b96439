"""Keep the frames of the open source and move the playhead over them.

The timeline draws the states of frames under its ruler, as runs of equal ones.
"""

import math
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from itertools import groupby
from typing import Literal

from heatlens.core.base.errors import InputError
from heatlens.core.model.curves.curve import SAME_FRAME
from heatlens.core.model.curves.frames import FrameRange
from heatlens.core.model.shot.shot import Shot
from heatlens.core.model.timecode import parse_timecode
from heatlens.media.frame_cache.cache import FrameCache, FrameState
from heatlens.media.sequence.sequence import MissingPolicy
from heatlens.studio.session.messages import Problem
from heatlens.studio.session.shared import Commands, Shared
from heatlens.studio.session.time.playback import Ending, Playback

_PART = 0.05  # the largest share of the time that may be spent on this


@dataclass(frozen=True, slots=True)
class Run:
    """Neighbouring frames, first to last, in the same state."""

    first: int
    last: int
    state: FrameState


class FrameStates:
    """The runs of a cache, updated when it changes, and less often for a long film."""

    def __init__(self, clock: Callable[[], float] = time.perf_counter) -> None:
        self._clock = clock
        self._made_of: object = None
        self._not_before = 0.0
        self._runs: tuple[Run, ...] = ()

    def runs(self, cache: FrameCache, news: object) -> tuple[Run, ...]:
        """Return the current runs; `news` differs whenever they may have changed."""
        now = self._clock()
        if (cache, news) != self._made_of and now >= self._not_before:
            self._runs, self._made_of = runs_of(cache.states()), (cache, news)
            self._not_before = now + (self._clock() - now) / _PART
        return self._runs

    def is_behind(self, cache: FrameCache, news: object) -> bool:
        """Return True while there are changes that `runs` has not returned yet."""
        return (cache, news) != self._made_of


def runs_of(states: Mapping[int, FrameState]) -> tuple[Run, ...]:
    """Join neighbours in the same state; frames that are only on disk are in no run."""
    runs = []
    for state, frames in groupby(states, key=states.__getitem__):
        if state != "absent":
            first = last = next(frames)
            for last in frames:  # noqa: B007  # groupby's iterators have no last
                pass
            runs.append(Run(first, last, state))
    return tuple(runs)


_STILL_REACH = 100_000  # largest frame number that the playhead can reach on a still
_FRAMES_MOST = 1_000_000  # largest number of frames of a shot


class Timeline(Commands):
    """The frames of the open source, and the commands that move the playhead."""

    def __init__(self, shared: Shared) -> None:
        super().__init__(shared)
        self.playback = Playback()
        self.missing: MissingPolicy = "hold"
        self.direction: Literal[1, -1] = 1  # direction of the latest movement
        self._states = FrameStates()

    # State

    @property
    def cache(self) -> FrameCache | None:
        """The frame cache of an open sequence; None for a scene or a stream."""
        opened = self._source.opened
        return None if opened is None else opened.cache

    @property
    def is_sequence(self) -> bool:
        """True if the source has more than one frame."""
        return self._source.is_sequence

    @property
    def _opened_frames(self) -> FrameRange | None:
        opened = self._source.opened
        return None if opened is None else opened.frames

    @property
    def has_time(self) -> bool:
        """True if there are several frames, or keys."""
        return self._editing.has_time

    @property
    def is_shown(self) -> bool:
        """True if something is open that has several frames, or keys."""
        return self._source.plate is not None and self.has_time

    @property
    def _keyed(self) -> tuple[float, ...]:
        """The frames at which the lens or the camera has a key, in order."""
        shot = self._editing.shot
        return tuple(sorted({*shot.key_frames, *shot.camera_key_frames}))

    @property
    def frames(self) -> FrameRange | None:
        """The frames of the source; for a still, the range of its keys."""
        if self._opened_frames is not None:
            return self._opened_frames
        keyed = self._keyed
        return _range(keyed[0], keyed[-1]) if keyed else None

    @property
    def timed_shot(self) -> Shot:
        """The shot with the present range of frames."""
        shot, frames = self._editing.shot, self.frames
        return shot if shot.frames == frames else replace(shot, frames=frames)

    @property
    def played(self) -> FrameRange:
        """The frames from in to out, or all of them."""
        frame = self._editing.frame
        return self.timed_shot.played or FrameRange(frame, frame)

    @property
    def reach(self) -> FrameRange:
        """The range that the timeline shows: all frames, keys and the playhead."""
        frame = self._editing.frame
        keyed, frames = self._keyed, self.frames or FrameRange(frame, frame)
        ends = [frames.first, frames.last, frame, *keyed[:1], *keyed[-1:]]
        return _range(min(ends), max(ends))

    def runs(self) -> tuple[Run, ...]:
        """Return the states of the frames (read, waiting, damaged) as runs of equal ones."""
        return () if self.cache is None else self._states.runs(self.cache, self._news)

    @property
    def is_behind(self) -> bool:
        """True while there are changes that `runs` has not returned yet."""
        return self.cache is not None and self._states.is_behind(self.cache, self._news)

    @property
    def _news(self) -> object:
        opened = self._source.opened
        return (opened.news if opened else 0, self._source.feed.wanted)

    @property
    def timecode(self) -> str:
        """The timecode of the frame at the playhead; "" if it has none."""
        timed = self._source.timecode_at(self.timed_shot, self._editing.frame)
        return "" if timed is None else str(timed[1])

    def start_timecode(self, text: str) -> str:
        """Return the timecode of the first frame, given that of this one; "" for an empty text."""
        if not text.strip():
            return ""
        shot, frame, timecode = self.timed_shot, self._editing.frame, parse_timecode(text)
        why = timecode.why_not(shot.frames_per_second)
        if why:
            raise InputError(why)
        first = frame if shot.span is None else shot.span.first
        return str(timecode.later(first - frame, shot.frames_per_second))

    # Commands

    def go(self, frame: int) -> None:
        """Move the playhead to a frame and stop playback."""
        self.playback.stop()
        low, high = -_STILL_REACH, _STILL_REACH
        if self.is_sequence:
            low, high = self.reach.first, self.reach.last
        self.put(min(max(frame, low), high))

    def put(self, frame: int) -> None:
        """Move the playhead to a frame without stopping playback."""
        before = self._editing.frame
        if frame != before:
            self._editing.frame = frame
            self.direction = 1 if frame > before else -1

    def step(self, frames: int) -> None:
        """Move the playhead by a number of frames, which may be negative."""
        self.go(self._editing.frame + frames)

    def go_to_end(self, direction: int) -> None:
        """Go to the first (-1) or the last (1) played frame."""
        self.go(self.played.last if direction > 0 else self.played.first)

    def go_to_key(self, direction: int) -> None:
        """Go to the next (1) or previous (-1) key of any parameter."""
        frame, keyed = self._editing.frame, self._keyed
        later = [math.ceil(k) for k in keyed if k > frame + SAME_FRAME]
        earlier = [math.floor(k) for k in keyed if k < frame - SAME_FRAME]
        if direction > 0 and later:
            self.go(later[0])
        elif direction < 0 and earlier:
            self.go(earlier[-1])

    def play(self, direction: int) -> None:
        """Play in a direction, or stop if it plays in that direction."""
        stays = self.played.count == 1 and self.playback.ending is not Ending.REEL
        if self.playback.direction == direction or stays:
            self.playback.stop()
        else:
            self.put(self.playback.play(direction, self._editing.frame, self.played))

    def may_play(self, frame: int) -> bool:
        """Return True if `frame` can be played; at a gap that ends playback, stop and report it."""
        try:
            if self.cache is not None:
                self.cache.sequence.shown_frame(frame, self.missing)
        except InputError as error:
            self.playback.stop()
            self._say(Problem(error))
            return False
        return True

    def set_in(self) -> None:
        """Set the in point, the first played and exported frame, at the playhead."""
        frame = self._editing.frame
        self._set_in_out(frame, max(frame, self.played.last))

    def set_out(self) -> None:
        """Set the out point, the last played and exported frame, at the playhead."""
        frame = self._editing.frame
        self._set_in_out(min(frame, self.played.first), frame)

    def _set_in_out(self, first: int, last: int) -> None:
        frames = FrameRange(first, last)
        whole = frames == self.frames
        self._editing.do(replace(self._editing.shot, in_out=None if whole else frames))

    def clear_in_out(self) -> None:
        """Clear in and out point, so that all frames are played and exported."""
        self._editing.do(replace(self._editing.shot, in_out=None))


def _range(first: float, last: float) -> FrameRange:
    """Return a frame range, limited to the largest length of a shot, since keys can be anywhere."""
    low = math.floor(first)
    return FrameRange(low, min(math.ceil(last), low + _FRAMES_MOST - 1))
