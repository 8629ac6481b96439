"""The commands for focus pulls between marks."""

from collections.abc import Callable
from math import inf

from heatlens.core.model.focus.coc import sharp_dioptres
from heatlens.core.model.marks.mark import Mark, MarkDistance
from heatlens.core.model.shot.pull import (
    EASE_PERCENT,
    PullShape,
    hold_focus,
    reverse_focus,
    shaped_pull,
)
from heatlens.studio.session.marks.live_following import LiveFollowing
from heatlens.studio.session.marks.mark_distances import MarkDistances
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
        self.target = self._last_target = ""
        self.frames = self._preferred_frames = PULL_FRAMES
        self.ease_percent = EASE_PERCENT
        self.shape = PullShape.EASE
        self._new_names: list[str] = []  # of the marks set since the last pull
        self.pull_count = 0  # counts pulls since the program started

    def note_new_mark(self, name: str) -> None:
        """Note that a mark was set, which the next pull probably goes to."""
        self.target = name
        self._new_names.append(name)

    def rename_mark(self, old_name: str, new_name: str) -> None:
        """Follow a mark that gets another name, where it is chosen or new."""
        self.target = new_name if self.target == old_name else self.target
        self.origin = new_name if self.origin == old_name else self.origin
        self._new_names = [new_name if name == old_name else name for name in self._new_names]

    def suggest(self) -> None:
        """Suggest a pull from the playhead to the next mark, as long as the last one if it fits."""
        remaining_frames = self._last_frame - self._editing.frame
        self.frames = (
            int(min(self._preferred_frames, remaining_frames))
            if remaining_frames > 0
            else self._preferred_frames
        )
        self.target = (self._new_mark() or self._next_mark()).name
        self._distances.forget_read_distances()

    # Of several new marks the order in which they were set counts, as for a pull from A to B to C.
    def _new_mark(self) -> Mark | None:
        """Return the only mark set since the last pull, unless it is in focus already."""
        marks = [self._editing.shot.mark_named(name) for name in self._new_names]
        mark, lens = marks[0] if len(marks) == 1 else None, self._editing.lens
        focus_m = None if mark is None else self._distances.focus_m(mark)
        if focus_m is None:
            return None
        offset = abs(1.0 / focus_m - 1.0 / lens.focus_distance_m)
        return mark if offset > sharp_dioptres(lens) else None

    def _next_mark(self) -> Mark:
        """Return the mark after the one in focus, or after the target of the last pull.

        The first mark follows the last. Without either, it is the newest mark, else the first.
        """
        marks, lens = self._editing.shot.marks, self._editing.lens
        marks_by_offset = {
            abs(1.0 / focus_m - 1.0 / lens.focus_distance_m): mark
            for mark in marks
            if (focus_m := self._distances.focus_m(mark)) is not None
        }
        smallest_offset = min(marks_by_offset, default=inf)
        current_mark = (
            marks_by_offset[smallest_offset]
            if smallest_offset <= sharp_dioptres(lens)
            else self._editing.shot.mark_named(self._last_target)
        )
        if current_mark in marks:
            return marks[(marks.index(current_mark) + 1) % len(marks)]
        new_marks = [mark for mark in marks if mark.name in self._new_names]
        return new_marks[-1] if new_marks else marks[0]

    def set_length(self, frames: int) -> None:
        """Set the number of frames of this pull and of those suggested later."""
        self.frames = self._preferred_frames = frames

    @property
    def _last_frame(self) -> float:
        """The last frame of the open source; infinity for a still."""
        timeline = self._timeline
        return timeline.frames.last if timeline.is_sequence and timeline.frames else inf

    @property
    def end_warning(self) -> str:
        """A sentence if the pull would end after the last frame; else ""."""
        last_frame, end_frame = self._last_frame, self._editing.frame + self.frames
        if end_frame <= last_frame:
            return ""
        return (
            f"The pull ends at frame {end_frame}, but {last_frame:g} is the last: the focus will "
            "not arrive."
        )

    @property
    def arrival(self) -> int:
        """The frame at which the focus arrives, or the last one where the pull ends after it."""
        return int(min(self._editing.frame + self.frames, self._last_frame))

    @property
    def arrival_at(self) -> MarkDistance:
        """The distance of the target at the frame of arrival, which is read if necessary."""
        target = self._editing.shot.mark_named(self.target)
        return MarkDistance() if target is None else self._distances.measure(target, self.arrival)

    def make(self, on_done: Callable[[], None] = lambda: None) -> None:
        """Set keys for a pull from the playhead to where the chosen mark is on arrival.

        `on_done` is called once they are set; frames that are not in memory are read first.
        """
        mark_named = self._editing.shot.mark_named
        target, origin = mark_named(self.target), mark_named(self.origin)
        if target is None:
            self._notify("Choose the mark to pull to.")
            return
        if self._live.live is not None:
            self._live.pull_to(target, self.frames)
            self.pull_count += 1
            on_done()
            return
        start, frames = self._editing.frame, self.frames
        current_focus_m, end_warning = self._editing.lens.focus_distance_m, self.end_warning
        shape, ease = self.shape, self.ease_percent
        marks_at_frames = ((target, self.arrival),) + (() if origin is None else ((origin, start),))

        def pull(focus_m: tuple[float, ...]) -> None:
            """Set the keys of the pull once its distances are known; warn of near ones."""
            to_m, from_m = focus_m[0], (*focus_m, current_focus_m)[1]
            shot = self._editing.shot
            self._editing.do(shaped_pull(shot, from_m, to_m, start, frames, shape, ease))
            self._last_target, self._new_names = target.name, []
            self.pull_count += 1
            on_done()
            if end_warning:
                self._notify(end_warning)

        self._distances.request(marks_at_frames, pull)

    def reverse(self) -> None:
        """Reverse the focus in time between in and out point."""
        played = self._timeline.played
        self._do(lambda shot: reverse_focus(shot, played))

    def hold_focus(self) -> None:
        """Hold the current focus from the playhead to the next key."""
        frame = self._editing.frame
        self._do(lambda shot: hold_focus(shot, frame))
