"""Focus marks: the letters on a first assistant's tape, each a distance or a thing to measure.

Distances are averaged as dioptres, in which a focus ring is even and infinity is a number.
"""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from enum import StrEnum
from itertools import count
from string import ascii_uppercase

from heatlens.base.errors import InputError
from heatlens.model.frames import FrameRange

# (frame, x, y) -> metres at that pixel, counted from the display window's corner
DepthAt = Callable[[int, float, float], float]

_SMOOTH_FRAMES_MOST = 1001
_DOUBTED = 0.5  # likeness below which a tracked surface should be looked at


@dataclass(frozen=True, slots=True)
class DistanceMark:
    """A distance by name, from 0 to infinity."""

    name: str
    distance_m: float

    def __post_init__(self) -> None:
        _check_name(self.name)
        if not self.distance_m > 0:
            raise InputError(
                f"Mark {self.name}: the distance must be above 0 m, got {self.distance_m:g} m."
            )


@dataclass(frozen=True, slots=True)
class PointMark:
    """A named point of the picture; its distance is that of the visible surface at each frame.

    x_px, y_px      pixels from the corner of the display window, y downwards
    smooth_frames   number of frames averaged around each one, half before and half after; 1 for no
                    averaging
    """

    name: str
    x_px: float
    y_px: float
    smooth_frames: int = 1

    def __post_init__(self) -> None:
        _check_name(self.name)
        for axis, at in (("x", self.x_px), ("y", self.y_px)):
            if not abs(at) < 1e6:
                raise InputError(f"Mark {self.name}: {axis} cannot be {at:g} px.")
        if not 1 <= self.smooth_frames <= _SMOOTH_FRAMES_MOST:
            raise InputError(
                f"Mark {self.name}: 1 to {_SMOOTH_FRAMES_MOST} frames can be averaged, "
                f"got {self.smooth_frames}."
            )


@dataclass(frozen=True, slots=True)
class ObjectMark:
    """A named object of a 3D scene; its distance is that of its centre at each frame."""

    name: str
    object_name: str

    def __post_init__(self) -> None:
        _check_name(self.name)
        if not self.object_name:
            raise InputError(f"Mark {self.name}: the name of the object is missing.")


class MattePart(StrEnum):
    """Which part of a thing a mark is on."""

    MIDDLE = "middle"
    NEAREST = "nearest"


@dataclass(frozen=True, slots=True)
class MatteMark:
    """A thing of a plate, named by its matte; its distance is measured at each frame.

    matte  where the matte is found and what it shows, such as cryptomatte:hero or objectId:7
    part   the middle of what is seen of the thing, or its nearest part
    """

    name: str
    matte: str
    part: MattePart = MattePart.MIDDLE

    def __post_init__(self) -> None:
        _check_name(self.name)
        where, colon, what = self.matte.partition(":")
        if not (where and colon and what):
            raise InputError(
                f"Mark {self.name}: a thing is named as cryptomatte:NAME, CHANNEL:NUMBER or "
                f"matte:CHANNEL, got {self.matte!r}."
            )


@dataclass(frozen=True, slots=True)
class Click:
    """Where somebody pointed at a surface: a frame and a pixel, counted as that of a PointMark."""

    frame: int
    x_px: float
    y_px: float


@dataclass(frozen=True, slots=True)
class TrackPlace:
    """Where a tracked surface is at a frame.

    distance_m  metres; None where it is hidden or out of the picture
    likeness    how much it looks as it did where it was clicked, 0 to 1
    """

    frame: int
    x_px: float
    y_px: float
    distance_m: float | None = None
    likeness: float = 0.0

    def __post_init__(self) -> None:
        if self.distance_m is not None and not self.distance_m > 0:
            raise InputError(f"The distance must be above 0 m, got {self.distance_m:g} m.")


