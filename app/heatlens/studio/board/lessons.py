"""Lessons for three gestures, shown on the demos; each disappears once it is done."""

from enum import StrEnum

from heatlens.core.base.paths import data_dir
from heatlens.media.scene.scene_read import DEMO
from heatlens.studio.session.marks.mark_commands import MarkCommands
from heatlens.studio.session.shot.editing import Editing


class Lesson(StrEnum):
    """A gesture, explained to a new user."""

    CLICK = "Click on something: it becomes sharp."
    DRAG = "Drag over the picture, or the focus bar: the focus follows."
    PULL = "Click and press M to set a mark. Focus elsewhere: Shift+M pulls to the mark."


class Lessons:
    """The gestures that are still to be learned, if lessons are shown at all."""

    def __init__(self, editing: Editing, marks: MarkCommands) -> None:
        self._editing = editing
        self._marks = marks
        self._learned: set[Lesson] = set()
        self._last_focus: tuple[int, float] | None = None  # frame and focus at the last `watch`
        self._initial_pull_count = marks.pulls.pull_count
        self.is_dismissed = False

    @property
    def remaining(self) -> tuple[Lesson, ...]:
        """The lessons for the open source; none for a file of the user."""
        still_life = str(data_dir("assets") / "still_life.exr")
        if self.is_dismissed or self._editing.shot.source not in (DEMO, still_life):
            return ()
        return tuple(lesson for lesson in Lesson if lesson not in self._learned)

    def watch(self, is_dragging: bool, is_pressed: bool) -> None:
        """Check which gestures were done since the last frame of the window."""
        current_focus = self._editing.frame, self._editing.lens.focus_distance_m
        if (
            self._last_focus is not None
            and current_focus[0] == self._last_focus[0]
            and current_focus[1] != self._last_focus[1]
        ):
            if is_dragging:
                self._learned.add(Lesson.DRAG)
            elif is_pressed:
                self._learned.add(Lesson.CLICK)
        self._last_focus = current_focus
        if self._marks.pulls.pull_count > self._initial_pull_count:
            self._learned.add(Lesson.PULL)
