"""Map channels of a controller to the rings of the lens, and to ranges of values."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from enum import StrEnum

from heatlens.core.base.errors import InputError
from heatlens.core.model.curves.interpolation import Scale
from heatlens.media.live.ring.sources import LensSample

_BENDS = (0.2, 5.0)  # least and greatest bend of a map
_TRAVEL_LEAST = 1e-6  # smaller movements of a channel count as none


class Ring(StrEnum):
    """A ring of the lens, named like the field of Lens that it changes."""

    FOCUS = "focus_distance_m"
    IRIS = "f_stop"
    LENGTH = "focal_length_mm"

    @property
    def words(self) -> str:
        """The name on the screen."""
        return {Ring.FOCUS: "focus", Ring.IRIS: "iris", Ring.LENGTH: "length"}[self]

    @property
    def scale(self) -> Scale:
        """The scale on which the ring is even: dioptres, stops or ratios of focal lengths."""
        return Scale.RECIPROCAL if self is Ring.FOCUS else Scale.LOGARITHMIC


# The default range of each ring: from close to infinity, from wide open to closed.
_DEFAULT_ENDS = {
    Ring.FOCUS: (0.5, float("inf")),
    Ring.IRIS: (1.4, 22.0),
    Ring.LENGTH: (24.0, 135.0),
}
_AXIS = "axis "  # start of the names of a game pad's axes
# Channels with usual names and values from 0 to 1, which are mapped automatically.
_USUAL_NAMES = {
    Ring.FOCUS: ("focus ring", "/focus", "/1/focus"),
    Ring.IRIS: ("iris ring", "/iris", "/1/iris"),
    Ring.LENGTH: ("zoom ring", "/zoom", "/length", "/1/zoom"),
}


@dataclass(frozen=True)
class ChannelMap:
    """The map of a channel to a ring.

    channel          name of the channel
    ring             the ring that it turns
    low, high        values of the channel at its two ends; `low` may be the larger one
    at_low, at_high  values of the lens there
    bend             curve: above 1 slow at the low end, below 1 slow at the high end

    Raise InputError if the ends are equal or not possible for a lens.
    """

    channel: str
    ring: Ring
    low: float = 0.0
    high: float = 1.0
    at_low: float = 1.0
    at_high: float = 2.0
    bend: float = 1.0

    def __post_init__(self) -> None:
        if not abs(self.high - self.low) > _TRAVEL_LEAST:
            raise InputError(f"The channel {self.channel} has the same value at both ends.")
        if not _BENDS[0] <= self.bend <= _BENDS[1]:
            raise InputError(f"A bend is {_BENDS[0]:g} to {_BENDS[1]:g}, not {self.bend:g}.")
        for value in (self.at_low, self.at_high):
            self.ring.scale.position_of(value)

    def value_at(self, channel_value: float) -> float:
        """Return the value of the lens for a value of the channel."""
        turn = min(max((channel_value - self.low) / (self.high - self.low), 0.0), 1.0) ** self.bend
        if turn in (0.0, 1.0):
            return self.at_high if turn else self.at_low
        scale = self.ring.scale
        low, high = scale.position_of(self.at_low), scale.position_of(self.at_high)
        return scale.value_at(low + turn * (high - low))


def default_map(channel: str, ring: Ring) -> ChannelMap:
    """Return a map over the default range of a ring, for a channel 0 to 1 or an axis -1 to 1."""
    low = -1.0 if channel.startswith(_AXIS) else 0.0
    return ChannelMap(channel, ring, low, 1.0, *_DEFAULT_ENDS[ring])


def channels_of(sample: LensSample) -> dict[str, float]:
    """Return all channels of a sample, including the ring positions of a camera."""
    ring_positions = {
        "focus ring": sample.focus_turn,
        "iris ring": sample.iris_turn,
        "zoom ring": sample.zoom_turn,
    }
    return {
        name: position for name, position in ring_positions.items() if position is not None
    } | dict(sample.channels)


def maps_for(sample: LensSample, chosen_maps: Iterable[ChannelMap]) -> tuple[ChannelMap, ...]:
    """Return the chosen maps, and for rings without one a map of a channel with a usual name.

    A ring whose value the sample contains needs no map.
    """
    by_ring = {channel_map.ring: channel_map for channel_map in chosen_maps}
    channels = channels_of(sample)
    for ring, names in _USUAL_NAMES.items():
        channel = next((name for name in names if name in channels), None)
        if ring not in by_ring and channel is not None and getattr(sample, ring) is None:
            by_ring[ring] = default_map(channel, ring)
    return tuple(by_ring.values())


def map_channels(sample: LensSample, chosen_maps: Iterable[ChannelMap]) -> dict[str, float]:
    """Return the fields of Lens with the values that the channels of a sample give them."""
    channels = channels_of(sample)
    return {
        str(channel_map.ring): channel_map.value_at(channels[channel_map.channel])
        for channel_map in maps_for(sample, chosen_maps)
        if channel_map.channel in channels
    }


class Learning:
    """Finds out which channel is being turned, and its range of values."""

    def __init__(self, ring: Ring) -> None:
        """Learn the channel for `ring`; call `observe` while the user turns the control."""
        self.ring = ring
        self._first: dict[str, float] = {}
        self._lowest: dict[str, float] = {}
        self._highest: dict[str, float] = {}

    def observe(self, channels: Mapping[str, float]) -> None:
        """Record the present values of the channels."""
        for name, value in channels.items():
            self._first.setdefault(name, value)
            self._lowest[name] = min(value, self._lowest.get(name, value))
            self._highest[name] = max(value, self._highest.get(name, value))

    @property
    def channel(self) -> str | None:
        """The channel that has moved most, relative to its magnitude; None if none moved."""
        travel = {name: self._relative_travel(name) for name in self._first}
        most_moved = max(travel, key=lambda name: travel[name], default=None)
        return None if most_moved is None or travel[most_moved] <= _TRAVEL_LEAST else most_moved

    def learned_map(self) -> ChannelMap | None:
        """Return the map, with the first position as low end; None if nothing was turned."""
        name = self.channel
        if name is None:
            return None
        low, high = self._lowest[name], self._highest[name]
        if self._first[name] - low > high - self._first[name]:
            low, high = high, low
        at_low, at_high = _DEFAULT_ENDS[self.ring]
        return ChannelMap(
            channel=name, ring=self.ring, low=low, high=high, at_low=at_low, at_high=at_high
        )

    def _relative_travel(self, name: str) -> float:
        """Return how far a channel has moved, relative to its largest magnitude."""
        magnitude = max(abs(self._lowest[name]), abs(self._highest[name]), _TRAVEL_LEAST)
        return (self._highest[name] - self._lowest[name]) / magnitude
