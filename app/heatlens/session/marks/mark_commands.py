"""The commands on focus marks: set them, focus on them, pull to them, follow them."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from math import inf

from heatlens.base.background import Background
from heatlens.base.errors import InputError
from heatlens.frame_cache.cache import FrameCache
from heatlens.model.curves.frames import FrameRange
from heatlens.model.focus.coc import sharp_dioptres
from heatlens.model.focus.lean import lean_of
from heatlens.model.focus.live_focus import Distances
from heatlens.model.lens.lens import Lens
from heatlens.model.marks.mark import Mark
from heatlens.model.marks.marks import (
    DistanceMark,
    MatteMark,
    ObjectMark,
    PointMark,
    next_mark_name,
)
from heatlens.model.marks.track_mark import Click, TrackMark, TrackPlace
from heatlens.model.shot.pull import (
    EASE_PERCENT,
    PullShape,
    followed,
    held_focus,
    reversed_focus,
    shaped_pull,
)
from heatlens.plate.coc_line import sharp_at, surfaces_at
from heatlens.plate.mark_distance import mark_over_plates_m, world_mark
from heatlens.plate.mattes.mattes import has_things
from heatlens.plate.plate import Plate
from heatlens.session.loop.messages import reported
from heatlens.session.loop.worker import Worker
from heatlens.session.marks.live_following import LiveFollowing
from heatlens.session.marks.mark_measuring import (
    on_thing,
    plates_at,
    reading_options,
    smoothed,
)
from heatlens.session.marks.surface_tracking import SurfaceTracking
from heatlens.session.scenes.point_following import Following
from heatlens.session.scenes.scene_commands import SceneCommands
from heatlens.session.shared import Commands, Shared
from heatlens.session.time.focus_track import ThingDistances, mark_m
from heatlens.session.time.timeline import Timeline

_Measured = tuple[Mark, Distances]
PULL_FRAMES = 18  # first length of a pull: three quarters of a second at 24 fps


class MarkCommands(Commands, Worker):
    """The commands on focus marks; each is one undo step."""

    def __init__(self, shared: Shared, timeline: Timeline, scenes: SceneCommands) -> None:
        super().__init__(shared)
        self._timeline = timeline
        self._scenes = scenes
        self.pull_from: str | None = None  # the name of a mark; None for the current focus
        self.pull_to = self._pulled_to = ""
        self.pull_frames = self._wished_frames = PULL_FRAMES
        self.pull_ease_percent = EASE_PERCENT
        self.pull_shape = PullShape.EASE
        self.pulls_made = 0  # counts pulls since the program started
        self._following: Following | None = None  # the measurement in progress, in a scene
        self._reader: Background[_Measured] = Background(self._wake)
        self._picker: Background[PointMark | MatteMark] = Background(self._wake)
        self.tracking = SurfaceTracking(shared, self._take_tracked)
        self.corrected: str | None = None  # the tracked mark that the next click corrects
        self._thing_asked: Callable[[str], None] | None = None  # takes the matte of the next click
        self.things = ThingDistances(self._wake)
        self.live = LiveFollowing(shared)
        self.workers: tuple[Worker, ...] = (self, self.things, self.tracking, self.live)

    @property
    def is_reading(self) -> bool:
        """True while frames are read or drawn to follow a mark."""
        return self._reader.is_busy or self.tracking.is_busy or self._following is not None

    # One mark

    def set_here(self) -> None:
        """Set a mark at the distance in focus."""
        marks, distance_m = self._editing.shot.marks, self._editing.lens.focus_distance_m
        self._add(DistanceMark(next_mark_name(marks), distance_m))

    def set_point(self, pixel: tuple[int, int]) -> None:
        """Set a mark at a pixel of the display window: on the thing there, else on the point.

        After `pick_thing` or `correct` it answers that instead. A plate with mattes of things is
        read again for that, on a thread.
        """
        plate = self._source.plate
        if plate is None:
            return
        pixel = self._source.frame_px(self._editing.lens, pixel)
        with reported(self._say):
            plate_px = self._source.feed.plate_px(self._editing.shot, pixel)
            seen = surfaces_at(plate, self._editing.lens, *plate_px)[0]
            pixel = pixel if self._source.has_camera else (seen.x, seen.y)
            name = next_mark_name(self._editing.shot.marks)
            point = PointMark(name, float(pixel[0]), float(pixel[1]))
            corrected, self.corrected = self.named(self.corrected), None
            if isinstance(corrected, TrackMark):
                self.track(corrected, point)
            elif self._thing_asked is not None and not has_things(plate):
                self._answer(point)
            elif has_things(plate):
                self._picker.start(lambda: on_thing(plate, point))
            else:
                self._add(point)

    def pick_thing(self, take: Callable[[str, str], None], field: str) -> None:
        """Let the next click that would set a mark tell the thing of an option."""
        self._thing_asked = partial(take, field)
        self._say("Ctrl+Shift+click on the thing.")

    def _answer(self, mark: PointMark | MatteMark) -> None:
        """Set a mark, or answer what was asked with its thing."""
        take, self._thing_asked = self._thing_asked, None
        if take is None:
            self._add(mark)
        elif isinstance(mark, MatteMark):
            take(mark.matte)
        else:
            self._say("No Cryptomatte or channel of ids tells a thing there: type its matte.")

    def _add(self, mark: Mark) -> None:
        self.pull_to = mark.name
        self._editing.do(replace(self._editing.shot, marks=(*self._editing.shot.marks, mark)))
        self._say(f"Mark {mark.name} is set. Shift+M pulls the focus from mark to mark.")

    def track(self, mark: PointMark | TrackMark, point: PointMark) -> None:
        """Follow the surface at a point of this frame over all frames, and put a mark on it.

        For a mark that is tracked already this is a correction.
        """
        cache, frames = self._timeline.cache, self._timeline.frames
        if cache is None or frames is None:
            self._say("Only surfaces in a sequence of plates can be tracked.")
            return
        click = Click(self._editing.frame, point.x_px, point.y_px)
        new = (
            mark.corrected(click) if isinstance(mark, TrackMark) else TrackMark(mark.name, (click,))
        )
        self.tracking.start(mark, new, cache, frames)

    @property
    def has_world(self) -> bool:
        """True where the header of the loaded plate tells its camera."""
        plate = self._source.plate
        return plate is not None and plate.world_to_camera is not None

    def place(self, mark: PointMark) -> None:
        """Put the mark on the place in the world that is at its point now."""
        plate = self._source.plate
        with reported(self._say):
            if plate is not None:
                self.change(mark, world_mark(plate, mark, self._editing.lens))

    def correct(self, mark: TrackMark) -> None:
        """Let the next click that would set a mark tell where the surface is at its frame."""
        self.corrected = mark.name
        self._say(f"Ctrl+Shift+click where {mark.name} is at this frame.")

    def change(self, before: Mark, after: Mark) -> None:
        """Change the name or smoothing of a mark; raise HeatlensError if the name is in use."""
        marks = tuple(after if mark == before else mark for mark in self._editing.shot.marks)
        shot = self._editing.shot
        live = shot.curves.live and shot.curves.live.renamed(before.name, after.name)
        curves = replace(shot.curves, live=live)
        self._editing.do(replace(shot, marks=marks, curves=curves))
        self.pull_to = after.name if self.pull_to == before.name else self.pull_to
        self.pull_from = after.name if self.pull_from == before.name else self.pull_from

    def put(self, name: str, distance_m: float) -> None:
        """Move a distance mark, as part of the current gesture."""
        shot, named = self._editing.shot, self.named(name)
        if isinstance(named, DistanceMark):
            moved = replace(named, distance_m=distance_m)
            marks = tuple(moved if mark == named else mark for mark in shot.marks)
            self._editing.edit(replace(shot, marks=marks))

    def delete(self, mark: Mark) -> None:
        """Delete the mark, unless the focus follows it."""
        if self.live.live is not None and mark.name in self.live.live.marks:
            self._say(f"The focus follows {mark.name}: let it go, or make keys, to delete it.")
            return
        marks = tuple(other for other in self._editing.shot.marks if other != mark)
        self._editing.do(replace(self._editing.shot, marks=marks))

    def distance_m(self, mark: Mark, frame: int | None = None) -> float | None:
        """Return the distance of a mark in m, on the loaded plate or at another frame.

        Another frame must be of a scene or in memory; otherwise the loaded plate is used. Return
        None if the distance is unknown.
        """
        if isinstance(mark, ObjectMark):
            return self._scenes.object_m(mark.object_name, frame)
        known_m = mark.distance_at_m(self._editing.frame if frame is None else frame)
        if known_m is not None:
            return known_m
        cache, plate = self._timeline.cache, self._source.plate
        if isinstance(mark, PointMark) and self._source.has_camera:
            return self._in_scene_m(mark, frame)
        if frame is not None and cache is not None:
            found = cache.get(frame)
            plate = found if isinstance(found, Plate) else plate
        if isinstance(mark, MatteMark):
            return None if plate is None else self.things.distance_m(plate, mark)
        return mark_m(plate, mark)

    def _in_scene_m(self, mark: PointMark, frame: int | None) -> float | None:
        pixel = int(mark.x_px), int(mark.y_px)
        if frame is None or frame == self._editing.frame:
            x, y = self._source.feed.plate_px(self._editing.shot, pixel)
            return mark_m(self._source.plate, replace(mark, x_px=x, y_px=y))
        return self._scenes.point_m(*pixel, frame)

    def focus_m(self, mark: Mark, frame: int | None = None) -> float | None:
        """Return the focus distance with which a mark is sharp; None if it is unknown.

        It is not the distance of the mark where the plane of focus leans at the mark's point.
        """
        distance_m = self.distance_m(mark, frame)
        lens = self._editing.lens if frame is None else self._editing.shot.lens_at(frame)
        at = self._editing.frame if frame is None else frame
        return None if distance_m is None else self._sharp_m(mark, lens, at, distance_m)

    def _sharp_m(self, mark: Mark, lens: Lens, frame: int, distance_m: float) -> float:
        place = mark.place_at(frame) if isinstance(mark, TrackMark) else mark
        is_leaning = lens.tilt_deg or lens.split_dioptres
        if not (is_leaning and isinstance(place, PointMark | TrackPlace)):
            return distance_m
        shape = self._source.picture_shape(self._editing.shot)
        lean = lean_of(lens, (shape.width_px, shape.height_px), shape.pixel_aspect)
        return sharp_at(lens, lean, (place.x_px, place.y_px), distance_m).focus_distance_m

    def go(self, mark: Mark) -> None:
        """Focus on the mark."""
        with reported(self._say):
            distance_m = self._asked_m(mark, None)
            self._editing.settle()
            self._editing.edit_lens(replace(self._editing.lens, focus_distance_m=distance_m))
            self._editing.settle()

    def _asked_m(self, mark: Mark, frame: int | None) -> float:
        distance_m = self.focus_m(mark, frame)
        if distance_m is None:
            raise InputError(
                f"Mark {mark.name} has no distance here: it is hidden or outside the picture."
            )
        return distance_m

    # Focus pulls

    def named(self, name: str | None) -> Mark | None:
        """Return the mark with this name."""
        return next((mark for mark in self._editing.shot.marks if mark.name == name), None)

    def begin_pull(self) -> None:
        """Suggest a pull from the playhead to the next mark, as long as the last one if it fits."""
        left = self._last_frame - self._editing.frame
        self.pull_frames = int(min(self._wished_frames, left)) if left > 0 else self._wished_frames
        self.pull_to = self._next_mark().name

    def _next_mark(self) -> Mark:
        """Return the mark after the one in focus, or after the last one that was pulled to.

        After the last mark comes the first.
        """
        marks, lens = self._editing.shot.marks, self._editing.lens
        away = {
            abs(1.0 / far_m - 1.0 / lens.focus_distance_m): mark
            for mark in marks
            if (far_m := self.focus_m(mark)) is not None
        }
        nearest = min(away, default=inf)
        before = away[nearest] if nearest <= sharp_dioptres(lens) else self.named(self._pulled_to)
        return marks[(marks.index(before) + 1) % len(marks)] if before in marks else marks[0]

    def lengthen_pull(self, frames: int) -> None:
        """Set the number of frames of pulls from now on."""
        self.pull_frames = self._wished_frames = frames

    @property
    def _last_frame(self) -> float:
        """The last frame of the open source; None for a still."""
        timeline = self._timeline
        return timeline.frames.last if timeline.is_sequence and timeline.frames else inf

    @property
    def pull_past_end(self) -> str:
        """A sentence if the pull would end after the last frame; else ""."""
        last, end = self._last_frame, self._editing.frame + self.pull_frames
        if end <= last:
            return ""
        return f"The pull ends at frame {end}, but {last:g} is the last: the focus will not arrive."

    def pull(self) -> None:
        """Set keys for a pull from the playhead to the chosen mark."""
        target, origin = self.named(self.pull_to), self.named(self.pull_from)
        if target is None:
            self._say("Choose the mark to pull to.")
            return
        start = self._editing.frame
        if self.live.live is not None:
            self.live.pull_to(target, self.pull_frames)
            self.pulls_made += 1
            return
        with reported(self._say):
            from_m = self._editing.lens.focus_distance_m
            if origin is not None:
                from_m = self._asked_m(origin, start)
            to_m = self._asked_m(target, start + self.pull_frames)
            frames, ease = self.pull_frames, self.pull_ease_percent
            shape, shot = self.pull_shape, self._editing.shot
            self._editing.do(shaped_pull(shot, from_m, to_m, start, frames, shape, ease))
            self._pulled_to = target.name
            self.pulls_made += 1
            if self.pull_past_end:
                self._say(self.pull_past_end)

    def reverse_pull(self) -> None:
        """Reverse the focus in time between in and out point."""
        played = self._timeline.played
        self._do(lambda shot: reversed_focus(shot, played))

    def hold_focus(self) -> None:
        """Hold the current focus from the playhead to the next key."""
        frame = self._editing.frame
        self._do(lambda shot: held_focus(shot, frame))

    def follow(self, mark: Mark) -> None:
        """Keep the focus on a mark from in to out; read or draw frames that are not in memory."""
        frames = self._timeline.played
        if isinstance(mark, ObjectMark):
            self._scenes.follow(mark, frames)
            return
        if isinstance(mark, TrackMark):
            self._take(mark, {frame: mark.distance_at_m(frame) for frame in frames})
            return
        if isinstance(mark, PointMark):
            self._following = self._scenes.following(mark, frames)
        if self._following is not None:
            self._say(self._following.words)
        elif self._timeline.cache is not None:
            self._read(self._timeline.cache, mark, frames)
        else:
            self._say("Only points in a sequence or a scene can be followed.")

    def _read(self, cache: FrameCache, mark: Mark, frames: FrameRange) -> None:
        reads = sum(1 for frame in frames if not isinstance(cache.get(frame), Plate))
        if reads:
            self._say(f"Reading {reads} frames to follow {mark.name} ...")
        plates = plates_at(cache, reading_options(self._source), frames)
        self._reader.start(lambda: (mark, smoothed(mark, mark_over_plates_m(plates, mark), frames)))

    def _take(self, mark: Mark, distances_m: Distances) -> None:
        shot = self._editing.shot
        with reported(self._say):
            focus_m = {
                frame: far_m and self._sharp_m(mark, shot.lens_at(frame), frame, far_m)
                for frame, far_m in distances_m.items()
            }
            self._editing.do(followed(shot, focus_m))
            self._say(f"The focus follows {mark.name} from {min(distances_m)} on.")

    def _take_tracked(self, before: Mark, after: TrackMark) -> None:
        if before in self._editing.shot.marks:  # it was not deleted meanwhile
            self.change(before, after)
            seen = sum(place.distance_m is not None for place in after.places)
            doubts = f", {len(after.doubted)} of them to be looked at" if after.doubted else ""
            self._say(f"{after.name} is seen at {seen} of {len(after.places)} frames{doubts}.")

    def poll(self) -> None:
        """Apply finished measurements; call this once a frame."""
        with reported(self._say):
            found = self._reader.poll() or self._drawn()
            if found is not None:
                self._take(*found)
            picked = self._picker.poll()
            if picked is not None:
                self._answer(picked)

    def _drawn(self) -> _Measured | None:
        """Continue to measure through a scene; return the measurement once it is complete.

        Raise HeatlensError if a frame cannot be measured, which ends the measurement.
        """
        following, self._following = self._following, None
        if following is None:
            return None
        following.go_on()
        if following.is_done:
            mark, frames = following.mark, following.frames
            return mark, smoothed(mark, following.distances_m, frames)
        self._following = following
        self._say(following.words)
        self._wake()  # or the loop would sleep
        return None
