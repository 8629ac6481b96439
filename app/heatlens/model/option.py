"""What a person has to be told of a field in order to set it, kept on the field itself.

The command line makes its options from this, and panels take ranges and words from it, so that a
field has one home: `width_mm: float = field(default=36.0, metadata=option("width", least=1))`.
"""

from collections.abc import Callable, Mapping
from dataclasses import MISSING, dataclass, fields
from functools import cache
from typing import Any

from heatlens.errors import InputError

_KEY = "option"


@dataclass(frozen=True)
class Option:
    """How a field is set by a person.

    words     its name in a sentence, as "focal length"
    help      what it does, for `--help`
    flag      its name on the command line, without dashes
    metavar   what stands for the value in `--help`, "" where it is one of several words
    unit      of the number: "mm", "m", "f-stop" or ""
    least     least value allowed, None for no bound
    most      greatest value allowed, None for no bound
    parse     from what was typed to the value; raises InputError. None: as its type and unit say
    asked_by  given a `Method`, whether it asks for this field at all; None: every method does
    why_not   the rest of a sentence, on a method that does not ask
    """

    words: str
    help: str = ""
    flag: str = ""
    metavar: str = ""
    unit: str = ""
    least: float | None = None
    most: float | None = None
    parse: Callable[[str], Any] | None = None
    asked_by: Callable[[Any], bool] | None = None
    why_not: str = ""

    def allows(self, value: float) -> bool:
        """Return whether a number lies in the range; NaN never does."""
        low = -float("inf") if self.least is None else self.least
        high = float("inf") if self.most is None else self.most
        return low <= value <= high


def option(words: str, help: str = "", **more: Any) -> Mapping[str, Option]:
    """Return the metadata of a field that a person can set; see `Option`."""
    flag = more.pop("flag", words.lower().replace(" ", "-"))
    return {_KEY: Option(words, help, flag, **more)}


def check_range(what: str, value: float | None, least: float, most: float) -> None:
    """Raise InputError where a number lies outside its range or is NaN; None is no number."""
    if value is not None and not least <= value <= most:
        raise InputError(f"The {what} should be {least:g} to {most:g}, got {value:g}.")


@cache
def options_of(kind: type) -> Mapping[str, Option]:
    """Return the options of a dataclass by the names of their fields, in their order."""
    return {f.name: f.metadata[_KEY] for f in fields(kind) if _KEY in f.metadata}


def words_of(record: Any) -> list[str]:
    """Return the words of a command line that say what of a dataclass is not at its default.

    They are what `heatlens.commands.field_options` reads. Only fields with an option and a default
    count, and none whose values are typed in another way than they are kept.
    """
    words = []
    kind: Any = type(record)
    told = options_of(kind)
    for field in fields(record):
        value = getattr(record, field.name)
        if field.name in told and field.default is not MISSING and value != field.default:
            flag = f"--{told[field.name].flag}"
            words.append(flag if value is True else f"{flag}={value}")
    return words
