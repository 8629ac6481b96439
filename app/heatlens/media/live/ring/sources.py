"""Define a sample of a lens at one moment, and keep the newest ones of each sender.

The interface of lens inputs is here too: a camera on the network, a controller or a game pad.
Nothing here depends on the protocol. The axes of a game pad or jog wheel are channels of
`PadInput`; the window reads the device.
"""

import time
from collections import deque
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, fields
from threading import Lock

from heatlens.core.base.closing import Closing
from heatlens.core.model.timecode import Timecode

CHANNELS_MOST = 256  # largest number of channels of a sender; further ones are ignored


@dataclass(frozen=True)
class LensSample:
    """The values of a lens; None for values that the sample does not have.

    source           name that the sender gives itself, or ""
    focus_distance_m, f_stop, t_stop, focal_length_mm   as measured by the sender
    focus_turn, iris_turn, zoom_turn   positions of the rings, 0 to 1 from one end to the other
    timecode         of the frame of the sample
    frames_per_second   the rate of the samples, in which the timecode counts
    pupil_offset_mm  from the film plane to the entrance pupil
    channels         values of a controller, by its names for them
    """

    source: str = ""
    focus_distance_m: float | None = None
    f_stop: float | None = None
    t_stop: float | None = None
    focal_length_mm: float | None = None
    focus_turn: float | None = None
    iris_turn: float | None = None
    zoom_turn: float | None = None
    timecode: Timecode | None = None
    channels: Mapping[str, float] = field(default_factory=dict)
    pupil_offset_mm: float | None = None
    frames_per_second: float | None = None

    def filled_from(self, previous: "LensSample") -> "LensSample":
        """Return this sample with missing values taken from `previous`.

        Samples can be partial: a missing value has not changed.
        """
        own_values = {field.name: getattr(self, field.name) for field in fields(self)}
        previous_values = {
            name: getattr(previous, name)
            for name, value in own_values.items()
            if value in (None, "")
        }
        channels = {**previous.channels, **self.channels}
        if len(channels) > CHANNELS_MOST:
            channels = {
                name: channel_value
                for name, channel_value in channels.items()
                if name in previous.channels
            }
        return LensSample(**{**own_values, **previous_values, "channels": channels})


MAX_SOURCES = 16
SILENT_AFTER_S = 1.0  # a camera without samples for this long counts as silent
_RATE_SAMPLES = 50  # number of samples to average the rate over
NumberedSample = tuple[int, LensSample]  # (version of `RingSources` after the sample, sample)
_LOG_MOST = 4096  # samples kept for recording: 4 s at 1,000 a second


@dataclass
class RingSource:
    """The samples of one sender.

    `sample` has the latest of every value that was ever sent. `first_sample_s` and `last_sample_s`
    are times on the clock of the receiver. `log` has the latest samples, each with its version
    number.
    """

    sample: LensSample
    first_sample_s: float
    last_sample_s: float
    times_s: deque[float] = field(default_factory=lambda: deque(maxlen=_RATE_SAMPLES))
    log: deque[NumberedSample] = field(default_factory=lambda: deque(maxlen=_LOG_MOST))

    @property
    def rate_hz(self) -> float:
        """The mean number of samples per second; 0 before the second sample."""
        span_s = self.times_s[-1] - self.times_s[0] if self.times_s else 0.0
        return (len(self.times_s) - 1) / span_s if span_s > 0 else 0.0


@dataclass(frozen=True)
class SourceState:
    """The state of the sources at a moment.

    sample    the newest values of the followed source; None before its first sample
    sources   names of all sources, in the order in which they were first heard
    rate_hz, age_s   samples per second, and time since the last sample
    version   increases with every sample of any source
    silent_after_s   age from which the source is silent; infinite for one that sends only changes
    """

    sample: LensSample | None
    sources: tuple[str, ...]
    rate_hz: float
    age_s: float
    version: int
    silent_after_s: float = SILENT_AFTER_S

    @property
    def is_silent(self) -> bool:
        """True if the source has stopped sending."""
        return self.sample is not None and self.age_s > self.silent_after_s


