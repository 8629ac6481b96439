"""Focus marks: the letters on a first assistant's tape, each a distance or a thing to measure.

Distances are averaged as dioptres, in which a focus ring is even and infinity is a number.
"""

import re
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from enum import StrEnum
from typing import Self

from heatlens.core.base.errors import InputError
from heatlens.core.base.extras import OnUse
from heatlens.core.model.curves.frames import FrameRange
from heatlens.core.model.marks.mark import Mark, check_pixel
from heatlens.core.model.marks.track_mark import TrackMark
from heatlens.core.model.units import parse_distance_m

# (frame, x, y) -> meters at that pixel, counted from the display window's corner
DepthAt = Callable[[int, float, float], float]

_SMOOTH_FRAMES_MOST = 1001
TYPED_MARK = re.compile(r"([^@=]+)([=@].+)")


@dataclass(frozen=True, slots=True)
class DistanceMark(Mark):
    """A distance by name, from 0 to infinity."""

    distance_m: float

    help = "NAME=2.4m"
    prefix_pattern = "="
    entry = "distance_m"
    meaning = "At every frame"

    def __post_init__(self) -> None:
        Mark.__post_init__(self)
        if not self.distance_m > 0:
            raise InputError(
                f"Mark {self.name}: the distance must be above 0 m, got {self.distance_m:g} m."
            )

    @classmethod
    def parse(cls, name: str, text: str) -> Self:
        return cls(name, parse_distance_m(text))

    def location_words(self, distance: Callable[[float], str]) -> str:
        return distance(self.distance_m)

    def distance_at_m(self, frame: int) -> float | None:
        return self.distance_m


@dataclass(frozen=True, slots=True)
class PointMark(Mark):
    """A named point of the picture; its distance is that of the visible surface at each frame.

    x_px, y_px      pixels from the corner of the display window, y downwards
    smooth_frames   number of frames averaged around each one, half before and half after; 1 for no
                    averaging
    """

    x_px: float
    y_px: float
    smooth_frames: int = 1

    help = "NAME@X,Y"
    prefix_pattern = "@"
    entry = "x_px"
    meaning = "The surface at its point, at this frame"
    on_plate = OnUse("media.plate.mark_distance", "point_m")

    def __post_init__(self) -> None:
        Mark.__post_init__(self)
        check_pixel(self.name, self.x_px, self.y_px)
        if not 1 <= self.smooth_frames <= _SMOOTH_FRAMES_MOST:
            raise InputError(
                f"Mark {self.name}: 1 to {_SMOOTH_FRAMES_MOST} frames can be averaged, "
                f"got {self.smooth_frames}."
            )

    @classmethod
    def parse(cls, name: str, text: str) -> Self:
        x_px, y_px = _parse_numbers(text, 2, "a pixel as NAME@X,Y", f"{name}@{text}")
        return cls(name, x_px, y_px)

    def location_words(self, distance: Callable[[float], str]) -> str:
        mean = f", mean of {self.smooth_frames} frames" if self.smooth_frames > 1 else ""
        return f"pixel {self.x_px:g},{self.y_px:g}{mean}"


@dataclass(frozen=True, slots=True)
class ObjectMark(Mark):
    """A named object of a 3D scene; its distance is that of its center at each frame."""

    object_name: str

    help = "NAME=object:OBJECT"
    prefix_pattern = "=object:"
    entry = "object_name"

    def __post_init__(self) -> None:
        Mark.__post_init__(self)
        if not self.object_name:
            raise InputError(
                f"Mark {self.name}: the name of the object is missing, as in "
                f"{self.name}=object:NAME."
            )

    @classmethod
    def parse(cls, name: str, text: str) -> Self:
        return cls(name, text)

    def location_words(self, distance: Callable[[float], str]) -> str:
        return f"object {self.object_name}"

    @property
    def meaning(self) -> str:
        return f"The middle of {self.object_name}, at this frame"


class MattePart(StrEnum):
    """Which part of a thing a mark is on."""

    MIDDLE = "middle"
    NEAREST = "nearest"


@dataclass(frozen=True, slots=True)
class MatteMark(Mark):
    """A thing of a plate, named by its matte; its distance is measured at each frame.

    matte  where the matte is found and what it shows, such as cryptomatte:hero or objectId:7
    part   the middle of what is seen of the thing, or its nearest part
    """

    matte: str
    part: MattePart = MattePart.MIDDLE

    help = "NAME=cryptomatte:THING, NAME=CHANNEL:ID, NAME=matte:CHANNEL"
    prefix_pattern = "=(?=.*:)"  # anything else with a colon
    entry = "matte"
    on_plate = OnUse("media.plate.mark_distance", "matte_m")

    def __post_init__(self) -> None:
        Mark.__post_init__(self)
        source, colon, thing = self.matte.partition(":")
        if not (source and colon and thing):
            raise InputError(
                f"Mark {self.name}: a thing is named as cryptomatte:NAME, CHANNEL:NUMBER or "
                f"matte:CHANNEL, got {self.matte!r}."
            )

    @classmethod
    def parse(cls, name: str, text: str) -> Self:
        """Return the mark of "MATTE" or "nearest:MATTE"."""
        part, colon, matte = text.partition(":")
        if part + colon == f"{MattePart.NEAREST}:":
            return cls(name, matte, MattePart.NEAREST)
        return cls(name, text)

    def location_words(self, distance: Callable[[float], str]) -> str:
        return f"{self.part} of {self.matte}"

    @property
    def meaning(self) -> str:
        return f"The {self.part} depth of the visible part of {self.matte}, at this frame"


