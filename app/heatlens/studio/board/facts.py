"""What is true of a session at one moment, in one frozen record for every front end."""

from dataclasses import dataclass
from functools import cached_property

from heatlens.core.base.errors import HeatlensError
from heatlens.core.base.messages import Messages
from heatlens.core.model.boxes import Box
from heatlens.core.model.curves.frames import FrameRange
from heatlens.core.model.focus.coc import far_limit_m, hyperfocal_m, near_limit_m
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.marks.mark import Mark
from heatlens.core.model.shot.pull import RecordingState
from heatlens.core.model.shot.shot import Shot
from heatlens.core.model.value_bins import DepthHistogram
from heatlens.core.model.view.view import ViewState
from heatlens.core.model.view.view_geometry import PictureShape, Pixel
from heatlens.media.plate.plate import Plate
from heatlens.render.preview.shown import ShownPicture
from heatlens.render.source.stream_source import StreamSource
from heatlens.studio.board.controls import FileControl, PictureControl, TimeControl
from heatlens.studio.session.marks.mark_distances import MarkDistances
from heatlens.studio.session.opened.open_source import OpenSource
from heatlens.studio.session.pictures.view_commands import Reference
from heatlens.studio.session.shot.editing import Editing


@dataclass(frozen=True)
class MarkState:
    """A mark with its distance at this frame; None where it is outside the picture."""

    name: str
    distance_m: float | None


# Panels, pages and other front ends all show these facts. Most are only references. What takes
# longer to compute, such as the distances of marks, is computed when it is asked for, and once.
@dataclass(frozen=True)
class Facts:
    """A session at one moment.

    shot              the current shot
    seen_shot         the shot of the picture: the current one, or one with trial values
    lens, has_lens    the lens at the playhead, and whether the keys give a possible one
    lens_number       a number that changes with the lens and the frame
    frame             the frame at the playhead
    view              exposure, zoom, overlay, comparison
    crop              the share of a plate that a longer lens would show, to frame; else None
    title             the name of the document, with a star for unsaved changes
    message           the sentence in the status bar, or ""
    is_problem        the message is about an error
    played            the frames that are played
    direction         1 while playing, -1 backwards, 0 at rest
    timecode          that of the frame; "" without one
    recording         the stage of the recording of a pull
    recorded_keys     the number of keys in a recorded pull
    beats_left        the number of the count-in before a pull is recorded: 3, 2, 1; 0 without one
    opening           the name of the source that is being opened; "" for none
    has_camera        a camera that can move is open
    has_many_views    the open source can be seen from many points of the lens
    is_black          the frame has no file and is shown black
    is_waiting        a stream waits for its first picture
    stream            the renderer that sends pictures; None without one
    plate             the picture before the blur; None while there is none
    histogram         that of the distances in the plate; None if it has none
    plate_version     a number that changes with the plate
    shape             the shape of the display window; one pixel while nothing is open
    shown_picture     the picture through the lens to show; None before the first
    picture           a number that changes with the pictures
    plays_cached_frames cached frames play, in place of the live picture
    is_live_alone     the live picture is shown, with nothing beside or over it
    is_rendering      a visible picture is not complete
    part_done         how much of the picture is rendered, 0 to 1; None once it is complete
    reference         the picture to show as B; None without one
    """

    shot: Shot
    seen_shot: Shot
    lens: Lens
    has_lens: bool
    lens_number: int
    frame: int
    view: ViewState
    crop: float | None
    title: str
    message: str
    is_problem: bool
    played: FrameRange
    direction: int
    timecode: str
    recording: RecordingState
    recorded_keys: int
    beats_left: int
    opening: str
    has_camera: bool
    has_many_views: bool
    is_black: bool
    is_waiting: bool
    stream: StreamSource | None
    plate: Plate | None
    histogram: DepthHistogram | None
    plate_version: int
    shape: PictureShape
    shown_picture: ShownPicture | None
    picture: int
    plays_cached_frames: bool
    is_live_alone: bool
    is_rendering: bool
    part_done: float | None
    reference: Reference | None
    _source: OpenSource
    _distances: MarkDistances

    @property
    def unit(self) -> str:
        """The unit of displayed distances, "m" or "ft"."""
        return self.view.unit

    @property
    def is_whole(self) -> bool:
        """True if the shown picture is complete, no preview."""
        picture = self.shown_picture
        return picture is not None and picture.is_whole and not self.is_rendering

    @property
    def shows_lens(self) -> bool:
        """True if the shown picture is of this lens and frame; a look has a lens of its own."""
        picture = self.shown_picture
        if picture is None or self.plays_cached_frames or self.view.a_look:
            return picture is not None
        return picture.frame == self.frame and picture.shot.lens_at(picture.frame) == self.lens

    @property
    def size_px(self) -> tuple[int, int] | None:
        """Width and height of the shown picture; None before the first."""
        return None if self.shown_picture is None else self.shown_picture.texture.size

    # The lens

    @cached_property
    def near_m(self) -> float | None:
        """The near limit of the sharp range; None without a possible lens."""
        return near_limit_m(self.lens) if self.has_lens else None

    @cached_property
    def far_m(self) -> float | None:
        """The far limit of the sharp range; None without a possible lens."""
        return far_limit_m(self.lens) if self.has_lens else None

    @cached_property
    def hyperfocal_m(self) -> float | None:
        """The hyperfocal distance; None where the keys give no possible lens."""
        try:
            return hyperfocal_m(self.lens)
        except HeatlensError:  # between two keys, the lens may be impossible
            return None

    @cached_property
    def keyed_focus_m(self) -> float | None:
        """The focus of the keys in m, where the lens has another one: tried or performed."""
        curves = self.shot.curves
        if curves.live is not None or not (curves.focus_distance_m.keys and self.has_lens):
            return None
        keyed_m = curves.focus_distance_m.value_at(self.frame)
        return None if keyed_m == self.lens.focus_distance_m else keyed_m

    # Marks

    @cached_property
    def mark_distances_m(self) -> tuple[tuple[Mark, float | None], ...]:
        """The marks with their distances at this frame in m, None where one is not seen."""
        return tuple((mark, self._distances.distance_m(mark)) for mark in self.shot.marks)

    @cached_property
    def marks(self) -> tuple[MarkState, ...]:
        """The marks' names with their distances at this frame in m, None where one is not seen."""
        return tuple(MarkState(mark.name, at_m) for mark, at_m in self.mark_distances_m)

    @cached_property
    def marks_m(self) -> tuple[tuple[str, float], ...]:
        """Names of the marks that are seen at this frame, and the focus in m that is on them."""
        focuses = [(mark.name, self._distances.focus_m(mark)) for mark in self.shot.marks]
        return tuple((name, focus_m) for name, focus_m in focuses if focus_m is not None)

    # Places in the picture

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