class RingSources:
    """Keeps the newest values of a limited number of senders; any thread may call it."""

    def __init__(
        self, clock: Callable[[], float] = time.monotonic, silent_after_s: float = SILENT_AFTER_S
    ) -> None:
        """Begin without sources; `clock` gives seconds. `SourceState` explains `silent_after_s`."""
        self._silent_after_s = silent_after_s
        self.version = 0
        self._clock = clock
        self._sources: dict[str, RingSource] = {}
        self._followed_name = ""  # name of the source that None stands for
        self._lock = Lock()

    def add_sample(self, sample: LensSample) -> None:
        """Add a sample to its source and to the log; a new source may replace a silent one."""
        now_s = self._clock()
        with self._lock:
            source = self._sources.get(sample.source)
            if source is None:
                self._drop_oldest_sources()
                source = self._sources[sample.source] = RingSource(sample, now_s, now_s)
            source.sample, source.last_sample_s = sample.filled_from(source.sample), now_s
            source.times_s.append(now_s)
            self.version += 1
            source.log.append((self.version, source.sample))

    def samples_since(self, version: int, source: str | None = None) -> tuple[NumberedSample, ...]:
        """Return the samples of `source` that came after `version`, the oldest first.

        Each has all values as they were then. None stands for a source as in `source_state`.
        """
        with self._lock:
            ring_source = self._find_source(source)
            log = () if ring_source is None else ring_source.log
            return tuple(numbered_sample for numbered_sample in log if numbered_sample[0] > version)

    def source_state(self, source: str | None = None) -> SourceState:
        """Return the present state of `source`; None stands for the first source that sent.

        If that has fallen silent, None stands for a source that began to send later, if there is
        one: a tracker that is started again has another name.
        """
        with self._lock:
            names, ring_source = tuple(self._sources), self._find_source(source)
            if ring_source is None:
                return SourceState(
                    sample=None, sources=names, rate_hz=0.0, age_s=0.0, version=self.version
                )
            age_s = self._clock() - ring_source.last_sample_s
            return SourceState(
                *(
                    ring_source.sample,
                    names,
                    ring_source.rate_hz,
                    age_s,
                    self.version,
                    self._silent_after_s,
                )
            )

    def _find_source(self, source: str | None) -> RingSource | None:
        """Return the source of this name; for None the followed one, or its successor if silent."""
        if source is not None:
            return self._sources.get(source)
        if self._followed_name not in self._sources:
            self._followed_name = next(iter(self._sources), "")
        followed_source = self._sources.get(self._followed_name)
        if followed_source is None or not self._is_silent(followed_source):
            return followed_source
        later_names = (
            name
            for name, ring_source in self._sources.items()
            if ring_source.first_sample_s > followed_source.last_sample_s
        )
        active_names = (name for name in later_names if not self._is_silent(self._sources[name]))
        self._followed_name = next(active_names, self._followed_name)
        return self._sources[self._followed_name]

    def _is_silent(self, source: RingSource) -> bool:
        return self._clock() - source.last_sample_s > self._silent_after_s

    def _drop_oldest_sources(self) -> None:
        """Drop the sources that have been silent for longest until there is room for one more."""
        while len(self._sources) >= MAX_SOURCES:
            del self._sources[
                min(self._sources, key=lambda name: self._sources[name].last_sample_s)
            ]


_POLL_S = 0.02


class RingInput(Closing):
    """An input for the rings of a lens; any thread may call it.

    address   the address or name of the device, for the user
    sources   what each source has sent
    """

    address: object
    sources: RingSources
    _on_news: Callable[[], None] | None = None
    refused = 0  # number of invalid datagrams
    fault: str | None = None  # why the last datagram was refused

    def listen(self, on_news: Callable[[], None]) -> None:
        """Call `on_news` after each later sample, on any thread."""
        self._on_news = on_news

    @property
    def lost(self) -> int:
        """The number of samples that were never complete."""
        return 0

    def source_state(self, source: str | None = None) -> SourceState:
        """Return the present state of a source; see `RingSources.source_state`."""
        return self.sources.source_state(source)

    def seconds_until_due(self) -> float | None:
        """Return the seconds until the window must poll the input; None if news wake it."""
        return None


class Controls(RingInput):
    """Keeps the channels of a connected controller."""

    def __init__(
        self,
        address: object,
        clock: Callable[[], float] = time.monotonic,
        silent_after_s: float = SILENT_AFTER_S,
    ) -> None:
        """Begin without channels; for `silent_after_s` see `RingSources`."""
        self.address = address
        self.sources = RingSources(clock, silent_after_s)

    def store_channels(self, source: str, channels: Mapping[str, float]) -> None:
        """Store values of channels, and tell who listens."""
        self.sources.add_sample(LensSample(source, channels=dict(channels)))
        if self._on_news is not None:
            self._on_news()


class PadInput(Controls):
    """Takes the axes of a pad from the window, whose library works on its thread only."""

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        """Begin without a pad."""
        super().__init__("pad", clock)
        self._clock = clock
        self._last_read_s = -_POLL_S

    def poll(self, read: Callable[[], Mapping[str, float] | None]) -> None:
        """Store the axes that `read` returns, at most as often as a pad changes.

        `read` returns them by their names, or None while no pad is connected, which counts as
        silence.
        """
        now_s = self._clock()
        if now_s - self._last_read_s < _POLL_S:
            return
        self._last_read_s = now_s
        axes = read()
        if axes is not None:
            self.store_channels("", axes)

    def seconds_until_due(self) -> float:
        """Return the seconds until the pad is to be read again."""
        return _POLL_S

    def close(self) -> None:
        """Do nothing: the window holds the pad."""
