"""Playback: advances the playhead when a frame is due, and requests the plates around it."""

from heatlens.media.frame_cache.cache import Direction
from heatlens.studio.session.messages import Worker
from heatlens.studio.session.opened.picture_feed import Playhead
from heatlens.studio.session.playing.rendered_pull import RenderedPull
from heatlens.studio.session.shared import Commands, Shared
from heatlens.studio.session.time.timeline import Timeline

# Frames read ahead: two seconds while it plays, a few for the next step by hand.
_AHEAD_PLAYING, _AHEAD_STILL = 48, 8


class FramePlayer(Commands, Worker):
    """Shows the frame at the playhead, and the next one when its time has come."""

    def __init__(self, shared: Shared, timeline: Timeline, pull: RenderedPull) -> None:
        super().__init__(shared)
        self._timeline = timeline
        self._playback = timeline.playback
        self._pull = pull
        self._said = ""

    def poll(self) -> None:
        """Request the plate at the playhead and advance if a frame is due. Call once a frame."""
        self._show()
        if self._playback.direction:
            now = self._editing.frame
            played, is_ready = self._timeline.played, self._is_there(now)
            frame = self._playback.moved(now, played, self._rate, is_ready)
            if frame != now and self._timeline.may_play(frame):
                self._timeline.put(frame)
                self._show()
        if self._source.picture.problem != self._said:
            self._said = self._source.picture.problem
            if self._said:
                self._say(self._said)

    def _show(self) -> None:
        if self._pull.is_alone:
            return
        is_playing = self._playback.direction != 0
        direction: Direction = (
            1 if (self._playback.direction or self._timeline.direction) > 0 else -1
        )
        playhead = Playhead(
            self._editing.frame,
            direction,
            is_playing,
            _AHEAD_PLAYING if is_playing else _AHEAD_STILL,
            self._timeline.missing,
        )
        self._source.feed.show(self._editing.shot, playhead)

    @property
    def _rate(self) -> float:
        return self._editing.shot.frames_per_second

    @property
    def is_due(self) -> bool:
        """Return True if the next frame of the film is due, so that the window must be drawn."""
        return self._waits_for_nothing and self._playback.is_due(self._rate)

    @property
    def _waits_for_nothing(self) -> bool:
        return self._is_there(self._editing.frame) or not self._playback.is_every_frame

    def _is_there(self, frame: int) -> bool:
        """Return True if the frame can be shown: rendered before, otherwise by its plate."""
        if self._pull.is_alone:
            return self._pull.is_at_hand(frame)
        return self._source.is_settled_at(frame)

    def seconds_until_needed(self) -> float | None:
        """Return the seconds that the loop may sleep; None: until a plate is read, or for ever."""
        return self._playback.seconds_until_due(self._rate) if self._waits_for_nothing else None
