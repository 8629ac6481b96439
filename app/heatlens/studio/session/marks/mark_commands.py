"""The commands on focus marks: set them, focus on them, pull to them, follow them."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial

from heatlens.core.base.background import Background
from heatlens.core.base.messages import Worker, report_errors
from heatlens.core.model.curves.frames import FrameRange
from heatlens.core.model.focus.live_focus import Distances
from heatlens.core.model.marks.mark import Mark, free_letter
from heatlens.core.model.marks.marks import (
    DistanceMark,
    MarkAnchor,
    MatteMark,
    ObjectMark,
    PointMark,
)
from heatlens.core.model.marks.track_mark import TrackMark
from heatlens.core.model.shot.pull import focus_on_distances
from heatlens.media.frame_cache.cache import FrameCache
from heatlens.media.plate.coc_line import surfaces_at
from heatlens.media.plate.mark_distance import (
    mark_distances_m,
)
from heatlens.media.plate.mattes.mattes import has_things
from heatlens.media.plate.plate import Plate
from heatlens.studio.session.marks.focus_pulls import FocusPulls
from heatlens.studio.session.marks.live_following import LiveFollowing
from heatlens.studio.session.marks.mark_anchors import MarkAnchors
from heatlens.studio.session.marks.mark_distances import MarkDistances, plates_at, reading_options
from heatlens.studio.session.marks.mark_measuring import (
    mark_on_object,
    named_after_thing,
    smooth_distances,
)
from heatlens.studio.session.marks.matte_light import MatteLight
from heatlens.studio.session.scenes.following import PointMeasurement
from heatlens.studio.session.scenes.scene_commands import SceneCommands
from heatlens.studio.session.shared import Commands, Shared
from heatlens.studio.session.time.focus_track import MatteDistances
from heatlens.studio.session.time.timeline import Timeline

_Measured = tuple[Mark, Distances]


class MarkCommands(Commands, Worker):
    """The commands on focus marks; each is one undo step."""

    def __init__(self, shared: Shared, timeline: Timeline, scenes: SceneCommands) -> None:
        super().__init__(shared)
        self._timeline = timeline
        self._scenes = scenes
        self._scene_measurement: PointMeasurement | None = (
            None  # the measurement in progress, in a scene
        )
        self._reader: Background[_Measured] = Background(self._wake)
        self._picker: Background[PointMark | MatteMark] = Background(self._wake)
        self.anchors = MarkAnchors(shared, timeline, self.change)
        self._clicked_frame = 0  # the frame of the latest click
        self._matte_receiver: Callable[[str], None] | None = None  # is given the next clicked matte
        self.matte_distances = MatteDistances(self._wake)
        self.live = LiveFollowing(shared)
        self.light = MatteLight(shared)
        self.distances = MarkDistances(
            *(shared, timeline, scenes, self.matte_distances), self.anchors.tracking.is_awaited
        )
        self.pulls = FocusPulls(shared, timeline, self.distances, self.live)
        self.workers: tuple[Worker, ...] = (
            self,
            self.matte_distances,
            self.anchors.tracking,
            self.live,
            self.light,
            self.distances,
        )

    @property
    def is_reading(self) -> bool:
        """True while frames are read or drawn to follow a mark."""
        return self._reader.is_busy or self._scene_measurement is not None

    # One mark

    def set_here(self) -> None:
        """Set a mark at the distance in focus."""
        marks, distance_m = self._editing.shot.marks, self._editing.lens.focus_distance_m
        self._add(DistanceMark(free_letter(mark.name for mark in marks), distance_m))

    def set_point(self, pixel: tuple[int, int]) -> None:
        """Set a mark at a pixel of the display window: on the object there, else on the point.

        After `pick_matte`, the click chooses a matte instead; after `correct`, it corrects a
        tracked mark. A thread finds the object if the plate has mattes.
        """
        plate = self._source.plate
        if plate is None or not self.anchors.is_playhead_shown():
            return
        self._clicked_frame = self._editing.frame
        pixel = self._source.frame_px(self._editing.lens, pixel)
        with report_errors(self._notify):
            plate_px = self._source.feed.plate_px(self._editing.shot, pixel)
            surface = surfaces_at(plate, self._editing.lens, *plate_px)[0]
            pixel = pixel if self._source.has_camera else (surface.x, surface.y)
            name = free_letter(mark.name for mark in self._editing.shot.marks)
            point = PointMark(name, float(pixel[0]), float(pixel[1]))
            corrected = self._editing.shot.mark_named(self.anchors.corrected_name)
            self.anchors.corrected_name = None
            if isinstance(corrected, TrackMark):
                self.anchors.track(corrected, point)
            elif self._matte_receiver is not None and not has_things(plate):
                self._use_picked(point)
            elif has_things(plate):
                self._picker.start(lambda: mark_on_object(plate, point))
            else:
                self._add(self.anchors.best_anchor(point))

    def pick_matte(self, receive: Callable[[str, str], None], field: str) -> None:
        """Let the next click that would set a mark choose the matte of the option `field`."""
        self._matte_receiver = partial(receive, field)
        self._notify("Ctrl+Shift+click on the thing.")

    def _use_picked(self, mark: PointMark | MatteMark) -> None:
        """Set a mark, or give its matte to the option that waits for one, and notify the user."""
        receive, self._matte_receiver = self._matte_receiver, None
        if receive is None:
            used_names = [other.name for other in self._editing.shot.marks]
            if isinstance(mark, MatteMark):
                self._add(named_after_thing(mark, used_names))
            else:
                self._add(self.anchors.best_anchor(mark))
        elif isinstance(mark, MatteMark):
            receive(mark.matte)
        else:
            self._notify("Nothing with a matte is there: type the name of a matte.")

    def _add(self, mark: Mark) -> None:
        """Add a mark to the shot, and make it the target of the next pull, and notify the user."""
        self.pulls.note_new_mark(mark.name)
        self.light.flash(mark.name)
        self._editing.do(replace(self._editing.shot, marks=(*self._editing.shot.marks, mark)))
        anchor = MarkAnchor.of(mark)
        held_words = "" if anchor is None else f" on the {anchor}"
        hint = "Shift+M pulls the focus from mark to mark."
        if self.anchors.follow_new(mark, self._clicked_frame):
            hint = "Other frames are read to follow the surface there; Stop keeps the pixel."
        self._notify(f"Mark {mark.name} is set{held_words}. {hint}")

    def change(self, old_mark: Mark, new_mark: Mark) -> None:
        """Change the name or smoothing of a mark; raise HeatlensError if the name is in use."""
        marks = tuple(new_mark if mark == old_mark else mark for mark in self._editing.shot.marks)
        shot = self._editing.shot
        live = shot.curves.live and shot.curves.live.rename_mark(old_mark.name, new_mark.name)
        curves = replace(shot.curves, live=live)
        self._editing.do(replace(shot, marks=marks, curves=curves))
        self.pulls.rename_mark(old_mark.name, new_mark.name)
        self.anchors.tracking.note_change(old_mark, new_mark)

    def move_distance(self, name: str, distance_m: float) -> None:
        """Move a distance mark, as part of the current gesture."""
        shot, old_mark = self._editing.shot, self._editing.shot.mark_named(name)
        if isinstance(old_mark, DistanceMark):
            moved_mark = replace(old_mark, distance_m=distance_m)
            marks = tuple(moved_mark if mark == old_mark else mark for mark in shot.marks)
            self._editing.edit(replace(shot, marks=marks))

    def delete(self, mark: Mark) -> None:
        """Delete the mark, unless the focus follows it, and notify the user."""
        if self.live.live is not None and mark.name in self.live.live.marks:
            self._notify(f"The focus follows {mark.name}: let it go, or make keys, to delete it.")
            return
        marks = tuple(kept_mark for kept_mark in self._editing.shot.marks if kept_mark != mark)
        self._editing.do(replace(self._editing.shot, marks=marks))

    def focus_on(self, mark: Mark) -> None:
        """Focus on the mark where it is at the playhead, once that frame is read."""
        frame = self._editing.frame

        def focus(focus_m: tuple[float, ...]) -> None:
            if self._editing.frame == frame:  # the playhead has not gone on meanwhile
                self._editing.choose_lens(replace(self._editing.lens, focus_distance_m=focus_m[0]))

        self.distances.request(((mark, frame),), focus)

    def follow(self, mark: Mark) -> None:
        """Keep the focus on a mark from in to out; read or draw frames that are not in memory."""
        frames = self._timeline.played
        if isinstance(mark, ObjectMark):
            self._scenes.follow(mark, frames)
            return
        if isinstance(mark, TrackMark):
            self._set_focus_keys(mark, {frame: mark.distance_at_m(frame) for frame in frames})
            return
        if isinstance(mark, PointMark):
            self._scene_measurement = self._scenes.measure_point(mark, frames)
        if self._scene_measurement is not None:
            self._notify(self._scene_measurement.words)
        elif self._timeline.cache is not None:
            self._measure_plates(self._timeline.cache, mark, frames)
        else:
            self._notify("Only points in a sequence or a scene can be followed.")

    def _measure_plates(self, cache: FrameCache, mark: Mark, frames: FrameRange) -> None:
        """Measure a mark over the plates of some frames, on a thread, and notify the user."""
        read_count = sum(1 for frame in frames if not isinstance(cache.get(frame), Plate))
        if read_count:
            self._notify(f"Reading {read_count} frames to follow {mark.name} ...")
        plates = plates_at(cache, reading_options(self._source), frames)
        self._reader.start(
            lambda: (mark, smooth_distances(mark, mark_distances_m(plates, mark), frames))
        )

    def _set_focus_keys(self, mark: Mark, distances_m: Distances) -> None:
        """Set keys that focus on a mark at its measured distance at each frame."""
        shot = self._editing.shot
        with report_errors(self._notify):
            focus_m = {
                frame: distance_m
                and self.distances.focus_for_distance_m(
                    mark, shot.lens_at(frame), frame, distance_m
                )
                for frame, distance_m in distances_m.items()
            }
            self._editing.do(focus_on_distances(shot, focus_m))
            self._notify(f"The focus follows {mark.name} from {min(distances_m)} on.")

    def poll(self) -> None:
        """Apply finished measurements; call this once a frame."""
        with report_errors(self._notify):
            if (measurement := self._reader.poll() or self._continue_in_scene()) is not None:
                self._set_focus_keys(*measurement)
            if (picked_mark := self._picker.poll()) is not None:
                self._use_picked(picked_mark)

    def _continue_in_scene(self) -> _Measured | None:
        """Continue to measure through a scene; return the measurement once it is complete.

        Raise HeatlensError if a frame cannot be measured, which ends the measurement.
        """
        measurement, self._scene_measurement = self._scene_measurement, None
        if measurement is None:
            return None
        measurement.measure_slice()
        if measurement.is_done:
            mark, frames = measurement.mark, measurement.frames
            return mark, smooth_distances(mark, measurement.distances_m, frames)
        self._scene_measurement = measurement
        self._notify(measurement.words)
        self._wake()  # or the loop would sleep
        return None
