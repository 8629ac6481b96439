"""What marks on plates hold on to over the frames: a place in the world, a surface, or a pixel."""

from collections.abc import Callable, Iterator
from dataclasses import replace

from heatlens.core.base.errors import InputError
from heatlens.core.base.messages import report_errors
from heatlens.core.model.marks.mark import Mark
from heatlens.core.model.marks.marks import MarkAnchor, PointMark, WorldMark
from heatlens.core.model.marks.track_mark import Click, TrackMark
from heatlens.core.model.shot.shot import Shot
from heatlens.media.plate.mark_distance import make_world_mark, stands_still, world_point
from heatlens.media.plate.plate import Plate
from heatlens.studio.session.marks.surface_tracking import SurfaceTracking
from heatlens.studio.session.shared import Commands, Shared
from heatlens.studio.session.time.timeline import Timeline


class MarkAnchors(Commands):
    """Chooses what a mark holds on to, and changes it; a change is one undo step."""

    def __init__(
        self, shared: Shared, timeline: Timeline, change: Callable[[Mark, Mark], None]
    ) -> None:
        """Create it; `change` replaces a mark of the shot by another one."""
        super().__init__(shared)
        self._timeline, self._change = timeline, change
        self.tracking = SurfaceTracking(shared, timeline)
        self.corrected_name: str | None = None  # the tracked mark that the next click corrects

    def is_playhead_shown(self) -> bool:
        """Return True if the picture is that of the playhead's frame; report it otherwise."""
        frame, picture = self._editing.frame, self._source.picture
        is_shown = self._source.is_settled_at(frame) and not (picture.problem or picture.is_black)
        if not is_shown:
            self._notify(
                picture.problem or f"Frame {frame} is not shown yet: try again when it is."
            )
        return is_shown

    def best_anchor(self, point: PointMark) -> PointMark | WorldMark:
        """Return a mark on the place in the world at a point if it stands still, else the point.

        It is compared with the frames in memory, so that nothing has to be read.
        """
        plate, lens = self._source.plate, self._editing.lens
        if plate is None or plate.world_to_camera is None or self._source.has_camera:
            return point
        try:
            mark = make_world_mark(plate, point, lens)
        except InputError:  # the sky has no place
            return point
        return mark if stands_still(self._plates_in_memory(), mark, lens) else point

    def _plates_in_memory(self) -> Iterator[Plate]:
        """Yield the plates of the sequence that are in the cache."""
        cache, frames = self._timeline.cache, self._timeline.frames
        for frame in () if cache is None or frames is None else frames:
            if cache is not None and isinstance(plate := cache.get(frame), Plate):
                yield plate

    def anchor_to(self, mark: Mark, anchor: MarkAnchor) -> None:
        """Let the mark hold on to something else that is where it is at this frame."""
        point = self._point_of(mark)
        if point is None:
            self._notify(
                f"{mark.name} is not in the picture at this frame: go to one that shows it."
            )
        elif anchor is MarkAnchor.SURFACE:
            self.track(mark, point)
        elif anchor is MarkAnchor.PLACE:
            self.fix_in_world(mark, point)
        elif self.is_playhead_shown():
            self._change(mark, point)

    def _point_of(self, mark: Mark) -> PointMark | None:
        """Return the point of the picture at which a mark is at this frame; None without one."""
        if isinstance(mark, PointMark):
            return mark
        if isinstance(mark, TrackMark):
            point = mark.point_at(self._editing.frame)
            return PointMark(mark.name, point.x_px, point.y_px) if point is not None else None
        plate = self._source.plate
        if isinstance(mark, WorldMark) and plate is not None and self.is_playhead_shown():
            return world_point(plate, mark, self._editing.lens)
        return None

    def track(self, mark: Mark, point: PointMark) -> None:
        """Follow the surface at a point of this frame over all frames, and put a mark on it.

        For a mark that is tracked already this is a correction. Notifies the user.
        """
        if self._timeline.cache is None:
            self._notify("Only surfaces in a sequence of plates can be tracked.")
        elif self.is_playhead_shown():
            click = Click(self._editing.frame, point.x_px, point.y_px)
            new_mark = TrackMark(mark.name, (click,))
            track_mark = mark.add_click(click) if isinstance(mark, TrackMark) else new_mark
            self.tracking.start(mark, track_mark, self._replace_by_tracked)

    def follow_new(self, mark: Mark, frame: int) -> bool:
        """Follow the surface under a new mark that was clicked on at a frame; part of its step.

        Return False for a mark that has another hold, and where there are no frames to follow it.
        """
        frames = self._timeline.frames
        if not isinstance(mark, PointMark) or self._timeline.cache is None or frames is None:
            return False
        if frames.count > 1:
            click = Click(frame, mark.x_px, mark.y_px)
            self.tracking.start(mark, TrackMark(mark.name, (click,)), self._hold_new)
        return frames.count > 1

    @property
    def has_world(self) -> bool:
        """True if the header of the loaded plate has its camera."""
        plate = self._source.plate
        return plate is not None and plate.world_to_camera is not None

    def fix_in_world(self, mark: Mark, point: PointMark) -> None:
        """Fix the mark to the world position that is at a point now."""
        plate = self._source.plate
        with report_errors(self._notify):
            if plate is not None and self.is_playhead_shown():
                self._change(mark, make_world_mark(plate, point, self._editing.lens))

    def correct(self, mark: TrackMark) -> None:
        """Let the next click that would set a mark correct where the surface is at that frame."""
        self.corrected_name = mark.name
        self._notify(f"Ctrl+Shift+click where {mark.name} is at this frame.")

    def _replace_by_tracked(self, marks: tuple[Mark, ...], tracked_mark: TrackMark) -> None:
        """Replace a mark by its tracked one as an undo step, and report where it is visible."""
        mark = replace(tracked_mark, name=marks[-1].name)
        self._change(marks[-1], mark)
        self._notify(_seen_words(mark))

    def _hold_new(self, marks: tuple[Mark, ...], tracked_mark: TrackMark) -> None:
        """Let a new mark hold on to its surface, in all steps of undo that have the mark."""
        name = marks[-1].name
        if _seen_count(tracked_mark) < 2:
            self._notify(f"{name} is found at its own frame alone: it stays on the pixel.")
            return
        tracked_marks = {mark: replace(tracked_mark, name=mark.name) for mark in marks}

        def hold(shot: Shot) -> Shot:
            return replace(shot, marks=tuple(tracked_marks.get(it, it) for it in shot.marks))

        self._editing.amend(hold)
        self._notify(_seen_words(replace(tracked_mark, name=name)))


def _seen_count(mark: TrackMark) -> int:
    """Return the number of frames at which a tracked surface is visible."""
    return sum(place.distance_m is not None for place in mark.places)


def _seen_words(mark: TrackMark) -> str:
    """Return at how many frames a tracked surface is visible, and how many are doubtful."""
    doubtful_count = len(mark.doubtful_frames)
    doubt_note = f", {doubtful_count} of them to be looked at" if doubtful_count else ""
    return (
        f"{mark.name} holds on to the surface, seen at {_seen_count(mark)} of {len(mark.places)} "
        f"frames{doubt_note}."
    )
