"""Define a sample of a lens at one moment, independent of the protocol."""

from collections.abc import Mapping
from dataclasses import dataclass, field, fields

from heatlens.model.timecode import Timecode

CHANNELS_MOST = 256  # largest number of channels of a sender; further ones are ignored


@dataclass(frozen=True)
class LensSample:
    """The values of a lens; None for values that the sample does not have.

    source           name that the sender gives itself, or ""
    focus_distance_m, f_stop, t_stop, focal_length_mm   as measured by the sender
    focus_turn, iris_turn, zoom_turn   positions of the rings, 0 to 1 from end to end
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

    def after(self, before: "LensSample") -> "LensSample":
        """Return this sample with missing values taken from `before`.

        Samples can be partial: a missing value has not changed.
        """
        now = {field.name: getattr(self, field.name) for field in fields(self)}
        kept = {name: getattr(before, name) for name, value in now.items() if value in (None, "")}
        channels = {**before.channels, **self.channels}
        if len(channels) > CHANNELS_MOST:
            channels = {n: v for n, v in channels.items() if n in before.channels}
        return LensSample(**{**now, **kept, "channels": channels})
