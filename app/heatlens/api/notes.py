"""Notes about a source. All are kept; each doubtful one is also raised as a warning, once."""

import sys
import warnings

from heatlens.api.python_words import in_python
from heatlens.base.errors import HeatlensWarning


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
