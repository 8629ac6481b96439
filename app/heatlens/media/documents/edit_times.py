"""Find which clip a cut shows at each time, in nested tracks and stacks, and its media's clock.

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

_FRACTIONS_MOST = 10_000  # largest denominator of a frame; finer fractions are rounding errors
_PICTURE = "Video"  # the kind of a track that is seen
_INSTANT_S = Fraction(1, 10**9)


def seconds(time: Time) -> Fraction:
    """Return a RationalTime in seconds."""
    return Fraction(time.value).limit_denominator(_FRACTIONS_MOST) / exact_rate(time.rate)


@dataclass(frozen=True)
class Clock:
    """The time of an item at the time `cut_s` of the cut: begin_s + speed * cut_s, in seconds."""

    begin_s: Fraction = Fraction(0)
    speed: Fraction = Fraction(1)

    def at(self, cut_s: Fraction) -> Fraction:
        """Return the time of the item at a time of the cut, in seconds."""
        return self.begin_s + self.speed * cut_s

    def span(self, first_s: Fraction, end_s: Fraction, within: "Span") -> "Span | None":
        """Return when the cut shows the times of the item from `first_s` to before `end_s`.

        The result is in seconds of the cut and lies inside `within`. Returns None if it is empty.
        """
        if self.speed == 0:
            return within if first_s <= self.begin_s < end_s else None
        ends = [(time - self.begin_s) / self.speed for time in (first_s, end_s)]
        # A span excludes its end. Played backwards, that is its first instant: shift it by one.
        shift_s = _INSTANT_S if self.speed < 0 else 0
        first, end = max(min(ends) + shift_s, within[0]), min(max(ends) + shift_s, within[1])
        return (first, end) if first < end else None

    def clock_of_item(self, item: Item, item_start_s: Fraction) -> "Clock":
        """Return the clock of an item that begins at `item_start_s` of this clock."""
        trimmed_range, speed = item.trimmed_range(), speed_of(item)
        begin_s = seconds(trimmed_range.start_time)
        if speed < 0:
            begin_s -= speed * (
                seconds(trimmed_range.duration) - 1 / exact_rate(trimmed_range.duration.rate)
            )
        return Clock(begin_s + speed * (self.begin_s - item_start_s), speed * self.speed)


Span = tuple[Fraction, Fraction]


@dataclass(frozen=True)
class ShownSpan:
    """What the cut shows from `first_s` to before `end_s`: a clip, or nothing if that is None."""

    clip: Item | None
    clock: Clock
    first_s: Fraction
    end_s: Fraction

    def clip_to(self, span: Span) -> "ShownSpan":
        """Return the part within a span."""
        return replace(self, first_s=max(self.first_s, span[0]), end_s=min(self.end_s, span[1]))


def shown_spans(stack: Composition) -> list[ShownSpan]:
    """Return what the stack of a timeline shows, in order and without a hole.

    Sound that is longer than the picture does not make the cut longer.
    """
    source_range = stack.source_range
    if source_range is not None:
        begin_s, length_s = seconds(source_range.start_time), seconds(source_range.duration)
    else:
        begin_s = Fraction(0)
        length_s = max(
            (seconds(item.duration()) for item in stack if _is_picture(item)), default=begin_s
        )
    return _spans_of_item(stack, Clock(begin_s), (Fraction(0), length_s)) if length_s > 0 else []


def speed_of(item: Item) -> Fraction:
    """Return the speed of an item relative to its media: 0 for a freeze, negative for backwards."""
    scalars = (effect.time_scalar for effect in item.effects if hasattr(effect, "time_scalar"))
    return Fraction(math.prod(scalars)).limit_denominator(_FRACTIONS_MOST)


def _is_picture(item: Item) -> bool:
    """Return True for an item that is enabled and not a track of sound."""
    return getattr(item, "enabled", False) and getattr(item, "kind", _PICTURE) == _PICTURE


def _has_schema(item: Item, name: str) -> TypeGuard[Composition]:
    return item.schema_name() == name


def _spans_of_item(item: Item, clock: Clock, span: Span) -> list[ShownSpan]:
    """Return what an item shows in a span of the cut, in order; a gap has no clip."""
    if not _is_picture(item) or item.schema_name() == "Gap":
        return [ShownSpan(None, clock, *span)]
    if _has_schema(item, "Stack"):
        return _spans_of_stack(item, clock, span)
    if _has_schema(item, "Track"):
        return _spans_of_track(item, clock, span)
    return [ShownSpan(item, clock, *span)]


def _spans_of_item_at(
    item: Item, clock: Clock, item_start_s: Fraction, span: Span
) -> list[ShownSpan]:
    """Return what an item shows within `span`, if it begins at `item_start_s` of `clock`."""
    length_s = seconds(item.duration())
    visible_span = clock.span(item_start_s, item_start_s + length_s, span)
    return (
        []
        if visible_span is None
        else _spans_of_item(item, clock.clock_of_item(item, item_start_s), visible_span)
    )


def _spans_of_track(track: Composition, clock: Clock, span: Span) -> list[ShownSpan]:
    """Return what a track shows in a span of the cut; its items follow each other."""
    spans, item_start_s = list[ShownSpan](), Fraction(0)
    for item in track:
        if item.schema_name() != "Transition":
            spans += _spans_of_item_at(item, clock, item_start_s, span)
            item_start_s += seconds(item.duration())
    return list(_fill_gaps(spans, span))


def _spans_of_stack(stack: Composition, clock: Clock, span: Span) -> list[ShownSpan]:
    """Return what a stack shows: where an item shows nothing, the one below it is visible."""
    above = [ShownSpan(None, clock, *span)]
    for item in reversed(stack):
        below = list(_fill_gaps(_spans_of_item_at(item, clock, Fraction(0), span), span))
        above = list(_fill_holes_from_below(above, below))
    return above


def _fill_holes_from_below(above: list[ShownSpan], below: list[ShownSpan]) -> Iterator[ShownSpan]:
    """Yield the spans of `above`, and those of `below` where `above` shows nothing."""
    start_times = [span_above.first_s for span_above in below]
    for span_above in above:
        if span_above.clip is not None:
            yield span_above
            continue
        span = (span_above.first_s, span_above.end_s)
        for span_below in below[max(0, bisect_right(start_times, span[0]) - 1) :]:
            if span_below.first_s >= span[1]:
                break
            yield span_below.clip_to(span)


def _fill_gaps(spans: Iterable[ShownSpan], span: Span) -> Iterator[ShownSpan]:
    """Yield the spans in order, with spans without a clip between them, to fill all of `span`."""
    filled_until_s = span[0]
    for shown in sorted(spans, key=lambda entry: entry.first_s):
        if shown.first_s > filled_until_s:
            yield ShownSpan(
                clip=None, clock=shown.clock, first_s=filled_until_s, end_s=shown.first_s
            )
        yield shown
        filled_until_s = shown.end_s
    if filled_until_s < span[1]:
        yield ShownSpan(clip=None, clock=Clock(), first_s=filled_until_s, end_s=span[1])
