"""Notes about a source, with Python arguments instead of options; doubts also become warnings.

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

_OPTION_CLASSES: tuple[type, ...] = (PlateOptions, DefocusSettings, Aperture, Lens)
_OTHER_ARGUMENTS = {"focus-at": "focus_at", "lens-model": "lens_model", "size": "size"}
_FLAG = re.compile(r"--([a-z]+(?:-[a-z]+)*)(?: ([^\s,;:]*[^\s,;:.]))?")


class Notes:
    """The notes on one source, in the order in which they were first reported."""

    def __init__(self) -> None:
        self._sentences: dict[str, None] = {}
        self._warned_sentences: set[str] = set()

    @property
    def sentences(self) -> tuple[str, ...]:
        """All notes so far."""
        return tuple(self._sentences)

    def keep(self, *sentences: str) -> None:
        """Keep notes that only inform."""
        self._sentences.update(dict.fromkeys(map(use_python_names, sentences)))

    def warn(self, *sentences: str) -> None:
        """Keep notes on doubts, and raise a warning for each new one."""
        for sentence in map(use_python_names, sentences):
            self._sentences[sentence] = None
            if sentence not in self._warned_sentences:
                warnings.warn(sentence, HeatlensWarning, stacklevel=_caller_stacklevel())
                # Only now, because a filter may turn the warning into an exception.
                self._warned_sentences.add(sentence)


def _caller_stacklevel() -> int:
    """Return the `stacklevel` that makes a warning name the code that called heatlens."""
    frame, level = sys._getframe(1), 1
    while frame.f_back is not None and _is_own_module(frame.f_globals.get("__name__", "")):
        frame, level = frame.f_back, level + 1
    return level


def _is_own_module(module: str) -> bool:
    return module.partition(".")[0] == "heatlens"


_OPTIONS: dict[str, tuple[str, Option]] = {
    option.flag: (name, option)
    for kind in _OPTION_CLASSES
    for name, option in options_of(kind).items()
}


def use_python_names(sentence: str) -> str:
    """Return the sentence with Python arguments in the place of command-line options."""
    return _FLAG.sub(_argument_text, sentence)


@contextmanager
def errors_with_python_names() -> Iterator[None]:
    """Make errors from inside the block name Python arguments instead of options."""
    try:
        yield
    except HeatlensError as error:
        error.args = (use_python_names(str(error)),)
        raise


def _argument_text(match: "re.Match[str]") -> str:
    """Return name=value for an option and its value, or the name if there is no value."""
    flag, value_text = match[1], match[2]
    rest_of_match = "" if value_text is None else f" {value_text}"
    if flag in _OTHER_ARGUMENTS:
        return f"{_OTHER_ARGUMENTS[flag]}{rest_of_match}"
    if flag not in _OPTIONS:
        return match[0]
    name, option = _OPTIONS[flag]
    value = None if value_text is None else _number_text(option, value_text)
    return f"{name}{rest_of_match}" if value is None else f"{name}={value}"


def _number_text(option: Option, word: str) -> str | None:
    """Return the number that `word` stands for, as text, or None for an ordinary word."""
    parse: Any = float if option.parse is None else option.parse
    try:
        value = parse(word)
    except (InputError, ValueError):
        return None
    return f"{value:.6g}" if isinstance(value, float) else None
