"""Playback: advances the playhead when a frame is due, and requests the plates around it."""

from heatlens.core.base.messages import Worker
from heatlens.media.frame_cache.cache import Direction
from heatlens.studio.session.opened.picture_feed import Playhead
from heatlens.studio.session.playing.frames_ahead import FramesAhead
from heatlens.studio.session.shared import Commands, Shared
from heatlens.studio.session.time.timeline import Timeline

# Frames read ahead: two seconds while it plays, a few for the next step by hand.
_AHEAD_PLAYING, _AHEAD_AT_REST = 48, 8


class FramePlayer(Commands, Worker):
    """Shows the frame at the playhead, and the next one when its time has come."""

    def __init__(self, shared: Shared, timeline: Timeline, frames_ahead: FramesAhead) -> None:
        super().__init__(shared)
        self._timeline = timeline
        self._playback = timeline.playback
        self._frames_ahead = frames_ahead
        self._reported_problem = ""

    def poll(self) -> None:
        """Request the plate at the playhead and advance if a frame is due. Call once a frame."""
        self._request_plate()
        if self._playback.direction:
            current_frame = self._editing.frame
            played, is_ready = self._timeline.played, self._is_frame_ready(current_frame)
            frame = self._playback.next_frame(
                current_frame, played, self._frames_per_second, is_ready
            )
            if frame != current_frame and self._timeline.can_play(frame):
                self._timeline.move_playhead(frame)
                self._request_plate()
        if self._source.picture.problem != self._reported_problem:
            self._reported_problem = self._source.picture.problem
            if self._reported_problem:
                self._notify(self._reported_problem)

    def _request_plate(self) -> None:
        """Request the plate at the playhead and those around it, unless cached frames play."""
        if self._frames_ahead.plays_cached_frames:
            return
        is_playing = self._playback.direction != 0
        direction: Direction = (
            1 if (self._playback.direction or self._timeline.direction) > 0 else -1
        )
        playhead = Playhead(
            self._editing.frame,
            direction,
            is_playing,
            _AHEAD_PLAYING if is_playing else _AHEAD_AT_REST,
            self._timeline.missing,
        )
        self._source.feed.show(self._editing.shot, playhead)

    @property
    def _frames_per_second(self) -> float:
        return self._editing.shot.frames_per_second

    @property
    def is_due(self) -> bool:
        """True if the next frame of the film is due, so that the window must be drawn."""
        return self._can_advance and self._playback.is_due(self._frames_per_second)

    @property
    def _can_advance(self) -> bool:
        """True if playback need not wait for the frame at the playhead."""
        return self._is_frame_ready(self._editing.frame) or not self._playback.is_every_frame

    def _is_frame_ready(self, frame: int) -> bool:
        """Return True if the frame can be shown: rendered before, otherwise by its plate."""
        if self._frames_ahead.plays_cached_frames:
            return self._frames_ahead.is_in_memory(frame)
        return self._source.is_settled_at(frame)

    def seconds_until_needed(self) -> float | None:
        """Return the seconds that the loop may sleep; None to sleep until an event."""
        return (
            self._playback.seconds_until_due(self._frames_per_second) if self._can_advance else None
        )
