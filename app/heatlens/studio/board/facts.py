"""The current facts of a session, for panels and other front ends."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Generic, TypeVar

from heatlens.core.base.messages import Messages
from heatlens.core.model.boxes import Box
from heatlens.core.model.marks.mark import Mark
from heatlens.core.model.view.view_geometry import Pixel
from heatlens.studio.board.controls import FileControl, PictureControl, TimeControl
from heatlens.studio.session.opened.open_source import OpenSource
from heatlens.studio.session.shot.editing import Editing

Value = TypeVar("Value")


class _Fact(Generic[Value]):
    """A property of `Facts` whose value a function reads from the session."""

    def __init__(self, read: Callable[["Facts"], Value]) -> None:
        self._read = read

    def __get__(self, facts: "Facts", _kind: object) -> Value:
        return self._read(facts)


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
    _pictures: PictureControl
    _time: TimeControl
    _files: FileControl
    _messages: Messages

    shot = _Fact(lambda facts: facts._editing.shot)
    seen_shot = _Fact(lambda facts: facts._editing.seen_shot)
    lens = _Fact(lambda facts: facts._editing.lens)
    has_lens = _Fact(lambda facts: facts._editing.has_lens)
    frame = _Fact(lambda facts: facts._editing.frame)
    view = _Fact(lambda facts: facts._pictures.view.state)
    unit = _Fact(lambda facts: facts.view.unit)
    crop = _Fact(lambda facts: facts._time.scenes.size.crop)
    beats_left = _Fact(lambda facts: facts._time.recording.beats_left)

    # The document, and the sentence in the status bar, or "".
    title = _Fact(lambda facts: facts._files.documents.window_title)
    message = _Fact(lambda facts: facts._messages.text)
    is_problem = _Fact(lambda facts: facts._messages.is_problem)

    # The frames that are played, the direction (1, -1 backwards, 0 at rest), the timecode or None.
    played = _Fact(lambda facts: facts._time.timeline.played)
    direction = _Fact(lambda facts: facts._time.timeline.playback.direction)
    timecode = _Fact(lambda facts: facts._time.timeline.timecode)
    # The stage of the recording of a pull, and the number of its keys.
    recording = _Fact(lambda facts: facts._time.recording.state)
    recorded_keys = _Fact(lambda facts: facts._time.recording.key_count)

    # What is open: a camera that can move, a lens with many points to look from, a frame that has
    # no file and is shown black, a stream that waits for its first picture.
    opening = _Fact(lambda facts: facts._source.opener.opening or "")  # its name; "" for none
    has_camera = _Fact(lambda facts: facts._source.has_camera)
    has_many_views = _Fact(lambda facts: facts._pictures.renderer.has_many_views)
    is_black = _Fact(lambda facts: facts._source.picture.is_black)
    is_waiting = _Fact(lambda facts: facts._source.is_waiting)
    stream = _Fact(lambda facts: facts._source.stream)  # the renderer that sends pictures, or None

    # The picture before the blur (None while there is none), a number that changes with it, and
    # the histogram of its distances (None if it has none).
    plate = _Fact(lambda facts: facts._source.plate)
    plate_version = _Fact(lambda facts: facts._source.picture.version)
    histogram = _Fact(lambda facts: facts._source.picture.histogram)
    # The shape of the display window; one pixel while nothing is open.
    shape = _Fact(lambda facts: facts._source.picture_shape(facts.shot))

    # The picture through the lens: the one to show, whether it is the live one alone or kept frames
    # play, and how much of it is rendered, 0 to 1; None once it is complete.
    shown_picture = _Fact(lambda facts: facts._time.scheduler.shown_picture)
    plays_cached_frames = _Fact(lambda facts: facts._time.frames_ahead.plays_cached_frames)
    is_live_alone = _Fact(
        lambda facts: facts._pictures.view.is_lens_alone and not facts.plays_cached_frames
    )
    part_done = _Fact(
        lambda facts: None if facts.plays_cached_frames else facts._pictures.live.rendered_share
    )
    is_whole = _Fact(
        lambda facts: (
            facts.shown_picture is not None
            and facts.shown_picture.is_whole
            and not facts._time.scheduler.is_rendering
        )
    )
    # The picture to show as B, or None.
    reference = _Fact(lambda facts: facts._pictures.references.current)

    @property
    def mark_distances_m(self) -> tuple[tuple[Mark, float | None], ...]:
        """The marks with their distances at this frame in m, None where one is not seen."""
        distances = self._time.marks.distances
        return tuple((mark, distances.distance_m(mark)) for mark in self.shot.marks)

    @property
    def marks_m(self) -> tuple[tuple[str, float], ...]:
        """Names of the marks that are seen at this frame, and the focus in m that is on them."""
        marks = self._time.marks
        mark_focuses = [(mark.name, marks.distances.focus_m(mark)) for mark in self.shot.marks]
        return tuple(
            (name, distance_m) for name, distance_m in mark_focuses if distance_m is not None
        )

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
