"""Values of a dataclass that differ in one field, found from the types of its fields.

A field that is added later is covered without a word here, unless its type is a new one.
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
        now = getattr(value, field.name)
        given = (names or {}).get(field.name)
        wanted = candidates(hints[field.name], now) if given is None else (given,)
        yield field.name, _first_allowed(value, field.name, now, wanted)


def with_all_fields_other(
    value: Value, names: Mapping[str, Any] | None = None, but: Collection[str] = ()
) -> Value:
    """Return `value` with another value in every field `but` some, as far as they go together."""
    for name, other in with_other_fields(value, names):
        if name in but:
            continue
        try:
            value = replace(value, **{name: getattr(other, name)})
        except HeatlensError:  # it does not go together with the other values
            continue
    return value


def _first_allowed(value: Value, name: str, now: Any, wanted: Any) -> Value:
    for candidate in wanted:
        if candidate == now:
            continue
        try:
            return replace(value, **{name: candidate})
        except HeatlensError:
            continue
    raise AssertionError(f"No other value is known for {type(value).__name__}.{name}.")


def candidates(hint: Any, now: Any) -> Iterator[Any]:
    """Yield values of the type `hint` that may differ from `now`, the mildest change first."""
    if get_origin(hint) in (Union, types.UnionType):
        for kind in get_args(hint):
            if kind is not types.NoneType:
                yield from candidates(kind, now)
        if types.NoneType in get_args(hint):
            yield None
    elif get_origin(hint) is Literal:
        yield from get_args(hint)
    elif get_origin(hint) is tuple:
        yield from _other_tuples(get_args(hint), now)
    elif hint is OpeningImage:
        yield read_opening_image(heart_path())
    elif is_dataclass(hint):
        yield from _other_records(hint, now)
    elif issubclass(hint, Enum):
        yield from hint
    else:
        yield from _plain(hint, now)


def _plain(hint: type, now: Any) -> Iterator[Any]:
    if hint is bool:
        yield not now
    elif hint is int:
        yield from (now + 1, now - 1, 7) if isinstance(now, int) else (2, 7)
    elif hint is float:
        known = isinstance(now, float) and math.isfinite(now) and now != 0
        yield from (1.25 * now, 0.75 * now) if known else (1.5, 0.5, 60.0)
    elif hint is str:
        yield f"{now or ''}another"


def _other_tuples(kinds: tuple[Any, ...], now: Any) -> Iterator[Any]:
    if kinds[-1] is not Ellipsis:
        parts = now if isinstance(now, tuple) else (None,) * len(kinds)
        yield tuple(next(candidates(k, part)) for k, part in zip(kinds, parts, strict=True))
        return
    yield (next(candidates(kinds[0], None)),)


def _other_records(kind: type, now: Any) -> Iterator[Any]:
    if isinstance(now, kind):
        for _, other in with_other_fields(now):
            yield other
        return
    hints, needed = get_type_hints(kind), {}
    for field in fields(kind):
        needed[field.name] = next(candidates(hints[field.name], None))
    yield kind(**needed)