@dataclass(frozen=True, slots=True)
class TrackMark:
    """A surface of a plate that is followed through the frames.

    clicks  where it was pointed at: the first time, and each correction, at different frames
    places  where it was found, one for each frame in order; none until it has been followed
    """

    name: str
    clicks: tuple[Click, ...]
    places: tuple[TrackPlace, ...] = ()

    def __post_init__(self) -> None:
        _check_name(self.name)
        if not self.clicks or len({click.frame for click in self.clicks}) < len(self.clicks):
            raise InputError(f"Mark {self.name}: give one pixel for each frame, as X,Y@FRAME.")
        for click in self.clicks:
            PointMark(self.name, click.x_px, click.y_px)  # checks the pixel
        frames = [place.frame for place in self.places]
        if sorted(set(frames)) != frames:
            raise InputError(f"Mark {self.name}: its places must be in the order of their frames.")

    def place_at(self, frame: int) -> TrackPlace | None:
        """Return where the surface is at a frame; None where nobody has looked."""
        return next((place for place in self.places if place.frame == frame), None)

    def distance_at_m(self, frame: int) -> float | None:
        """Return its distance at a frame; None where it is hidden or out of the picture."""
        place = self.place_at(frame)
        return None if place is None else place.distance_m

    @property
    def doubted(self) -> list[int]:
        """The frames at which it is seen, but looks unlike what was clicked."""
        seen = [place for place in self.places if place.distance_m is not None]
        return [place.frame for place in seen if place.likeness < _DOUBTED]

    def corrected(self, click: Click) -> "TrackMark":
        """Return the mark with one more click, to be followed again."""
        others = [it for it in self.clicks if it.frame != click.frame]
        clicks = sorted([*others, click], key=lambda it: it.frame)
        return TrackMark(self.name, tuple(clicks))


@dataclass(frozen=True, slots=True)
class WorldMark:
    """A point that stands in the world of plates whose headers tell their camera, in metres."""

    name: str
    x_m: float
    y_m: float
    z_m: float

    def __post_init__(self) -> None:
        _check_name(self.name)
        for axis, at in (("x", self.x_m), ("y", self.y_m), ("z", self.z_m)):
            if not abs(at) < 1e9:
                raise InputError(f"Mark {self.name}: {axis} cannot be {at:g} m.")


Mark = DistanceMark | PointMark | ObjectMark | MatteMark | TrackMark | WorldMark


def next_mark_name(marks: Iterable[Mark]) -> str:
    """Return the first of A to Z, A1 to Z1, A2, … that no mark has."""
    taken = {mark.name for mark in marks}
    names = (f"{letter}{turn or ''}" for turn in count() for letter in ascii_uppercase)
    return next(name for name in names if name not in taken)


def distance_at_m(
    mark: DistanceMark | PointMark, frame: int, depth_at: DepthAt, frames: FrameRange | None = None
) -> float:
    """Return the distance of a mark at a frame, in metres.

    `depth_at` is called only for frames in `frames`. Towards the ends of `frames`, equally many
    frames are averaged before and after, so that an object that approaches evenly is not measured
    late.
    """
    if isinstance(mark, DistanceMark):
        return mark.distance_m
    reach = (mark.smooth_frames - 1) // 2
    if frames is not None:
        reach = max(0, min(reach, frame - frames.first, frames.last - frame))
    around = range(frame - reach, frame + reach + 1)
    dioptres = sum(1.0 / depth_at(at, mark.x_px, mark.y_px) for at in around) / len(around)
    return 1.0 / dioptres if dioptres > 0 else float("inf")


def check_marks(marks: Iterable[Mark]) -> None:
    """Raise InputError if two marks have one name."""
    seen: set[str] = set()
    for mark in marks:
        if mark.name in seen:
            raise InputError(f"Two marks are called {mark.name}.")
        seen.add(mark.name)


def _check_name(name: str) -> None:
    if not name or not name.isprintable() or name != name.strip():
        raise InputError(f"A mark cannot be called {name!r}.")
