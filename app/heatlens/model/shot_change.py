"""Describe the difference of two shots in a few words, to name an undo step."""

from dataclasses import fields
from typing import Any

from heatlens.model.lens import Lens
from heatlens.model.option import options_of
from heatlens.model.settings import DefocusSettings
from heatlens.model.shot import LensParameter, Shot

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
    told = options_of(Lens)
    return [_named(name, told) for name in _differing(before.lens, after.lens)]


def _blur(before: Shot, after: Shot) -> list[str]:
    told = options_of(DefocusSettings)
    return [_named(name, told) for name in _differing(before.defocus, after.defocus)]


def _curves(before: Shot, after: Shot) -> list[str]:
    return [
        f"keys of the {_SHORT.get(str(parameter), parameter.words)}"
        for parameter in LensParameter
        if before.curves.of(parameter) != after.curves.of(parameter)
    ]


def _others(before: Shot, after: Shot) -> list[str]:
    """Return the fields that have no words of their own here."""
    known = {"lens", "curves", "defocus", *_FIELDS}
    return [name.replace("_", " ") for name in _differing(before, after) if name not in known]


def _differing(before: Any, after: object) -> list[str]:
    names = [field.name for field in fields(before)]
    return [name for name in names if getattr(before, name) != getattr(after, name)]


def _named(name: str, told: Any) -> str:
    if name in _SHORT:
        return _SHORT[name]
    return str(told[name].words) if name in told else name.replace("_", " ")
