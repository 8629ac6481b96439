"""Keep the frames of the open source and move the playhead over them."""

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Literal

from heatlens.core.base.errors import InputError
from heatlens.core.base.messages import Problem
from heatlens.core.model.curves.frames import Ending, FrameRange
from heatlens.core.model.curves.key_edits import SAME_FRAME
from heatlens.core.model.shot.shot import Shot
from heatlens.core.model.timecode import parse_timecode
from heatlens.media.frame_cache.cache import FrameCache
from heatlens.media.frame_cache.frame_states import FrameStates, Run
from heatlens.media.sequence.sequence import MissingPolicy
from heatlens.studio.session.shared import Commands, Shared
from heatlens.studio.session.time.playback import Playback

_STILL_REACH = 100_000  # largest frame number that the playhead can reach on a still
_MAX_FRAMES = 1_000_000  # largest number of frames of a shot


class Timeline(Commands):
    """The frames of the open source, and the commands that move the playhead."""

    def __init__(self, shared: Shared, next_shot: Callable[[], bool] = lambda: False) -> None:
        """Begin at frame 0; `next_shot` plays on in the next shot of a reel, see `Playback`."""
        super().__init__(shared)
        self.playback = Playback(next_shot=next_shot)
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
    def key_frames(self) -> tuple[float, ...]:
        """The frames at which the lens or the camera has a key, in order."""
        shot = self._editing.shot
        return tuple(sorted({*shot.key_frames, *shot.camera_key_frames}))

    @property
    def frames(self) -> FrameRange | None:
        """The frames of the source; for a still, the range of its keys."""
        if self._opened_frames is not None:
            return self._opened_frames
        key_frames = self.key_frames
        return _range(key_frames[0], key_frames[-1]) if key_frames else None

    @property
    def timed_shot(self) -> Shot:
        """The shot with the present range of frames."""
        shot, frames = self._editing.shot, self.frames
        return shot if shot.frames == frames else replace(shot, frames=frames)

    @property
    def played(self) -> FrameRange:
        """The frames from in to out, or all of them."""
        frame = self._editing.frame
        return self.timed_shot.played_frames or FrameRange(frame, frame)

    @property
    def visible_range(self) -> FrameRange:
        """The range that the timeline shows: all frames, keys and the playhead."""
        frame = self._editing.frame
        key_frames, frames = self.key_frames, self.frames or FrameRange(frame, frame)
        ends = [frames.first, frames.last, frame, *key_frames[:1], *key_frames[-1:]]
        return _range(min(ends), max(ends))

    def runs(self) -> tuple[Run, ...]:
        """Return the states of the frames (read, waiting, damaged) as runs of equal ones."""
        return () if self.cache is None else self._states.runs(self.cache, self._states_version)

    @property
    def is_outdated(self) -> bool:
        """True while there are changes that `runs` has not returned yet."""
        return self.cache is not None and self._states.is_outdated(self.cache, self._states_version)

    @property
    def _states_version(self) -> object:
        """A value that changes whenever the states of frames may: a count, and the last request."""
        opened = self._source.opened
        return (opened.change_count if opened else 0, self._source.feed.last_request)

    @property
    def timecode(self) -> str:
        """The timecode of the frame at the playhead; "" if it has none."""
        frame_timecode = self._source.timecode_at(self.timed_shot, self._editing.frame)
        return "" if frame_timecode is None else str(frame_timecode[1])

    def start_timecode(self, text: str) -> str:
        """Return the timecode of the first frame, given that of this one; "" for an empty text."""
        if not text.strip():
            return ""
        shot, frame, timecode = self.timed_shot, self._editing.frame, parse_timecode(text)
        reason = timecode.mismatch_message(shot.frames_per_second)
        if reason:
            raise InputError(reason)
        first_frame = frame if shot.span is None else shot.span.first
        return str(timecode.add_frames(first_frame - frame, shot.frames_per_second))

    # Commands

    def go_to(self, frame: int) -> None:
        """Move the playhead to a frame and stop playback."""
        self.playback.stop()
        low, high = -_STILL_REACH, _STILL_REACH
        if self.is_sequence:
            low, high = self.visible_range.first, self.visible_range.last
        self.move_playhead(min(max(frame, low), high))

    def move_playhead(self, frame: int) -> None:
        """Move the playhead without stopping playback; the direction becomes that of the move."""
        old_frame = self._editing.frame
        if frame != old_frame:
            self._editing.frame = frame
            self.direction = 1 if frame > old_frame else -1

    def step(self, frames: int) -> None:
        """Move the playhead by a number of frames, which may be negative."""
        self.go_to(self._editing.frame + frames)

    def go_to_end(self, direction: int) -> None:
        """Go to the first (-1) or the last (1) played frame."""
        self.go_to(self.played.last if direction > 0 else self.played.first)

    def go_to_key(self, direction: int) -> None:
        """Go to the next (1) or previous (-1) key of any parameter."""
        frame, key_frames = self._editing.frame, self.key_frames
        later_keys = [
            math.ceil(key_frame) for key_frame in key_frames if key_frame > frame + SAME_FRAME
        ]
        earlier_keys = [
            math.floor(key_frame) for key_frame in key_frames if key_frame < frame - SAME_FRAME
        ]
        if direction > 0 and later_keys:
            self.go_to(later_keys[0])
        elif direction < 0 and earlier_keys:
            self.go_to(earlier_keys[-1])

    def play(self, direction: int) -> None:
        """Play in a direction, or stop if it plays in that direction."""
        is_single_frame = self.played.count == 1 and self.playback.ending is not Ending.REEL
        if self.playback.direction == direction or is_single_frame:
            self.playback.stop()
        else:
            self.move_playhead(self.playback.play(direction, self._editing.frame, self.played))

    def can_play(self, frame: int) -> bool:
        """Return True if `frame` can be played; at a gap that ends playback, stop and report it."""
        try:
            if self.cache is not None:
                self.cache.sequence.shown_frame(frame, self.missing)
        except InputError as error:
            self.playback.stop()
            self._notify(Problem(error))
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
        """Set in and out point as an undo step; none if they are the ends of the source."""
        frames = FrameRange(first, last)
        is_all = frames == self.frames
        self._editing.do(replace(self._editing.shot, in_out=None if is_all else frames))

    def clear_in_out(self) -> None:
        """Clear in and out point, so that all frames are played and exported."""
        self._editing.do(replace(self._editing.shot, in_out=None))


def _range(first: float, last: float) -> FrameRange:
    """Return a frame range, limited to the largest length of a shot, since keys can be anywhere."""
    low = math.floor(first)
    return FrameRange(low, min(math.ceil(last), low + _MAX_FRAMES - 1))
