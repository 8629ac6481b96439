"""Merge the changes of two windows to the same preferences."""

from collections.abc import Mapping
from dataclasses import fields, replace
from typing import TYPE_CHECKING, TypeVar

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

Kept = TypeVar("Kept", bound="DataclassInstance")

RECENT_MAX = 10


def merged(theirs: Kept, before: Kept, now: Kept) -> Kept:
    """Return `theirs` with the changes from `before` to `now`.

    In maps and recent files, only changed entries are replaced; other fields change as a whole.
    """
    changed: dict[str, object] = {}
    for name in (field.name for field in fields(now)):
        old, new, other = (getattr(of, name) for of in (before, now, theirs))
        if name == "recent":
            changed[name] = with_first(_opened_since(old, new), other)
        elif isinstance(new, Mapping):
            changed[name] = _merged_map(other, old, new)
        elif new != old:
            changed[name] = new
    return replace(theirs, **changed)


def with_first(opened: tuple[str, ...], recent: tuple[str, ...]) -> tuple[str, ...]:
    """Return the recent files after these were opened, the latest first."""
    return tuple(dict.fromkeys([*opened, *recent]))[:RECENT_MAX]


def _opened_since(before: tuple[str, ...], now: tuple[str, ...]) -> tuple[str, ...]:
    """Return the shortest beginning of `now` that turns `before` into it."""
    beginnings = (now[:count] for count in range(len(now)))
    return next((opened for opened in beginnings if with_first(opened, before) == now), now)


def _merged_map(
    theirs: Mapping[str, object], before: Mapping[str, object], now: Mapping[str, object]
) -> dict[str, object]:
    changed = {name: value for name, value in now.items() if before.get(name) != value}
    touched = {*changed, *(name for name in before if name not in now)}
    return {name: value for name, value in theirs.items() if name not in touched} | changed
