"""Undo: earlier shots, one step for each gesture, named after what it changed."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields, replace

from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.option import Option, options_of
from heatlens.core.model.shot.lens_parameter import LensParameter
from heatlens.core.model.shot.settings import DefocusSettings
from heatlens.core.model.shot.shot import Shot

_STEPS_MAX = 1000
_FIELDS = {
    "source": "the file",
    "plate_options": "reading of the plate",
    "marks": "marks",
    "frames": "frames",
    "in_out": "in and out points",
    "frames_per_second": "frame rate",
    "framing": "camera",
}
_SHORT = {"focus_distance_m": "focus", "f_stop": "f-stop"}


@dataclass(frozen=True, slots=True)
class History:
    """Steps before the current shot, and undone steps.

    During a drag, `current` is ahead of `last_step`.

    past       shots that undo goes back to, the latest last
    last_step  the shot at the end of the last gesture
    current    the shot that is shown
    future     shots that redo goes forward to, the next one last
    """

    past: tuple[Shot, ...]
    last_step: Shot
    current: Shot
    future: tuple[Shot, ...] = ()

    @classmethod
    def of(cls, shot: Shot) -> "History":
        """Return a new history of a shot."""
        return cls((), shot, shot)

    @property
    def undo_words(self) -> str:
        """What undo would change, in a few words; "" if there is nothing to undo."""
        ended = self.end_gesture()
        return change_words(ended.past[-1], ended.current) if ended.past else ""

    @property
    def redo_words(self) -> str:
        """What redo would change, in a few words; "" if there is nothing to redo."""
        ended = self.end_gesture()
        return change_words(ended.current, ended.future[-1]) if ended.future else ""

    def with_current(self, shot: Shot) -> "History":
        """Return the history with `shot` as the current one; `end_gesture` makes its step."""
        return self if shot == self.current else replace(self, current=shot)

    def changed_by(self, change: Callable[[Shot], Shot]) -> "History":
        """Return the history with each shot of it changed in the same way."""
        past, future = tuple(map(change, self.past)), tuple(map(change, self.future))
        return History(past, change(self.last_step), change(self.current), future)

    def end_gesture(self) -> "History":
        """End the gesture: its changes become one step."""
        if self.current == self.last_step:
            return self
        past = (*self.past, self.last_step)[-_STEPS_MAX:]
        return History(past, self.current, self.current)

    def undo(self) -> "History":
        """Go one step back; a gesture under way is ended first."""
        ended = self.end_gesture()
        if not ended.past:
            return ended
        previous_shot = ended.past[-1]
        return History(
            ended.past[:-1], previous_shot, previous_shot, (*ended.future, ended.current)
        )

    def redo(self) -> "History":
        """Go one step forward again."""
        ended = self.end_gesture()
        if not ended.future:
            return ended
        next_shot = ended.future[-1]
        return History((*ended.past, ended.current), next_shot, next_shot, ended.future[:-1])


def change_words(before: Shot, after: Shot) -> str:
    """Return "focus", "keys of the f-stop", "marks and 2 more"; "" for two equal shots."""
    names = [
        *_changed_lens_names(before, after),
        *_changed_curve_names(before, after),
        *_changed_blur_names(before, after),
    ]
    names += [
        words for name, words in _FIELDS.items() if getattr(before, name) != getattr(after, name)
    ]
    names += [name for name in _changed_other_names(before, after)]
    if len(names) <= 2:
        return " and ".join(names)
    return f"{names[0]} and {len(names) - 1} more"


def _changed_lens_names(before: Shot, after: Shot) -> list[str]:
    """Return the names, as the window shows them, of the lens values that differ."""
    options = options_of(Lens)
    return [_field_words(name, options) for name in _differing_fields(before.lens, after.lens)]


def _changed_blur_names(before: Shot, after: Shot) -> list[str]:
    """Return the names of the blur settings that differ between two shots."""
    options = options_of(DefocusSettings)
    return [
        _field_words(name, options) for name in _differing_fields(before.defocus, after.defocus)
    ]


def _changed_curve_names(before: Shot, after: Shot) -> list[str]:
    """Return the names of the key rows that differ between two shots."""
    is_live_changed = before.curves.live != after.curves.live
    live_names = ["what the focus follows"] if is_live_changed else []
    return live_names + [
        f"keys of the {_SHORT.get(str(parameter), parameter.words)}"
        for parameter in LensParameter
        if before.curves.of(parameter) != after.curves.of(parameter)
    ]


def _changed_other_names(before: Shot, after: Shot) -> list[str]:
    """Return the fields without a name in this module."""
    handled_fields = {"lens", "curves", "defocus", *_FIELDS}
    return [
        name.replace("_", " ")
        for name in _differing_fields(before, after)
        if name not in handled_fields
    ]


def _differing_fields(before: Shot | Lens | DefocusSettings, after: object) -> list[str]:
    """Return the names of the fields whose values differ between two records of one type."""
    names = [field.name for field in fields(before)]
    return [name for name in names if getattr(before, name) != getattr(after, name)]


def _field_words(name: str, options: Mapping[str, Option]) -> str:
    """Return words for a field: a short form, those of its option, or its name."""
    if name in _SHORT:
        return _SHORT[name]
    return str(options[name].words) if name in options else name.replace("_", " ")
