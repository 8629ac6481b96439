"""A focus mark on a surface of a plate that is followed through the frames."""

import re
from collections.abc import Callable
from dataclasses import dataclass
from typing import Self

from heatlens.core.base.errors import InputError
from heatlens.core.model.marks.mark import Mark, check_pixel

_DOUBTFUL_LIKENESS = 0.5  # likeness below which a tracked surface should be looked at
_CLICK = re.compile(r"(-?\d{1,6}(?:\.\d+)?),(-?\d{1,6}(?:\.\d+)?)@(-?\d{1,9})")


@dataclass(frozen=True, slots=True)
class Click:
    """A frame and a pixel at which the user clicked on a surface; pixels are as in PointMark."""

    frame: int
    x_px: float
    y_px: float


@dataclass(frozen=True, slots=True)
class TrackedPoint:
    """Where a tracked surface is at a frame.

    distance_m  meters; None where it is hidden or out of the picture
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
class TrackMark(Mark):
    """A surface of a plate that is followed through the frames.

    clicks  where it was pointed at: the first time, and each correction, at different frames
    places  where it was found, one for each frame in order; none until it has been followed
    """

    clicks: tuple[Click, ...]
    places: tuple[TrackedPoint, ...] = ()

    help = "NAME=track:X,Y@FRAME"
    prefix_pattern = "=track:"
    entry = "clicks"
    meaning = "The surface that is tracked, at this frame"

    def __post_init__(self) -> None:
        Mark.__post_init__(self)
        if not self.clicks or len({click.frame for click in self.clicks}) < len(self.clicks):
            raise InputError(
                f"Mark {self.name} is tracked from one pixel or more, each at a frame of its own: "
                f"write {self.name}=track:X,Y@FRAME."
            )
        for click in self.clicks:
            check_pixel(self.name, click.x_px, click.y_px)
        frames = [point.frame for point in self.places]
        if sorted(set(frames)) != frames:
            raise InputError(f"Mark {self.name}: its places must be in the order of their frames.")

    @classmethod
    def parse(cls, name: str, text: str) -> Self:
        """Return the mark of "X,Y@FRAME", or of several clicks with "/" between."""
        matches = [_CLICK.fullmatch(part) for part in text.split("/")]
        if None in matches:
            raise InputError(
                f"A surface is followed from a pixel of a frame, as track:X,Y@FRAME; got {text!r}."
            )
        return cls(
            name,
            tuple(
                Click(int(match[3]), float(match[1]), float(match[2])) for match in matches if match
            ),
        )

    def location_words(self, distance: Callable[[float], str]) -> str:
        """Return the pixel and frame of each click as text."""
        clicks = " and ".join(
            f"{click.x_px:g},{click.y_px:g} at {click.frame}" for click in self.clicks
        )
        return f"surface at pixel {clicks}"

    def point_at(self, frame: int) -> TrackedPoint | None:
        """Return where the surface is at a frame; None if it was not followed to that frame."""
        return next((point for point in self.places if point.frame == frame), None)

    def distance_at_m(self, frame: int) -> float | None:
        """Return its distance at a frame; None where it is hidden or out of the picture."""
        point = self.point_at(frame)
        return None if point is None else point.distance_m

    @property
    def doubtful_frames(self) -> list[int]:
        """The frames at which it is seen, but looks unlike what was clicked."""
        measured_points = [point for point in self.places if point.distance_m is not None]
        return [point.frame for point in measured_points if point.likeness < _DOUBTFUL_LIKENESS]

    def add_click(self, click: Click) -> "TrackMark":
        """Return the mark with one more click, to be followed again."""
        other_clicks = [it for it in self.clicks if it.frame != click.frame]
        clicks = sorted([*other_clicks, click], key=lambda it: it.frame)
        return TrackMark(self.name, tuple(clicks))
