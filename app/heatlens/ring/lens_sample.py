"""What a camera tells of its lens at one moment, whatever protocol it speaks."""

from collections.abc import Mapping
from dataclasses import dataclass, field, fields

CHANNELS_MOST = 256  # of one sender; more is noise, and what is new of it is left out


@dataclass(frozen=True)
class LensSample:
    """Values of a lens; None where the sender was silent.

    source           who sent it, as the sender names itself; "" where it does not
    focus_distance_m, f_stop, t_stop, focal_length_mm   as the sender measures them
    focus_turn, iris_turn, zoom_turn   where the rings stand, 0 to 1 from end to end
    timecode         hours, minutes, seconds, frames
    pupil_offset_mm  from the film plane to the entrance pupil
    channels         of a controller: its values by the names that it gives them
    """

    source: str = ""
    focus_distance_m: float | None = None
    f_stop: float | None = None
    t_stop: float | None = None
    focal_length_mm: float | None = None
    focus_turn: float | None = None
    iris_turn: float | None = None
    zoom_turn: float | None = None
    timecode: tuple[int, int, int, int] | None = None
    channels: Mapping[str, float] = field(default_factory=dict)
    pupil_offset_mm: float | None = None

    def after(self, before: "LensSample") -> "LensSample":
        """Return this sample with the values of `before` where it is silent.

        Samples are partial: what is absent keeps the value that was sent last.
        """
        now = {field.name: getattr(self, field.name) for field in fields(self)}
        kept = {name: getattr(before, name) for name, value in now.items() if value in (None, "")}
        channels = {**before.channels, **self.channels}
        if len(channels) > CHANNELS_MOST:
            channels = {n: v for n, v in channels.items() if n in before.channels}
        return LensSample(**{**now, **kept, "channels": channels})
