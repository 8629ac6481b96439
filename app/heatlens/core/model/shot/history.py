"""Undo: earlier shots, one step for each gesture, named after what it changed."""

from collections.abc import Mapping
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
    """Steps before `now`, and undone steps. During a drag, `now` is ahead of the last step.

    past      shots that undo goes back to, the latest last
    settled   the shot at the end of the last gesture
    now       what is seen
    future    shots that redo goes forward to, the next one last
    """

    past: tuple[Shot, ...]
    settled: Shot
    now: Shot
    future: tuple[Shot, ...] = ()

    @classmethod
    def of(cls, shot: Shot) -> "History":
        """Return a new history of a shot."""
        return cls((), shot, shot)

    @property
    def undo_words(self) -> str:
        """What undo would change, in a few words; "" if there is nothing to undo."""
        rest = self.at_rest()
        return change_words(rest.past[-1], rest.now) if rest.past else ""

    @property
    def redo_words(self) -> str:
        """What redo would change, in a few words; "" if there is nothing to redo."""
        rest = self.at_rest()
        return change_words(rest.now, rest.future[-1]) if rest.future else ""

    def changed(self, shot: Shot) -> "History":
        """Show `shot` now; its step is made when the gesture ends."""
        return self if shot == self.now else replace(self, now=shot)

    def at_rest(self) -> "History":
        """End the gesture: its changes become one step."""
        if self.now == self.settled:
            return self
        past = (*self.past, self.settled)[-_STEPS_MAX:]
        return History(past, self.now, self.now)

    def undone(self) -> "History":
        """Go one step back; a gesture under way is ended first."""
        rest = self.at_rest()
        if not rest.past:
            return rest
        before = rest.past[-1]
        return History(rest.past[:-1], before, before, (*rest.future, rest.now))

    def redone(self) -> "History":
        """Go one step forward again."""
        rest = self.at_rest()
        if not rest.future:
            return rest
        after = rest.future[-1]
        return History((*rest.past, rest.now), after, after, rest.future[:-1])


def change_words(before: Shot, after: Shot) -> str:
    """Return "focus", "keys of the f-stop", "marks and 2 more"; "" for two equal shots."""
    changed = [*_lens(before, after), *_curves(before, after), *_blur(before, after)]
    changed += [
        words for name, words in _FIELDS.items() if getattr(before, name) != getattr(after, name)
    ]
    changed += [name for name in _others(before, after)]
    if len(changed) <= 2:
        return " and ".join(changed)
    return f"{changed[0]} and {len(changed) - 1} more"


def _lens(before: Shot, after: Shot) -> list[str]:
    options = options_of(Lens)
    return [_named(name, options) for name in _differing(before.lens, after.lens)]


def _blur(before: Shot, after: Shot) -> list[str]:
    options = options_of(DefocusSettings)
    return [_named(name, options) for name in _differing(before.defocus, after.defocus)]


def _curves(before: Shot, after: Shot) -> list[str]:
    is_other = before.curves.live != after.curves.live
    return ["what the focus follows"] * is_other + [
        f"keys of the {_SHORT.get(str(parameter), parameter.words)}"
        for parameter in LensParameter
        if before.curves.of(parameter) != after.curves.of(parameter)
    ]


def _others(before: Shot, after: Shot) -> list[str]:
    """Return the fields without a name in this module."""
    known = {"lens", "curves", "defocus", *_FIELDS}
    return [name.replace("_", " ") for name in _differing(before, after) if name not in known]


def _differing(before: Shot | Lens | DefocusSettings, after: object) -> list[str]:
    names = [field.name for field in fields(before)]
    return [name for name in names if getattr(before, name) != getattr(after, name)]


def _named(name: str, options: Mapping[str, Option]) -> str:
    if name in _SHORT:
        return _SHORT[name]
    return str(options[name].words) if name in options else name.replace("_", " ")