@dataclass(frozen=True, slots=True)
class WorldMark(Mark):
    """A point that stands in the world of plates whose headers tell their camera, in meters."""

    x_m: float
    y_m: float
    z_m: float

    help = "NAME=world:X,Y,Z"
    prefix_pattern = "=world:"
    entry = "z_m"
    meaning = "A place in the world of the plates, at this frame"
    on_plate = OnUse("media.plate.mark_distance", "world_m")

    def __post_init__(self) -> None:
        Mark.__post_init__(self)
        for axis, value in (("x", self.x_m), ("y", self.y_m), ("z", self.z_m)):
            if not abs(value) < 1e9:
                raise InputError(
                    f"Mark {self.name}: {axis} must be a number of metres, not {value:g}."
                )

    @classmethod
    def parse(cls, name: str, text: str) -> Self:
        form = "a point in metres as NAME=world:X,Y,Z"
        return cls(name, *_parse_numbers(text, 3, form, f"{name}=world:{text}"))

    def location_words(self, distance: Callable[[float], str]) -> str:
        return f"world {self.x_m:g},{self.y_m:g},{self.z_m:g} m"


class MarkAnchor(StrEnum):
    """What a mark on a plate holds on to over the frames."""

    THING = "thing"
    PLACE = "place"
    SURFACE = "surface"
    PIXEL = "pixel"

    @classmethod
    def of(cls, mark: Mark) -> Self | None:
        """Return what a mark holds on to; None for a distance or an object of a scene."""
        kinds = {MatteMark: "thing", WorldMark: "place", TrackMark: "surface", PointMark: "pixel"}
        word = kinds.get(type(mark))
        return None if word is None else cls(word)


# In the order in which a typed mark is tried, from the most particular beginning on.
KINDS: tuple[type[Mark], ...] = (
    PointMark,
    ObjectMark,
    WorldMark,
    TrackMark,
    MatteMark,
    DistanceMark,
)


def parse_mark(text: str) -> Mark:
    """Return the mark of --mark. Raises InputError for an invalid one."""
    match = TYPED_MARK.fullmatch(text)
    if match is None:
        raise InputError(f"--mark takes NAME=DISTANCE or NAME@X,Y; got {text!r}.")
    name, location = match.groups()
    kind, prefix = next(
        (kind, prefix)
        for kind in KINDS
        if (prefix := re.match(kind.prefix_pattern, location)) is not None
    )
    return kind.parse(name, location[prefix.end() :])


def _parse_numbers(numbers_text: str, count: int, form: str, mark_text: str) -> tuple[float, ...]:
    """Return `count` numbers separated by commas; `form` and `mark_text` are for the InputError."""
    try:
        numbers = tuple(float(number) for number in numbers_text.split(","))
    except ValueError:
        numbers = ()
    if len(numbers) != count:
        raise InputError(f"--mark takes {form}, got {mark_text!r}.")
    return numbers


def kind_of_entries(names: Iterable[str]) -> type[Mark]:
    """Return the kind of a mark in a shot file, by the names of its entries.

    Without an entry that only one kind has, it is a PointMark.
    """
    entries = set(names)
    return next((kind for kind in reversed(KINDS) if kind.entry in entries), PointMark)


def distance_at_m(
    mark: DistanceMark | PointMark, frame: int, depth_at: DepthAt, frames: FrameRange | None = None
) -> float:
    """Return the distance of a mark at a frame, in meters.

    `depth_at` is called only for frames in `frames`. Towards the ends of `frames`, equally many
    frames are averaged before and after, so that an object that approaches evenly is not measured
    late.
    """
    if isinstance(mark, DistanceMark):
        return mark.distance_m
    reach = (mark.smooth_frames - 1) // 2
    if frames is not None:
        reach = max(0, min(reach, frame - frames.first, frames.last - frame))
    frames_around = range(frame - reach, frame + reach + 1)
    dioptres = sum(
        1.0 / depth_at(near_frame, mark.x_px, mark.y_px) for near_frame in frames_around
    ) / len(frames_around)
    return 1.0 / dioptres if dioptres > 0 else float("inf")


def check_marks(marks: Iterable[Mark]) -> None:
    """Raise InputError if two marks have one name."""
    names: set[str] = set()
    for mark in marks:
        if mark.name in names:
            raise InputError(f"Two marks are called {mark.name}: rename one.")
        names.add(mark.name)
