"""The commands for focus pulls between marks."""

from collections.abc import Callable
from math import inf

from heatlens.core.model.focus.coc import sharp_dioptres
from heatlens.core.model.marks.mark import Mark
from heatlens.core.model.shot.pull import (
    EASE_PERCENT,
    PullShape,
    held_focus,
    reversed_focus,
    shaped_pull,
)
from heatlens.studio.session.marks.live_following import LiveFollowing
from heatlens.studio.session.marks.mark_distances import MarkAt, MarkDistances
from heatlens.studio.session.shared import Commands, Shared
from heatlens.studio.session.time.timeline import Timeline

PULL_FRAMES = 18  # first length of a pull: three quarters of a second at 24 fps


class FocusPulls(Commands):
    """Makes the keys of focus pulls; each pull is one undo step."""

    def __init__(
        self, shared: Shared, timeline: Timeline, distances: MarkDistances, live: LiveFollowing
    ) -> None:
        super().__init__(shared)
        self._timeline, self._distances, self._live = timeline, distances, live
        # Names of marks; None for the current focus, "" for none yet.
        self.origin: str | None = None
        self.target = self._pulled_to = ""
        self.frames = self._wished_frames = PULL_FRAMES
        self.ease_percent = EASE_PERCENT
        self.shape = PullShape.EASE
        self.made = 0  # counts pulls since the program started

    def renamed(self, before: str, after: str) -> None:
        """Keep the chosen marks when one of them gets another name."""
        self.target = after if self.target == before else self.target
        self.origin = after if self.origin == before else self.origin

    def begin(self) -> None:
        """Suggest a pull from the playhead to the next mark, as long as the last one if it fits."""
        left = self._last_frame - self._editing.frame
        self.frames = int(min(self._wished_frames, left)) if left > 0 else self._wished_frames
        self.target = self._next_mark().name
        self._distances.forget_read()

    def _next_mark(self) -> Mark:
        """Return the mark after the one in focus, or after the last one that was pulled to.

        After the last mark comes the first.
        """
        marks, lens = self._editing.shot.marks, self._editing.lens
        away = {
            abs(1.0 / far_m - 1.0 / lens.focus_distance_m): mark
            for mark in marks
            if (far_m := self._distances.focus_m(mark)) is not None
        }
        nearest = min(away, default=inf)
        before = (
            away[nearest]
            if nearest <= sharp_dioptres(lens)
            else self._editing.shot.mark_named(self._pulled_to)
        )
        return marks[(marks.index(before) + 1) % len(marks)] if before in marks else marks[0]

    def lengthen(self, frames: int) -> None:
        """Set the number of frames of pulls from now on."""
        self.frames = self._wished_frames = frames

    @property
    def _last_frame(self) -> float:
        """The last frame of the open source; infinity for a still."""
        timeline = self._timeline
        return timeline.frames.last if timeline.is_sequence and timeline.frames else inf

    @property
    def past_end(self) -> str:
        """A sentence if the pull would end after the last frame; else ""."""
        last, end = self._last_frame, self._editing.frame + self.frames
        if end <= last:
            return ""
        return f"The pull ends at frame {end}, but {last:g} is the last: the focus will not arrive."

    @property
    def arrival(self) -> int:
        """The frame at which the focus arrives, or the last one where the pull ends after it."""
        return int(min(self._editing.frame + self.frames, self._last_frame))

    @property
    def arrival_at(self) -> MarkAt:
        """What is known of the chosen mark at the frame of arrival, which is read for that."""
        target = self._editing.shot.mark_named(self.target)
        return MarkAt() if target is None else self._distances.measured(target, self.arrival)

    def make(self, then: Callable[[], None] = lambda: None) -> None:
        """Set keys for a pull from the playhead to where the chosen mark is on arrival.

        `then` is called once they are set: frames that are not in memory are read before.
        """
        named = self._editing.shot.mark_named
        target, origin = named(self.target), named(self.origin)
        if target is None:
            self._say("Choose the mark to pull to.")
            return
        if self._live.live is not None:
            self._live.pull_to(target, self.frames)
            self.made += 1
            then()
            return
        start, frames = self._editing.frame, self.frames
        here_m, past_end = self._editing.lens.focus_distance_m, self.past_end
        shape, ease = self.shape, self.ease_percent
        places = ((target, self.arrival),) + (() if origin is None else ((origin, start),))

        def pull(focus_m: tuple[float, ...]) -> None:
            to_m, from_m = focus_m[0], (*focus_m, here_m)[1]
            shot = self._editing.shot
            self._editing.do(shaped_pull(shot, from_m, to_m, start, frames, shape, ease))
            self._pulled_to = target.name
            self.made += 1
            then()
            if past_end:
                self._say(past_end)

        self._distances.ask(places, pull)

    def reverse(self) -> None:
        """Reverse the focus in time between in and out point."""
        played = self._timeline.played
        self._do(lambda shot: reversed_focus(shot, played))

    def hold(self) -> None:
        """Hold the current focus from the playhead to the next key."""
        frame = self._editing.frame
        self._do(lambda shot: held_focus(shot, frame))
