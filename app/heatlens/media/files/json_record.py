"""Convert values of the model to JSON and back; errors name the place in the file.

A dataclass becomes an object with its fields as entries; fields that are None are left out.
Infinity, for which JSON has no number, is written as the text "inf".
"""

import hashlib
import json
import math
from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import MISSING, dataclass, fields, is_dataclass
from difflib import get_close_matches
from enum import Enum
from pathlib import Path
from types import NoneType
from typing import Any, Literal, NoReturn, TypeVar, get_args, get_origin, get_type_hints

from heatlens.core.base.errors import HeatlensError, InputError
from heatlens.core.base.paths import read_file_bytes, unreadable_error
from heatlens.core.model.lens.opening_image import OpeningImage

T = TypeVar("T")

_DIGEST_BYTES = 16
_VERSION_PREFIX = "heatlens_"  # of the entry with the version, as in "heatlens_reel"
_WHOLE_MOST = 2**53  # whole floats below this are exact, and are written without ".0"


def record_to_json(record: Any) -> dict[str, object]:
    """Return a dataclass as a JSON object.

    Its fields must be numbers, texts, enums, such dataclasses, or tuples or maps of these. Those
    without a default come first.
    """
    ordered_fields = sorted(fields(record), key=lambda field: not _is_required(field))
    values = {field.name: getattr(record, field.name) for field in ordered_fields}
    return {name: to_json(value) for name, value in values.items() if value is not None}


def _is_required(field: Any) -> bool:
    """Return True for a field of a dataclass without a default."""
    return field.default is MISSING and field.default_factory is MISSING


def to_json(value: object) -> object:
    """Return the JSON value of a number, text, enum, image (its path), tuple, map or dataclass."""
    if isinstance(value, OpeningImage):
        return value.path
    if is_dataclass(value):
        return record_to_json(value)
    if isinstance(value, Enum):
        return value.value
    if isinstance(value, tuple):
        return [to_json(item) for item in value]
    if isinstance(value, Mapping):
        return {name: to_json(member) for name, member in value.items()}
    if isinstance(value, float):
        if math.isinf(value):
            return "inf"
        return int(value) if value.is_integer() and abs(value) < _WHOLE_MOST else value
    return value


def digest(facts: Mapping[str, object]) -> str:
    """Return 32 hexadecimal digits that identify the facts, which must fit into JSON."""
    text = json.dumps(facts, sort_keys=True)
    return hashlib.blake2b(text.encode(), digest_size=_DIGEST_BYTES).hexdigest()


