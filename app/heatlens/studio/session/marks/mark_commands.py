"""The commands on focus marks: set them, focus on them, pull to them, follow them."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial

from heatlens.core.base.background import Background
from heatlens.core.model.curves.frames import FrameRange
from heatlens.core.model.focus.live_focus import Distances
from heatlens.core.model.marks.mark import Mark, free_letter
from heatlens.core.model.marks.marks import (
    DistanceMark,
    MatteMark,
    ObjectMark,
    PointMark,
)
from heatlens.core.model.marks.track_mark import Click, TrackMark
from heatlens.core.model.shot.pull import (
    followed,
)
from heatlens.media.frame_cache.cache import FrameCache
from heatlens.media.plate.coc_line import surfaces_at
from heatlens.media.plate.mark_distance import mark_over_plates_m, world_mark
from heatlens.media.plate.mattes.mattes import has_things
from heatlens.media.plate.plate import Plate
from heatlens.studio.session.marks.focus_pulls import FocusPulls
from heatlens.studio.session.marks.live_following import LiveFollowing
from heatlens.studio.session.marks.mark_distances import MarkDistances, plates_at, reading_options
from heatlens.studio.session.marks.mark_measuring import SurfaceTracking, on_thing, smoothed
from heatlens.studio.session.messages import Worker, reported
from heatlens.studio.session.scenes.following import Following
from heatlens.studio.session.scenes.scene_commands import SceneCommands
from heatlens.studio.session.shared import Commands, Shared
from heatlens.studio.session.time.focus_track import ThingDistances
from heatlens.studio.session.time.timeline import Timeline

_Measured = tuple[Mark, Distances]


class MarkCommands(Commands, Worker):
    """The commands on focus marks; each is one undo step."""

    def __init__(self, shared: Shared, timeline: Timeline, scenes: SceneCommands) -> None:
        super().__init__(shared)
        self._timeline = timeline
        self._scenes = scenes
        self._following: Following | None = None  # the measurement in progress, in a scene
        self._reader: Background[_Measured] = Background(self._wake)
        self._picker: Background[PointMark | MatteMark] = Background(self._wake)
        self.tracking = SurfaceTracking(shared, self._take_tracked)
        self.corrected: str | None = None  # the tracked mark that the next click corrects
        self._thing_asked: Callable[[str], None] | None = None  # takes the matte of the next click
        self.things = ThingDistances(self._wake)
        self.live = LiveFollowing(shared)
        self.distances = MarkDistances(shared, timeline, scenes, self.things)
        self.pulls = FocusPulls(shared, timeline, self.distances, self.live)
        self.workers: tuple[Worker, ...] = (
            self,
            self.things,
            self.tracking,
            self.live,
            self.distances,
        )

    @property
    def is_reading(self) -> bool:
        """True while frames are read or drawn to follow a mark."""
        return self._reader.is_busy or self.tracking.is_busy or self._following is not None

    # One mark

    def set_here(self) -> None:
        """Set a mark at the distance in focus."""
        marks, distance_m = self._editing.shot.marks, self._editing.lens.focus_distance_m
        self._add(DistanceMark(free_letter(mark.name for mark in marks), distance_m))

    def set_point(self, pixel: tuple[int, int]) -> None:
        """Set a mark at a pixel of the display window: on the thing there, else on the point.

        After `pick_thing` or `correct` it answers that instead. A plate with mattes of things is
        read again for that, on a thread.
        """
        plate = self._source.plate
        if plate is None or not self._shows_the_playhead():
            return
        pixel = self._source.frame_px(self._editing.lens, pixel)
        with reported(self._say):
            plate_px = self._source.feed.plate_px(self._editing.shot, pixel)
            surface = surfaces_at(plate, self._editing.lens, *plate_px)[0]
            pixel = pixel if self._source.has_camera else (surface.x, surface.y)
            name = free_letter(mark.name for mark in self._editing.shot.marks)
            point = PointMark(name, float(pixel[0]), float(pixel[1]))
            corrected, self.corrected = self._editing.shot.mark_named(self.corrected), None
            if isinstance(corrected, TrackMark):
                self.track(corrected, point)
            elif self._thing_asked is not None and not has_things(plate):
                self._answer(point)
            elif has_things(plate):
                self._picker.start(lambda: on_thing(plate, point))
            else:
                self._add(point)

    def _shows_the_playhead(self) -> bool:
        """Return True if the picture is that of the playhead's frame; else say that it is not."""
        frame, picture = self._editing.frame, self._source.picture
        is_shown = self._source.is_settled_at(frame) and not (picture.problem or picture.is_black)
        if not is_shown:
            self._say(picture.problem or f"Frame {frame} is not shown yet: try again when it is.")
        return is_shown

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
        self.pulls.target = mark.name
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
        if not self._shows_the_playhead():
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
            if plate is not None and self._shows_the_playhead():
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
        self.pulls.renamed(before.name, after.name)

    def put(self, name: str, distance_m: float) -> None:
        """Move a distance mark, as part of the current gesture."""
        shot, named = self._editing.shot, self._editing.shot.mark_named(name)
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

    def go(self, mark: Mark) -> None:
        """Focus on the mark where it is at the playhead, once that frame is read."""
        frame = self._editing.frame

        def focus(focus_m: tuple[float, ...]) -> None:
            if self._editing.frame == frame:  # the playhead has not gone on meanwhile
                self._editing.choose_lens(replace(self._editing.lens, focus_distance_m=focus_m[0]))

        self.distances.ask(((mark, frame),), focus)

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
                frame: far_m and self.distances.sharp_m(mark, shot.lens_at(frame), frame, far_m)
                for frame, far_m in distances_m.items()
            }
            self._editing.do(followed(shot, focus_m))
            self._say(f"The focus follows {mark.name} from {min(distances_m)} on.")

    def _take_tracked(self, before: Mark, after: TrackMark) -> None:
        if before in self._editing.shot.marks:  # it was not deleted meanwhile
            self.change(before, after)
            visible = sum(place.distance_m is not None for place in after.places)
            doubts = f", {len(after.doubted)} of them to be looked at" if after.doubted else ""
            self._say(f"{after.name} is seen at {visible} of {len(after.places)} frames{doubts}.")

    def poll(self) -> None:
        """Apply finished measurements; call this once a frame."""
        with reported(self._say):
            if (marked := self._reader.poll() or self._drawn()) is not None:
                self._take(*marked)
            if (picked := self._picker.poll()) is not None:
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
