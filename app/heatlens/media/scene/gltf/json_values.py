"""Read the objects of a glTF file's JSON, and refuse entries of the wrong type or range."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NoReturn

from heatlens.media.files.json_record import JsonEntry

_NUMBER_MOST = 1e300  # sums of such numbers do not become infinite


@dataclass(frozen=True, slots=True)
class Record:
    """A JSON object with methods that read its entries.

    Every method raises InputError with the file and the place if an entry has the wrong type.
    """

    entry: JsonEntry

    def __post_init__(self) -> None:
        if not isinstance(self.entry.value, dict):
            self.entry.refuse("there should be an object in braces here")

    def has(self, name: str) -> bool:
        """Return whether there is such an entry."""
        return name in self.entry.value

    def refuse(self, sentence: str) -> NoReturn:
        """Raise InputError with the file, the place and `sentence`, which says what is wrong."""
        self.entry.refuse(sentence)

    def entry_at(self, name: str) -> JsonEntry:
        """Return the entry, which must exist."""
        if not self.has(name):
            self.refuse(f"the entry {name!r} is missing")
        place = f"{self.entry.place}.{name}" if self.entry.place else name
        return JsonEntry(self.entry.path, place, self.entry.value[name])

    def object_at(self, *names: str) -> "Record":
        """Return the object at a path of names, or an empty one if there is none."""
        record = self
        for name in names:
            missing = JsonEntry(self.entry.path, place=f"{record.entry.place}.{name}", value={})
            record = Record(record.entry_at(name) if record.has(name) else missing)
        return record

    def records(self, name: str) -> list["Record"]:
        """Return the objects of a list; none if it is missing."""
        return [Record(item) for item in self.entry_at(name).items()] if self.has(name) else []

    def number(self, name: str, default: float, least: float = -math.inf) -> float:
        """Return a finite number that is at least `least`, or the default if there is no entry."""
        return _read_finite(self.entry_at(name), least) if self.has(name) else default

    def whole_number(self, name: str, default: int | None = None) -> int:
        """Return an integer that is not negative; without a default, it must exist."""
        if default is not None and not self.has(name):
            return default
        number = _read_finite(self.entry_at(name), 0)
        if not number.is_integer() or number >= 2**53:
            self.refuse(f"{name!r} should be a whole number within reason")
        return int(number)

    def index(self, name: str, count: int) -> int | None:
        """Return an index into a list of length `count`; None if there is no such entry."""
        if not self.has(name):
            return None
        number = self.whole_number(name)
        if number >= count:
            self.refuse(f"{name!r} is {number}, but the file has only {count} of them")
        return number

    def required_index(self, name: str, count: int) -> int:
        """Return an index as `index` does, which must be there."""
        self.entry_at(name)
        return self.index(name, count) or 0

    def indices(self, name: str, count: int) -> list[int]:
        """Return a list of indices as `index` does; empty if there is no such entry."""
        if not self.has(name):
            return []
        items = {str(i): item.value for i, item in enumerate(self.entry_at(name).items())}
        index_record = Record(JsonEntry(self.entry.path, self.entry_at(name).place, items))
        return [index for key in items if (index := index_record.index(key, count)) is not None]

    def row(self, name: str, default: Sequence[float]) -> tuple[float, ...]:
        """Return as many finite numbers as the default has, or the default if there is no entry."""
        if not self.has(name):
            return tuple(default)
        items = self.entry_at(name).items()
        if len(items) != len(default):
            self.refuse(f"{name!r} should have {len(default)} numbers, not {len(items)}")
        return tuple(_read_finite(item, -math.inf) for item in items)

    def numbers(self, name: str) -> list[float]:
        """Return a list of finite numbers; empty if there is no such entry."""
        return (
            [_read_finite(item, -math.inf) for item in self.entry_at(name).items()]
            if self.has(name)
            else []
        )

    def text(self, name: str, default: str = "") -> str:
        """Return a text, or the default if there is no such entry."""
        return self.entry_at(name).text() if self.has(name) else default


def _read_finite(entry: JsonEntry, least: float) -> float:
    """Return the number of an entry; raise InputError unless it is finite and not below `least`."""
    value = entry.value
    if isinstance(value, bool) or not isinstance(value, int | float):
        entry.refuse("there should be a number here")
    if not max(least, -_NUMBER_MOST) <= value <= _NUMBER_MOST:
        entry.refuse("this number is out of range")
    return float(value)
