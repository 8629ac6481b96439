"""Types for the parts of OpenTimelineIO that are used, because the library has none."""

from collections.abc import Iterable, Mapping, Reversible, Sized
from typing import Protocol


class Time(Protocol):
    """An opentime.RationalTime: `value` frames at `rate` frames per second."""

    value: float
    rate: float


class TimeRange(Protocol):
    """An opentime.TimeRange."""

    start_time: Time
    duration: Time


class Marker(Protocol):
    """A schema.Marker."""

    name: str
    comment: str


class Item(Protocol):
    """A core.Item: a clip, a gap, a track or a stack."""

    name: str
    effects: Iterable[object]
    markers: Iterable[Marker]
    metadata: Mapping[str, object]
    source_range: TimeRange | None

    def schema_name(self) -> str:
        """Return the kind of item: "Clip", "Gap", "Track", "Stack"; "Transition" in a track."""

    def duration(self) -> Time:
        """Return how long the item is shown."""

    def trimmed_range(self) -> TimeRange:
        """Return which part of the media is shown."""

    def parent(self) -> object:
        """Return the composition that holds the item."""


class Composition(Item, Reversible[Item], Sized, Protocol):
    """A core.Composition: a track, or a stack whose first item is the lowest."""


class Timeline(Protocol):
    """A schema.Timeline."""

    name: str
    tracks: Composition
    global_start_time: Time | None
