"""Notes about a source, in the words of Python; doubtful ones are also raised as warnings.

Each warning is raised once. All other modules suggest options, for example "say --scene-unit cm".
For Python, this becomes "say scene_unit_m=0.01".
"""

import re
import sys
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from heatlens.core.base.errors import HeatlensError, HeatlensWarning, InputError
from heatlens.core.model.lens.aperture import Aperture
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.option import Option, options_of
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.core.model.shot.settings import DefocusSettings

_KINDS: tuple[type, ...] = (PlateOptions, DefocusSettings, Aperture, Lens)
_OTHERS = {"focus-at": "focus_at", "lens-model": "lens_model", "size": "size"}
_FLAG = re.compile(r"--([a-z]+(?:-[a-z]+)*)(?: ([^\s,;:]*[^\s,;:.]))?")


class Notes:
    """The sentences on one source, in the order in which they were first said."""

    def __init__(self) -> None:
        self._kept: dict[str, None] = {}
        self._warned: set[str] = set()

    @property
    def sentences(self) -> tuple[str, ...]:
        """All of them."""
        return tuple(self._kept)

    def keep(self, *sentences: str) -> None:
        """Keep sentences that only inform."""
        self._kept.update(dict.fromkeys(map(in_python, sentences)))

    def warn(self, *sentences: str) -> None:
        """Keep sentences, and warn of those that are new."""
        for sentence in map(in_python, sentences):
            self._kept[sentence] = None
            if sentence not in self._warned:
                warnings.warn(sentence, HeatlensWarning, stacklevel=_level_outside())
                # Only now, because a filter may turn the warning into an exception.
                self._warned.add(sentence)


def _level_outside() -> int:
    """Return the `stacklevel` that makes a warning name the code that called heatlens."""
    frame, level = sys._getframe(1), 1
    while frame.f_back is not None and _is_own(frame.f_globals.get("__name__", "")):
        frame, level = frame.f_back, level + 1
    return level


def _is_own(module: str) -> bool:
    return module.partition(".")[0] == "heatlens"


_OPTIONS: dict[str, tuple[str, Option]] = {
    told.flag: (name, told) for kind in _KINDS for name, told in options_of(kind).items()
}


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


def _argument(match: "re.Match[str]") -> str:
    """Return name=value for an option and its value, or the name if there is no value."""
    flag, word = match[1], match[2]
    after = "" if word is None else f" {word}"
    if flag in _OTHERS:
        return f"{_OTHERS[flag]}{after}"
    if flag not in _OPTIONS:
        return match[0]
    name, option = _OPTIONS[flag]
    value = None if word is None else _value(option, word)
    return f"{name}{after}" if value is None else f"{name}={value}"


def _value(option: Option, word: str) -> str | None:
    """Return the number that `word` stands for, as text, or None for an ordinary word."""
    parse: Any = float if option.parse is None else option.parse
    try:
        value = parse(word)
    except (InputError, ValueError):
        return None
    return f"{value:.6g}" if isinstance(value, float) else None
