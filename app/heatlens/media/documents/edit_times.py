"""What a cut shows when: the clips of nested tracks and stacks, each with the clock of its media.

All times are exact fractions of a second, so that items of different frame rates meet in one clock.
"""

import math
from bisect import bisect_right
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import TypeGuard

from heatlens.core.model.curves.frames import exact_rate
from heatlens.media.documents.edit_types import Composition, Item, Time

_FRACTIONS_MOST = 10_000  # of a frame; finer ones are errors of rounding
_PICTURE = "Video"  # the kind of a track that is seen
_HARDLY_S = Fraction(1, 10**9)


def seconds(time: Time) -> Fraction:
    """Return a RationalTime in seconds."""
    return Fraction(time.value).limit_denominator(_FRACTIONS_MOST) / exact_rate(time.rate)


@dataclass(frozen=True)
class Clock:
    """The time of an item at a time of the cut: begin_s + speed * cut_s, all in seconds."""

    begin_s: Fraction = Fraction(0)
    speed: Fraction = Fraction(1)

    def at(self, cut_s: Fraction) -> Fraction:
        return self.begin_s + self.speed * cut_s

    def span(self, first_s: Fraction, end_s: Fraction, within: "Span") -> "Span | None":
        """Return when the cut shows the item from `first_s` to before `end_s`; None if never."""
        if self.speed == 0:
            return within if first_s <= self.begin_s < end_s else None
        ends = [(time - self.begin_s) / self.speed for time in (first_s, end_s)]
        late = _HARDLY_S if self.speed < 0 else 0  # backwards, the end is left out all the same
        first, end = max(min(ends) + late, within[0]), min(max(ends) + late, within[1])
        return (first, end) if first < end else None

    def within(self, item: Item, placed_s: Fraction) -> "Clock":
        """Return the clock of an item that begins at `placed_s` of this one."""
        shown, speed = item.trimmed_range(), speed_of(item)
        begin_s = seconds(shown.start_time)
        if speed < 0:
            begin_s -= speed * (seconds(shown.duration) - 1 / exact_rate(shown.duration.rate))
        return Clock(begin_s + speed * (self.begin_s - placed_s), speed * self.speed)


Span = tuple[Fraction, Fraction]


@dataclass(frozen=True)
class Seen:
    """What the cut shows from `first_s` to before `end_s`: a clip, or nothing if that is None."""

    clip: Item | None
    clock: Clock
    first_s: Fraction
    end_s: Fraction

    def cut_to(self, span: Span) -> "Seen":
        """Return the part within a span."""
        return replace(self, first_s=max(self.first_s, span[0]), end_s=min(self.end_s, span[1]))


def seen_in(stack: Composition) -> list[Seen]:
    """Return what the stack of a timeline shows, in order and without a hole.

    Sound that is longer than the picture does not make the cut longer.
    """
    shown = stack.source_range
    if shown is not None:
        begin_s, long_s = seconds(shown.start_time), seconds(shown.duration)
    else:
        begin_s = Fraction(0)
        long_s = max((seconds(it.duration()) for it in stack if _is_picture(it)), default=begin_s)
    return _seen(stack, Clock(begin_s), (Fraction(0), long_s)) if long_s > 0 else []


def speed_of(item: Item) -> Fraction:
    """Return how many times as fast as usual an item is played: 0 held, below 0 backwards."""
    scalars = (effect.time_scalar for effect in item.effects if hasattr(effect, "time_scalar"))
    return Fraction(math.prod(scalars)).limit_denominator(_FRACTIONS_MOST)


def _is_picture(item: Item) -> bool:
    return getattr(item, "enabled", False) and getattr(item, "kind", _PICTURE) == _PICTURE


def _is_called(item: Item, name: str) -> TypeGuard[Composition]:
    return item.schema_name() == name


def _seen(item: Item, clock: Clock, span: Span) -> list[Seen]:
    if not _is_picture(item) or item.schema_name() == "Gap":
        return [Seen(None, clock, *span)]
    if _is_called(item, "Stack"):
        return _topmost(item, clock, span)
    if _is_called(item, "Track"):
        return _in_turn(item, clock, span)
    return [Seen(item, clock, *span)]


def _placed(item: Item, clock: Clock, placed_s: Fraction, span: Span) -> list[Seen]:
    """Return what is seen of an item that begins at `placed_s` of the clock."""
    long_s = seconds(item.duration())
    part = clock.span(placed_s, placed_s + long_s, span)
    return [] if part is None else _seen(item, clock.within(item, placed_s), part)


def _in_turn(track: Composition, clock: Clock, span: Span) -> list[Seen]:
    parts, placed_s = list[Seen](), Fraction(0)
    for item in track:
        if item.schema_name() != "Transition":
            parts += _placed(item, clock, placed_s, span)
            placed_s += seconds(item.duration())
    return list(_filled(parts, span))


def _topmost(stack: Composition, clock: Clock, span: Span) -> list[Seen]:
    """Return what is seen of a stack: where an item shows nothing, the one below it."""
    above = [Seen(None, clock, *span)]
    for item in reversed(stack):
        below = list(_filled(_placed(item, clock, Fraction(0), span), span))
        above = list(_over(above, below))
    return above


def _over(above: list[Seen], below: list[Seen]) -> Iterator[Seen]:
    begins = [part.first_s for part in below]
    for part in above:
        if part.clip is not None:
            yield part
            continue
        span = (part.first_s, part.end_s)
        for under in below[max(0, bisect_right(begins, span[0]) - 1) :]:
            if under.first_s >= span[1]:
                break
            yield under.cut_to(span)


def _filled(parts: Iterable[Seen], span: Span) -> Iterator[Seen]:
    """Yield the parts in order, and between them those where nothing is seen."""
    at_s = span[0]
    for part in sorted(parts, key=lambda part: part.first_s):
        if part.first_s > at_s:
            yield Seen(None, part.clock, at_s, part.first_s)
        yield part
        at_s = part.end_s
    if at_s < span[1]:
        yield Seen(None, Clock(), at_s, span[1])