@dataclass(frozen=True, slots=True)
class JsonEntry:
    """A value in a JSON file and its place there, such as `keys.focus_distance_m[2]`.

    Every method raises InputError with the file and the place if the value is not as expected.
    """

    path: Path
    place: str
    value: Any

    def refuse(self, sentence: str) -> NoReturn:
        """Raise InputError with the file, the place in it and `sentence`."""
        place_text = f" {self.place}:" if self.place else ""
        raise InputError(f"{self.path}:{place_text} {sentence}")

    def check_version(self, entry: str, version: int, kind: str) -> None:
        """Refuse a file that is not a `kind` of heatlens, or has another version than `version`.

        `entry` is the name of the entry that holds the version.
        """
        if not isinstance(self.value, dict) or entry not in self.value:
            self.refuse(_other_kind_sentence(self.value, entry, kind))
        stored = JsonEntry(self.path, place=entry, value=self.value[entry])
        if stored.integer() != version:
            stored.refuse(
                f"version {stored.integer()} is not known here, only {version}; a newer heatlens "
                "may have written it"
            )

    def members(
        self, known_names: Collection[str], required_names: Iterable[str] = ()
    ) -> dict[str, "JsonEntry"]:
        """Return the entries of this object by name.

        All must be among `known_names`, and none of `required_names` may be missing.
        """
        if not isinstance(self.value, dict):
            self.refuse(f"{_short_json(self.value)} should be an object in braces")
        for name in self.value:
            if name not in known_names:
                similar_names = get_close_matches(name, known_names, 1)
                hint = (
                    f"did you mean {similar_names[0]!r}?"
                    if similar_names
                    else f"known are {', '.join(known_names)}"
                )
                self.refuse(f"unknown entry {name!r}; {hint}")
        for name in required_names:
            if name not in self.value:
                self.refuse(f"the entry {name!r} is missing")
        prefix = f"{self.place}." if self.place else ""
        return {
            name: JsonEntry(self.path, prefix + name, value) for name, value in self.value.items()
        }

    def items(self) -> list["JsonEntry"]:
        """Return the items of this list."""
        if not isinstance(self.value, list):
            self.refuse(f"{_short_json(self.value)} should be a list in brackets")
        return [
            JsonEntry(self.path, f"{self.place}[{index}]", value)
            for index, value in enumerate(self.value)
        ]

    def record(self, kind: type[T]) -> T:
        """Return this object as a dataclass `kind`; missing entries take their defaults."""
        hints = get_type_hints(kind)
        record_fields: tuple[Any, ...] = fields(kind)  # type: ignore[arg-type]
        required_names = [field.name for field in record_fields if _is_required(field)]
        entries = self.members([field.name for field in record_fields], required_names)
        return self.build(kind, {n: entry.convert(hints[n]) for n, entry in entries.items()})

    def build(self, kind: Callable[..., T], values: Mapping[str, object]) -> T:
        """Build `kind` from `values`; its HeatlensError becomes an InputError with the place."""
        try:
            return kind(**values)
        except HeatlensError as error:
            self.refuse(str(error))

    def convert(self, field_type: Any) -> Any:
        """Return the value as a `field_type`, which is the type hint of a dataclass field."""
        if NoneType in get_args(field_type):
            (field_type,) = (kind for kind in get_args(field_type) if kind is not NoneType)
            return None if self.value is None else self.convert(field_type)
        if get_origin(field_type) is tuple:
            return self.tuple_of(get_args(field_type))
        if get_origin(field_type) is Mapping:
            return self.mapping_of(get_args(field_type)[1])
        if get_origin(field_type) is Literal:
            return self.choice(get_args(field_type))
        if field_type is OpeningImage:
            return OpeningImage(self.text())  # read later, once the folder is known
        if is_dataclass(field_type):
            return self.record(field_type)  # type: ignore[arg-type]
        if issubclass(field_type, Enum):
            return field_type(self.choice([member.value for member in field_type]))
        readers = {float: self.number, int: self.integer, str: self.text, bool: self.flag}
        return readers[field_type]()

    def mapping_of(self, hint: Any) -> dict[str, Any]:
        """Return this object as a mapping with values of the type `hint`; names are arbitrary."""
        names = self.value if isinstance(self.value, dict) else ()
        return {name: entry.convert(hint) for name, entry in self.members(names).items()}

    def tuple_of(self, hints: tuple[Any, ...]) -> tuple[object, ...]:
        """Return this list as a tuple of these types; `...` at the end allows any length."""
        items = self.items()
        if hints[-1] is Ellipsis:
            hints = (hints[0],) * len(items)
        if len(items) != len(hints):
            self.refuse(f"there should be {len(hints)} values, not {len(items)}")
        return tuple(item.convert(hint) for item, hint in zip(items, hints, strict=True))

    def number(self) -> float:
        """Return the value as a finite number, or infinity for "inf"."""
        if self.value == "inf":
            return math.inf
        if isinstance(self.value, bool) or not isinstance(self.value, int | float):
            self.refuse(f"{_short_json(self.value)} should be a number")
        if not abs(self.value) < 1e300:
            self.refuse(f'{_short_json(self.value)} is too large; infinity is written "inf"')
        return float(self.value)

    def integer(self) -> int:
        """Return the value as an integer."""
        number = self.number()
        if not number.is_integer():
            self.refuse(f"{_short_json(self.value)} should be a whole number")
        return int(number)

    def flag(self) -> bool:
        """Return the value as True or False."""
        if not isinstance(self.value, bool):
            self.refuse(f"{_short_json(self.value)} should be true or false")
        return self.value

    def text(self) -> str:
        """Return the value as a text."""
        if not isinstance(self.value, str):
            self.refuse(f"{_short_json(self.value)} should be a text in quotation marks")
        return self.value

    def choice(self, choices: Collection[str]) -> str:
        """Return the value, which must be one of `choices`."""
        if not isinstance(self.value, str) or self.value not in choices:
            self.refuse(f"{_short_json(self.value)} should be one of {', '.join(choices)}")
        return self.value


def _other_kind_sentence(value: object, entry: str, kind: str) -> str:
    """Return why a file without the `entry` of its version is not a `kind` of heatlens."""
    names = value if isinstance(value, dict) else ()
    known = (name for name in names if name.startswith(_VERSION_PREFIX))
    other = next(known, "").removeprefix(_VERSION_PREFIX).replace("_", " ")
    if other:
        article = "an" if other[0] in "aeiou" else "a"
        return f"this is {article} {other} of heatlens: give the file of a {kind}"
    return f"this is no {kind} of heatlens: it has no entry {entry!r}"


def read_json(path: Path) -> JsonEntry:
    """Read a whole JSON file. Raises InputError if it cannot be read or is damaged."""
    try:
        text = read_file_bytes(path).decode("utf-8-sig")  # some editors write a byte order mark
        value = json.loads(text, object_pairs_hook=_unique_entries, parse_constant=_refuse_constant)
    except OSError as error:
        raise unreadable_error(path, error) from error
    except UnicodeDecodeError as error:
        raise InputError(
            f"{path} is not a text file, as shots and cameras in JSON are: it is another kind of "
            "file, or damaged."
        ) from error
    except json.JSONDecodeError as error:
        raise InputError(
            f"{path}: line {error.lineno}, column {error.colno}: {error.msg}; the file is damaged "
            "or cut short."
        ) from error
    except (ValueError, RecursionError) as error:
        raise InputError(f"{path} is damaged: {error}.") from error
    return JsonEntry(path, "", value)


def _unique_entries(pairs: list[tuple[str, object]]) -> dict[str, object]:
    """Return an object; refuse an entry that occurs twice, because one of them would be lost."""
    entries = dict(pairs)
    if len(entries) != len(pairs):
        names = [name for name, _ in pairs]
        twice = next(name for name in entries if names.count(name) > 1)
        raise ValueError(f"the entry {twice!r} occurs twice in the same place")
    return entries


def _refuse_constant(name: str) -> NoReturn:
    """Refuse NaN and Infinity, which some programs write and JSON does not have."""
    raise ValueError(f'{name} is not a JSON number; infinity is written "inf"')


def _short_json(value: object) -> str:
    """Return a value as JSON text, shortened to 40 characters."""
    text = json.dumps(value)
    return text if len(text) <= 40 else f"{text[:37]}..."
