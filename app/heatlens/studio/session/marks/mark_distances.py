"""The distances of marks at a frame, and never those of another frame.

A plate in memory is measured at once. A plate that is not is read on a thread on request, as a pull
requests the frame of its arrival.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

from heatlens.core.base.background import Background
from heatlens.core.base.errors import HeatlensError, InputError
from heatlens.core.base.messages import Worker, report_errors
from heatlens.core.model.curves.frames import FrameRange
from heatlens.core.model.focus.focus_offset import focus_offset_of
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.marks.mark import Mark, MarkDistance
from heatlens.core.model.marks.marks import MatteMark, ObjectMark, PointMark
from heatlens.core.model.marks.track_mark import TrackedPoint, TrackMark
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.media.frame_cache.cache import Damaged, FrameCache
from heatlens.media.plate.coc_line import sharp_at
from heatlens.media.plate.mark_distance import mark_on_plate_m
from heatlens.media.plate.plate import Plate
from heatlens.media.plate.read import read_plate
from heatlens.studio.session.opened.open_source import OpenSource
from heatlens.studio.session.scenes.scene_commands import SceneCommands
from heatlens.studio.session.shared import Commands, Shared
from heatlens.studio.session.time.focus_track import MatteDistances, mark_m
from heatlens.studio.session.time.timeline import Timeline


def reading_options(source: OpenSource) -> PlateOptions:
    """Return the options with which the plates of the open source are read."""
    return PlateOptions() if source.opened is None else source.opened.settled_options


def plates_at(
    cache: FrameCache, options: PlateOptions, frames: FrameRange
) -> Iterator[tuple[int, Plate]]:
    """Yield each frame with its plate, see `plate_at`."""
    return ((frame, plate_at(cache, options, frame)) for frame in frames)


def plate_at(cache: FrameCache, options: PlateOptions, frame: int) -> Plate:
    """Return the plate of a frame from memory, or read it. Raise HeatlensError if it is damaged."""
    held_frame = cache.sequence.shown_frame(frame)
    assert held_frame is not None  # a sequence has at least one frame to hold
    plate = cache.get(held_frame)
    if isinstance(plate, Damaged):
        raise InputError(plate.sentence)
    return plate or read_plate(cache.sequence.path_at(held_frame), options)


_UNKNOWN, _HIDDEN = MarkDistance(is_known=False), MarkDistance()
MarkFrame = tuple[Mark, int]  # a mark at a frame
_Receiver = Callable[[tuple[float, ...]], None]


@dataclass(frozen=True)
class _Reading:
    """The distance of a mark that was read from a frame of a source."""

    opened: object
    mark_frame: MarkFrame
    distance: MarkDistance


@dataclass(frozen=True)
class _Request:
    """A request for the focus on marks at frames of a source; `receive` is given the results."""

    opened: object
    mark_frames: tuple[MarkFrame, ...]
    receive: _Receiver


class MarkDistances(Commands, Worker):
    """Measures marks on the open source; `matte_distances` measures those on mattes."""

    def __init__(
        self,
        shared: Shared,
        timeline: Timeline,
        scenes: SceneCommands,
        matte_distances: MatteDistances,
        is_awaited: Callable[[Mark, int], bool],
    ) -> None:
        """Create it; `is_awaited` tells that a mark at a frame is being tracked."""
        super().__init__(shared)
        self._is_awaited = is_awaited
        self._timeline, self._scenes, self._matte_distances = timeline, scenes, matte_distances
        self._reader: Background[_Reading] = Background(self._wake)
        self._read_distances: dict[
            MarkFrame, MarkDistance
        ] = {}  # from frames that were read on request
        self._request: _Request | None = None

    def distance_m(self, mark: Mark, frame: int | None = None) -> float | None:
        """Return the distance of a mark in m at a frame, or at the playhead.

        Return None where the mark is hidden, and while the distance is not known: see `distance`.
        """
        return self.distance(mark, frame).distance_m

    def distance(self, mark: Mark, frame: int | None = None) -> MarkDistance:
        """Return the distance of a mark at a frame, or at the playhead, without reading a file."""
        at_frame = self._editing.frame if frame is None else frame
        if isinstance(mark, ObjectMark):
            return MarkDistance(self._scenes.object_m(mark.object_name, at_frame))
        known_m = mark.distance_at_m(at_frame)
        if known_m is not None:
            return MarkDistance(known_m)
        if isinstance(mark, PointMark) and self._source.has_camera:
            return MarkDistance(self._in_scene_m(mark, at_frame))
        return self._on_plate(mark, at_frame)

    def _on_plate(self, mark: Mark, frame: int) -> MarkDistance:
        """Return the distance of a mark on the shown plate, or on one in the frame cache."""
        cache, picture = self._timeline.cache, self._source.picture
        is_shown = self._source.is_settled_at(frame) and not (picture.problem or picture.is_black)
        if cache is None or is_shown:
            return self._on_loaded_plate(self._source.plate, mark)
        try:
            held_frame = cache.sequence.shown_frame(frame, self._timeline.missing)
        except InputError as error:
            return MarkDistance(problem=str(error))
        plate = None if held_frame is None else cache.get(held_frame)
        if isinstance(plate, Damaged):
            return MarkDistance(problem=plate.sentence)
        return _HIDDEN if held_frame is None else self._on_loaded_plate(plate, mark)

    def _on_loaded_plate(self, plate: Plate | None, mark: Mark) -> MarkDistance:
        """Return the distance of a mark on a plate in memory; unknown if the plate is None."""
        if plate is None:
            return _UNKNOWN
        if isinstance(mark, MatteMark):
            distance_m = self._matte_distances.distance_m(plate, mark)
            return MarkDistance(distance_m, self._matte_distances.is_measured(plate, mark))
        return MarkDistance(mark_m(plate, mark))

    def _in_scene_m(self, mark: PointMark, frame: int) -> float | None:
        """Return the distance of a point of a scene at a frame in m; None outside the picture."""
        pixel = int(mark.x_px), int(mark.y_px)
        if self._source.is_settled_at(frame):
            x, y = self._source.feed.plate_px(self._editing.shot, pixel)
            return mark_m(self._source.plate, replace(mark, x_px=x, y_px=y))
        return self._scenes.point_m(*pixel, frame)

    def focus_m(self, mark: Mark, frame: int | None = None) -> float | None:
        """Return the focus distance with which a mark is sharp; None as for `distance_m`.

        With a tilted plane of focus, it differs from the distance of the mark.
        """
        distance_m = self.distance_m(mark, frame)
        return None if distance_m is None else self._focus_m(mark, frame, distance_m)

    def _focus_m(self, mark: Mark, frame: int | None, distance_m: float) -> float:
        """Return the focus for a mark at a distance, with the lens of a frame or the playhead."""
        lens = self._editing.lens if frame is None else self._editing.shot.lens_at(frame)
        at_frame = self._editing.frame if frame is None else frame
        return self.focus_for_distance_m(mark, lens, at_frame, distance_m)

    # A tilted or split lens is not sharp at one distance, so the focus of a mark depends on its
    # position in the picture too. The computed plane of focus is tested instead of single fields of
    # the lens such as its tilt, because a field that is added later would be forgotten here.
    def focus_for_distance_m(self, mark: Mark, lens: Lens, frame: int, distance_m: float) -> float:
        """Return the focus distance of `lens` with which a mark at this distance is sharp."""
        point = mark.point_at(frame) if isinstance(mark, TrackMark) else mark
        if not isinstance(point, PointMark | TrackedPoint):
            return distance_m
        shape = self._source.picture_shape(self._editing.shot)
        plane = focus_offset_of(lens, (shape.width_px, shape.height_px), shape.pixel_aspect)
        if plane.is_level:
            return distance_m
        return sharp_at(lens, plane, (point.x_px, point.y_px), distance_m).focus_distance_m

    # Frames that are not in memory

    def forget_read_distances(self) -> None:
        """Forget the distances that were read on request: files may have changed since."""
        self._read_distances = {}

    def measure(self, mark: Mark, frame: int) -> MarkDistance:
        """Return the distance of a mark at a frame; begin to read the frame if it is not known."""
        if self._is_awaited(mark, frame):
            return _UNKNOWN
        distance = self._known_distance((mark, frame))
        if not distance.is_known and not self._reader.is_busy:
            self._begin_reading((mark, frame))
        return distance

    def request(self, mark_frames: tuple[MarkFrame, ...], receive: _Receiver) -> None:
        """Call `receive` with the focus in m on each mark at its frame, as soon as all are known.

        If a mark has no distance, report the reason instead. A later request replaces this one.
        """
        self._request = _Request(self._source.opened, mark_frames, receive)
        self._answer_request()
        if self._request is not None:
            frames = " and ".join(sorted({str(frame) for _, frame in self._unknown(mark_frames)}))
            awaited = sorted({mark.name for mark, at in mark_frames if self._is_awaited(mark, at)})
            self._notify(
                f"This waits until {' and '.join(awaited)} is followed through the frames ..."
                if awaited
                else f"Reading frame {frames} to measure how far the mark is there ..."
            )

    @property
    def has_request(self) -> bool:
        """True while a request waits for a frame that is being read."""
        return self._request is not None

    def poll(self) -> None:
        """Store a measured distance, and answer the request; call this once a frame."""
        if (reading := self._reader.poll()) is not None and reading.opened is self._source.opened:
            self._read_distances[reading.mark_frame] = reading.distance
        self._answer_request()

    def _answer_request(self) -> None:
        """Answer the request if all its distances are known; else read the next frame for it."""
        request = self._request
        if request is None or any(self._is_awaited(*it) for it in request.mark_frames):
            return
        named = self._editing.shot.mark_named  # a mark may be tracked since the request
        request = replace(
            request, mark_frames=tuple((named(it.name) or it, at) for it, at in request.mark_frames)
        )
        if request.opened is not self._source.opened:
            self._request = None
        elif unknown_mark_frames := self._unknown(request.mark_frames):
            if not self._reader.is_busy:
                self._begin_reading(unknown_mark_frames[0])
        else:
            self._request = None
            with report_errors(self._notify):
                request.receive(
                    tuple(self._requested_focus_m(mark_frame) for mark_frame in request.mark_frames)
                )
            self.forget_read_distances()

    def _unknown(self, mark_frames: tuple[MarkFrame, ...]) -> list[MarkFrame]:
        """Return the marks and frames whose distance is not known yet."""
        return [
            mark_frame
            for mark_frame in mark_frames
            if not self._known_distance(mark_frame).is_known
        ]

    def _known_distance(self, mark_frame: MarkFrame) -> MarkDistance:
        """Return the distance of a mark at a frame from memory, or as it was read on request."""
        distance = self.distance(*mark_frame)
        return distance if distance.is_known else self._read_distances.get(mark_frame, distance)

    def _requested_focus_m(self, mark_frame: MarkFrame) -> float:
        """Return the focus on a mark that is known; raise InputError where it has no distance."""
        (mark, frame), distance = mark_frame, self._known_distance(mark_frame)
        if distance.distance_m is None:
            reason = distance.problem or "it is hidden or outside the picture."
            raise InputError(f"Mark {mark.name} has no distance at frame {frame}: {reason}")
        return self._focus_m(mark, frame, distance.distance_m)

    def _begin_reading(self, mark_frame: MarkFrame) -> None:
        """Read the plate of a frame and measure a mark on it, on a thread."""
        cache, opened = self._timeline.cache, self._source.opened
        options = reading_options(self._source)
        if cache is not None:
            self._reader.start(
                lambda: _Reading(opened, mark_frame, _measure_on_plate(cache, options, mark_frame))
            )


def _measure_on_plate(
    cache: FrameCache, options: PlateOptions, mark_frame: MarkFrame
) -> MarkDistance:
    """Read the plate of a frame and measure a mark on it; return the problem if that fails."""
    mark, frame = mark_frame
    try:
        return MarkDistance(mark_on_plate_m(plate_at(cache, options, frame), mark))
    except HeatlensError as error:
        return MarkDistance(problem=str(error))
