"""What a camera tells of its lens at one moment, whatever protocol it speaks."""

from dataclasses import dataclass, fields


@dataclass(frozen=True)
class LensSample:
    """Values of a lens; None where the sender was silent.

    source           who sent it, as the sender names itself; "" where it does not
    focus_distance_m, f_stop, t_stop, focal_length_mm   as the sender measures them
    focus_turn, iris_turn, zoom_turn   where the rings stand, 0 to 1 from end to end
    timecode         hours, minutes, seconds, frames
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

    def after(self, before: "LensSample") -> "LensSample":
        """Return this sample with the values of `before` where it is silent.

        Samples are partial: what is absent keeps the value that was sent last.
        """
        names = [field.name for field in fields(self)]
        now = {name: getattr(self, name) for name in names}
        kept = {name: getattr(before, name) for name, value in now.items() if value in (None, "")}
        return LensSample(**{**now, **kept})
