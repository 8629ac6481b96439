"""The current facts of a session, for panels and other front ends."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Generic, TypeVar

from heatlens.core.model.boxes import Box
from heatlens.studio.session.desks import PictureDesk, TimeDesk
from heatlens.studio.session.opened.open_source import OpenSource
from heatlens.studio.session.pictures.ruler import Pixel
from heatlens.studio.session.scenes.size_keeping import SizeKeeping
from heatlens.studio.session.shot.editing import Editing

Value = TypeVar("Value")


class _Fact(Generic[Value]):
    """A property of `Facts`, written as where its value comes from."""

    def __init__(self, found: Callable[["Facts"], Value]) -> None:
        self._found = found

    def __get__(self, facts: "Facts", _kind: object) -> Value:
        return self._found(facts)


@dataclass(frozen=True, eq=False)
class Facts:
    """A read-only view of the session; every value is that of the moment it is asked for.

    shot            the current shot
    seen_shot       the shot of the picture: the current one, or one with trial values
    lens, has_lens  the lens at the playhead, and whether the keys give a possible one
    frame           the frame at the playhead
    view, unit      exposure, zoom, overlay, comparison; unit of distances, "m" or "ft"
    crop            the share of a plate that a longer lens would show, to frame; else None
    beats_left      the number of the count-in before a pull is recorded: 3, 2, 1; 0 without one
    """

    _source: OpenSource
    _editing: Editing
    _pictures: PictureDesk
    _time: TimeDesk
    _size: SizeKeeping

    shot = _Fact(lambda it: it._editing.shot)
    seen_shot = _Fact(lambda it: it._editing.seen_shot)
    lens = _Fact(lambda it: it._editing.lens)
    has_lens = _Fact(lambda it: it._editing.has_lens)
    frame = _Fact(lambda it: it._editing.frame)
    view = _Fact(lambda it: it._pictures.view.state)
    unit = _Fact(lambda it: it.view.unit)
    crop = _Fact(lambda it: it._size.crop)
    beats_left = _Fact(lambda it: it._time.recording.beats_left)

    # What is open: a camera that can move, a lens with many points to look from, a frame that has
    # no file and is shown black, a stream that waits for its first picture.
    opening = _Fact(lambda it: it._source.opener.opening or "")  # its name; "" for none
    has_camera = _Fact(lambda it: it._source.has_camera)
    has_many_views = _Fact(lambda it: it._pictures.renderer.has_many_views)
    is_black = _Fact(lambda it: it._source.picture.is_black)
    is_waiting = _Fact(lambda it: it._source.is_waiting)
    stream = _Fact(lambda it: it._source.stream)  # the renderer that may send pictures, or None

    # The picture before the blur (None while there is none), a number that changes with it, and
    # the histogram of its distances (None if it has none).
    plate = _Fact(lambda it: it._source.plate)
    plate_version = _Fact(lambda it: it._source.picture.version)
    histogram = _Fact(lambda it: it._source.picture.histogram)
    # The shape of the display window; one pixel while nothing is open.
    picture_shape = _Fact(lambda it: it._source.picture_shape(it.shot))

    # The picture through the lens: the one to show, whether it is the live one alone or kept frames
    # play, and how much of it is rendered, 0 to 1; None once it is complete.
    seen = _Fact(lambda it: it._time.scheduler.seen)
    plays_kept = _Fact(lambda it: it._time.pull.is_alone)
    is_plain = _Fact(lambda it: it._pictures.view.is_lens_alone and not it.plays_kept)
    part_done = _Fact(lambda it: None if it.plays_kept else it._pictures.live.part_done)
    reference = _Fact(lambda it: it._pictures.references.current)  # to be shown as B, or None

    @property
    def marks_m(self) -> tuple[tuple[str, float], ...]:
        """Names of the marks that are seen at this frame, and the focus in m that is on them."""
        marks = self._time.marks
        focused = [(mark.name, marks.distances.focus_m(mark)) for mark in self.shot.marks]
        return tuple((name, distance_m) for name, distance_m in focused if distance_m is not None)

    @property
    def keyed_focus_m(self) -> float | None:
        """The focus of the keys in m, where the lens has another one: tried or performed."""
        curve = self.shot.curves.focus_distance_m
        if self.shot.curves.live is not None:
            return None
        keyed_m = curve.value_at(self.frame) if curve.keys else self.lens.focus_distance_m
        return None if keyed_m == self.lens.focus_distance_m else keyed_m

    def windows(self) -> tuple[Box, Box]:
        """Return data window and display window of the whole picture."""
        return self._source.feed.windows(self.shot)

    def frame_px(self, pixel: Pixel) -> Pixel:
        """Return the pixel of the frame that is seen at a pixel of the picture."""
        return self._source.frame_px(self.lens, pixel)

    def plate_px(self, pixel: Pixel) -> Pixel:
        """Return the pixel of the loaded plate for one of the frame; previews load smaller ones."""
        return self._source.feed.plate_px(self.shot, pixel)

    def picture_point(self, point: tuple[float, float]) -> tuple[float, float]:
        """Return where a point of the frame lies in the picture."""
        return self._source.picture_point(self.lens, point)
