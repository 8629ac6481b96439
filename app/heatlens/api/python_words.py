"""Translate sentences from the words of the command line to those of Python.

All other modules suggest options, for example "say --scene-unit cm". For Python, this becomes
"say scene_unit_m=0.01".
"""

import re
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from heatlens.base.errors import HeatlensError, InputError
from heatlens.model.lens.aperture import Aperture
from heatlens.model.lens.lens import Lens
from heatlens.model.option import Option, options_of
from heatlens.model.shot.plate_options import PlateOptions
from heatlens.model.shot.settings import DefocusSettings

_KINDS: tuple[type, ...] = (PlateOptions, DefocusSettings, Aperture, Lens)
_OPTIONS: dict[str, tuple[str, Option]] = {
    told.flag: (name, told) for kind in _KINDS for name, told in options_of(kind).items()
}
_OTHERS = {"focus-at": "focus_at", "lens-model": "lens_model", "size": "size"}
_FLAG = re.compile(r"--([a-z]+(?:-[a-z]+)*)(?: ([^\s,;:]*[^\s,;:.]))?")


def in_python(sentence: str) -> str:
    """Return the sentence with arguments instead of options."""
    return _FLAG.sub(_argument, sentence)


@contextmanager
def python_words() -> Iterator[None]:
    """Raise errors from inside the block in Python's words."""
    try:
        yield
    except HeatlensError as error:
        error.args = (in_python(str(error)),)
        raise


def _argument(found: "re.Match[str]") -> str:
    """Return name=value for an option and its value, or the name if there is no value."""
    flag, word = found[1], found[2]
    after = "" if word is None else f" {word}"
    if flag in _OTHERS:
        return f"{_OTHERS[flag]}{after}"
    if flag not in _OPTIONS:
        return found[0]
    name, told = _OPTIONS[flag]
    value = None if word is None else _value(told, word)
    return f"{name}{after}" if value is None else f"{name}={value}"


def _value(told: Option, word: str) -> str | None:
    """Return the number that `word` stands for, as text, or None for an ordinary word."""
    parse: Any = float if told.parse is None else told.parse
    try:
        value = parse(word)
    except (InputError, ValueError):
        return None
    return f"{value:.6g}" if isinstance(value, float) else None
