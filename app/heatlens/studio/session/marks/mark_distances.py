"""The distances of marks at a frame, and never those of another frame.

What is in memory answers at once. A frame that is not is read on a thread when somebody asks for
it, as a pull does for the frame of its arrival.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

from heatlens.core.base.background import Background
from heatlens.core.base.errors import HeatlensError, InputError
from heatlens.core.model.curves.frames import FrameRange
from heatlens.core.model.focus.coc import lean_of
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.marks.mark import Mark
from heatlens.core.model.marks.marks import MatteMark, ObjectMark, PointMark
from heatlens.core.model.marks.track_mark import TrackMark, TrackPlace
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.media.frame_cache.cache import Damaged, FrameCache
from heatlens.media.plate.coc_line import sharp_at
from heatlens.media.plate.mark_distance import mark_on_plate_m
from heatlens.media.plate.plate import Plate
from heatlens.media.plate.read import read_plate
from heatlens.studio.session.messages import Worker, reported
from heatlens.studio.session.opened.open_source import OpenSource
from heatlens.studio.session.scenes.scene_commands import SceneCommands
from heatlens.studio.session.shared import Commands, Shared
from heatlens.studio.session.time.focus_track import ThingDistances, mark_m
from heatlens.studio.session.time.timeline import Timeline


def reading_options(source: OpenSource) -> PlateOptions:
    """Return the options with which the plates of the open source are read."""
    return PlateOptions() if source.opened is None else source.opened.settled


def plates_at(
    cache: FrameCache, options: PlateOptions, frames: FrameRange
) -> Iterator[tuple[int, Plate]]:
    """Return the plate of each frame, see `plate_at`."""
    return ((frame, plate_at(cache, options, frame)) for frame in frames)


def plate_at(cache: FrameCache, options: PlateOptions, frame: int) -> Plate:
    """Return the plate of a frame from memory, or read it. Raise HeatlensError if it is damaged."""
    stands_in = cache.sequence.shown_frame(frame)
    assert stands_in is not None  # a sequence has at least one frame to hold
    plate = cache.get(stands_in)
    if isinstance(plate, Damaged):
        raise InputError(plate.sentence)
    return plate or read_plate(cache.sequence.path_at(stands_in), options)


# Three answers, because two were wrong. While a frame was being read, the focus bar, the list and
# the page showed the distance of the frame before, and a pull whose arrival was not in memory took
# the distance of the frame it starts from. What is not known is now told as such, and whoever needs
# it waits for the frame.
@dataclass(frozen=True)
class MarkAt:
    """What is known of the distance of a mark at a frame.

    distance_m   None where it is hidden, and where it is not known
    is_known     False while the frame is not in memory, or a thing is still being measured
    problem      a sentence why it cannot be known, or ""
    """

    distance_m: float | None = None
    is_known: bool = True
    problem: str = ""


_UNKNOWN, _HIDDEN = MarkAt(is_known=False), MarkAt()
Place = tuple[Mark, int]  # a mark at a frame
_Taken = Callable[[tuple[float, ...]], None]


@dataclass(frozen=True)
class _Found:
    """What was read of a source for a place."""

    opened: object
    place: Place
    at: MarkAt


@dataclass(frozen=True)
class _Wait:
    """Somebody who waits for the focus on marks at frames of a source."""

    opened: object
    places: tuple[Place, ...]
    take: _Taken


class MarkDistances(Commands, Worker):
    """Measures marks on what is open; `things` measures those found by a matte, on a thread."""

    def __init__(
        self, shared: Shared, timeline: Timeline, scenes: SceneCommands, things: ThingDistances
    ) -> None:
        super().__init__(shared)
        self._timeline, self._scenes, self._things = timeline, scenes, things
        self._reader: Background[_Found] = Background(self._wake)
        self._read: dict[Place, MarkAt] = {}  # the places that were read for somebody
        self._wait: _Wait | None = None

    def of_m(self, mark: Mark, frame: int | None = None) -> float | None:
        """Return the distance of a mark in m at a frame, or at the playhead.

        Return None where it is hidden, and while it is not known: see `at`.
        """
        return self.at(mark, frame).distance_m

    def at(self, mark: Mark, frame: int | None = None) -> MarkAt:
        """Return what is known now of a mark at a frame, or at the playhead; reads no file."""
        at = self._editing.frame if frame is None else frame
        if isinstance(mark, ObjectMark):
            return MarkAt(self._scenes.object_m(mark.object_name, at))
        known_m = mark.distance_at_m(at)
        if known_m is not None:
            return MarkAt(known_m)
        if isinstance(mark, PointMark) and self._source.has_camera:
            return MarkAt(self._in_scene_m(mark, at))
        return self._on_plate(mark, at)

    def _on_plate(self, mark: Mark, frame: int) -> MarkAt:
        cache, picture = self._timeline.cache, self._source.picture
        is_shown = self._source.is_settled_at(frame) and not (picture.problem or picture.is_black)
        if cache is None or is_shown:
            return self._on(self._source.plate, mark)
        try:
            stands_in = cache.sequence.shown_frame(frame, self._timeline.missing)
        except InputError as error:
            return MarkAt(problem=str(error))
        plate = None if stands_in is None else cache.get(stands_in)
        if isinstance(plate, Damaged):
            return MarkAt(problem=plate.sentence)
        return _HIDDEN if stands_in is None else self._on(plate, mark)

    def _on(self, plate: Plate | None, mark: Mark) -> MarkAt:
        """Return what is known of a mark on a plate in memory; None for one that is not."""
        if plate is None:
            return _UNKNOWN
        if isinstance(mark, MatteMark):
            distance_m = self._things.distance_m(plate, mark)
            return MarkAt(distance_m, self._things.is_measured(plate, mark))
        return MarkAt(mark_m(plate, mark))

    def _in_scene_m(self, mark: PointMark, frame: int) -> float | None:
        pixel = int(mark.x_px), int(mark.y_px)
        if self._source.is_settled_at(frame):
            x, y = self._source.feed.plate_px(self._editing.shot, pixel)
            return mark_m(self._source.plate, replace(mark, x_px=x, y_px=y))
        return self._scenes.point_m(*pixel, frame)

    def focus_m(self, mark: Mark, frame: int | None = None) -> float | None:
        """Return the focus distance with which a mark is sharp; None as for `of_m`.

        It is not the distance of the mark where the plane of focus leans at the mark's point.
        """
        distance_m = self.of_m(mark, frame)
        return None if distance_m is None else self._focus_m(mark, frame, distance_m)

    def _focus_m(self, mark: Mark, frame: int | None, distance_m: float) -> float:
        lens = self._editing.lens if frame is None else self._editing.shot.lens_at(frame)
        at = self._editing.frame if frame is None else frame
        return self.sharp_m(mark, lens, at, distance_m)

    # A tilted or split lens is not sharp at one distance, so that the focus of a mark depends on
    # its place in the picture too. The computed lean is tested, and not single fields of the lens
    # such as its tilt: a field that is added later would be forgotten here.
    def sharp_m(self, mark: Mark, lens: Lens, frame: int, distance_m: float) -> float:
        """Return the focus distance of `lens` with which a mark at this distance is sharp."""
        place = mark.place_at(frame) if isinstance(mark, TrackMark) else mark
        if not isinstance(place, PointMark | TrackPlace):
            return distance_m
        shape = self._source.picture_shape(self._editing.shot)
        lean = lean_of(lens, (shape.width_px, shape.height_px), shape.pixel_aspect)
        if lean.is_level:
            return distance_m
        return sharp_at(lens, lean, (place.x_px, place.y_px), distance_m).focus_distance_m

    # Frames that are not in memory

    def forget_read(self) -> None:
        """Forget what was read for somebody: files may have changed since."""
        self._read = {}

    def measured(self, mark: Mark, frame: int) -> MarkAt:
        """Return what is known of a mark at a frame, and have the frame read if it is nothing."""
        known = self._known((mark, frame))
        if not known.is_known and not self._reader.is_busy:
            self._begin((mark, frame))
        return known

    def ask(self, places: tuple[Place, ...], take: _Taken) -> None:
        """Call `take` with the focus in m on each mark at its frame, as soon as all are known.

        Where one has no distance, why is said instead. Who asks later takes the place of who waits.
        """
        self._wait = _Wait(self._source.opened, places, take)
        self._answer()
        if self._wait is not None:
            frames = " and ".join(sorted({str(frame) for _, frame in self._unknown(places)}))
            self._say(f"Reading frame {frames} to measure how far the mark is there ...")

    @property
    def is_waited_for(self) -> bool:
        """True while somebody waits for a frame that is being read."""
        return self._wait is not None

    def poll(self) -> None:
        """Take over what was measured, and answer who waits; call this once a frame."""
        if (read := self._reader.poll()) is not None and read.opened is self._source.opened:
            self._read[read.place] = read.at
        self._answer()

    def _answer(self) -> None:
        wait = self._wait
        if wait is None:
            return
        if wait.opened is not self._source.opened:
            self._wait = None
        elif unknown := self._unknown(wait.places):
            if not self._reader.is_busy:
                self._begin(unknown[0])
        else:
            self._wait = None
            with reported(self._say):
                wait.take(tuple(self._asked_m(place) for place in wait.places))
            self.forget_read()

    def _unknown(self, places: tuple[Place, ...]) -> list[Place]:
        return [place for place in places if not self._known(place).is_known]

    def _known(self, place: Place) -> MarkAt:
        known = self.at(*place)
        return known if known.is_known else self._read.get(place, known)

    def _asked_m(self, place: Place) -> float:
        """Return the focus on a mark that is known; raise InputError where it has no distance."""
        (mark, frame), known = place, self._known(place)
        if known.distance_m is None:
            why = known.problem or "it is hidden or outside the picture."
            raise InputError(f"Mark {mark.name} has no distance at frame {frame}: {why}")
        return self._focus_m(mark, frame, known.distance_m)

    def _begin(self, place: Place) -> None:
        """Read the plate of a frame and measure a mark on it, on a thread."""
        cache, opened = self._timeline.cache, self._source.opened
        options = reading_options(self._source)
        if cache is not None:
            self._reader.start(lambda: _Found(opened, place, _measured(cache, options, place)))


def _measured(cache: FrameCache, options: PlateOptions, place: Place) -> MarkAt:
    mark, frame = place
    try:
        return MarkAt(mark_on_plate_m(plate_at(cache, options, frame), mark))
    except HeatlensError as error:
        return MarkAt(problem=str(error))
