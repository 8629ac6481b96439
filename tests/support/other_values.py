"""Make values of a dataclass that differ in one field, from the types of its fields.

Fields that are added later are covered automatically, unless their type is a new one.
"""

import math
import types
from collections.abc import Collection, Iterator, Mapping
from dataclasses import fields, is_dataclass, replace
from enum import Enum
from typing import Any, Literal, TypeVar, Union, get_args, get_origin, get_type_hints

from heatlens.core.base.errors import HeatlensError
from heatlens.core.model.lens.opening_image import OpeningImage
from heatlens.media.plate.opening_picture import read_opening_image
from support.opening_images import heart_path

Value = TypeVar("Value")


def with_other_fields(
    value: Value, names: Mapping[str, Any] | None = None
) -> Iterator[tuple[str, Value]]:
    """Yield, for each field of `value`, its name and `value` with another value in that field.

    `names` gives the values of fields that only take a name known elsewhere.
    """
    hints = get_type_hints(type(value))
    for field in fields(value):
        current = getattr(value, field.name)
        known_value = (names or {}).get(field.name)
        other_candidates = (
            candidates(hints[field.name], current) if known_value is None else (known_value,)
        )
        yield field.name, _first_allowed(value, field.name, current, other_candidates)


def with_all_fields_other(
    value: Value, names: Mapping[str, Any] | None = None, except_fields: Collection[str] = ()
) -> Value:
    """Return `value` with other values in all fields except some, where the values are allowed."""
    for name, changed_record in with_other_fields(value, names):
        if name in except_fields:
            continue
        try:
            value = replace(value, **{name: getattr(changed_record, name)})
        except HeatlensError:  # it does not go together with the other values
            continue
    return value


def _first_allowed(value: Value, name: str, current: Any, other_candidates: Any) -> Value:
    for candidate in other_candidates:
        if candidate == current:
            continue
        try:
            return replace(value, **{name: candidate})
        except HeatlensError:
            continue
    raise AssertionError(f"No other value is known for {type(value).__name__}.{name}.")


def candidates(hint: Any, current: Any) -> Iterator[Any]:
    """Yield values of the type `hint` that may differ from `current`, the mildest change first."""
    if get_origin(hint) in (Union, types.UnionType):
        for kind in get_args(hint):
            if kind is not types.NoneType:
                yield from candidates(kind, current)
        if types.NoneType in get_args(hint):
            yield None
    elif get_origin(hint) is Literal:
        yield from get_args(hint)
    elif get_origin(hint) is tuple:
        yield from _other_tuples(get_args(hint), current)
    elif hint is OpeningImage:
        yield read_opening_image(heart_path())
    elif is_dataclass(hint):
        yield from _other_records(hint, current)
    elif issubclass(hint, Enum):
        yield from hint
    else:
        yield from _plain(hint, current)


def _plain(hint: type, current: Any) -> Iterator[Any]:
    if hint is bool:
        yield not current
    elif hint is int:
        yield from (current + 1, current - 1, 7) if isinstance(current, int) else (2, 7)
    elif hint is float:
        known = isinstance(current, float) and math.isfinite(current) and current != 0
        yield from (1.25 * current, 0.75 * current) if known else (1.5, 0.5, 60.0)
    elif hint is str:
        yield f"{current or ''}another"


def _other_tuples(kinds: tuple[Any, ...], current: Any) -> Iterator[Any]:
    if kinds[-1] is not Ellipsis:
        parts = current if isinstance(current, tuple) else (None,) * len(kinds)
        yield tuple(next(candidates(k, part)) for k, part in zip(kinds, parts, strict=True))
        return
    yield (next(candidates(kinds[0], None)),)


def _other_records(kind: type, current: Any) -> Iterator[Any]:
    if isinstance(current, kind):
        for _, changed_record in with_other_fields(current):
            yield changed_record
        return
    hints, needed = get_type_hints(kind), {}
    for field in fields(kind):
        needed[field.name] = next(candidates(hints[field.name], None))
    yield kind(**needed)