class FactsReader:
    """Reads the facts of a session."""

    def __init__(
        self,
        source: OpenSource,
        editing: Editing,
        pictures: PictureControl,
        time: TimeControl,
        files: FileControl,
        messages: Messages,
    ) -> None:
        self._source, self._editing, self._pictures = source, editing, pictures
        self._time, self._files, self._messages = time, files, messages
        self._picture, self._lens_number = _Count(), _Count()

    def read(self) -> Facts:
        """Return the facts of this moment."""
        source, editing, pictures, time = self._source, self._editing, self._pictures, self._time
        plays_cached = time.frames_ahead.plays_cached_frames
        return Facts(
            shot=editing.shot,
            seen_shot=editing.seen_shot,
            lens=editing.lens,
            has_lens=editing.has_lens,
            lens_number=self._lens_number.of((editing.lens, editing.frame)),
            frame=editing.frame,
            view=pictures.view.state,
            crop=time.scenes.size.crop,
            title=self._files.window_title,
            message=self._messages.text,
            is_problem=self._messages.is_problem,
            played=time.timeline.played,
            direction=time.timeline.playback.direction,
            timecode=time.timeline.timecode,
            recording=time.recording.state,
            recorded_keys=time.recording.key_count,
            beats_left=time.recording.beats_left,
            opening=source.opener.opening or "",
            has_camera=source.has_camera,
            has_many_views=pictures.renderer.has_many_views,
            is_black=source.picture.is_black,
            is_waiting=source.is_waiting,
            stream=source.stream,
            plate=source.plate,
            histogram=source.picture.histogram,
            plate_version=source.picture.version,
            shape=source.picture_shape(editing.shot),
            shown_picture=time.scheduler.shown_picture,
            picture=self._picture.of(time.scheduler.picture_key),
            plays_cached_frames=plays_cached,
            is_live_alone=pictures.view.is_lens_alone and not plays_cached,
            is_rendering=time.scheduler.is_rendering,
            part_done=None if plays_cached else pictures.live.rendered_share,
            reference=pictures.references.current,
            _source=source,
            _distances=time.marks.distances,
        )


class _Count:
    """Counts the changes of a value."""

    def __init__(self) -> None:
        self._number, self._value = 0, object()

    def of(self, value: object) -> int:
        """Return a number that grows whenever the value is another one."""
        self._number += value != self._value
        self._value = value
        return self._number
