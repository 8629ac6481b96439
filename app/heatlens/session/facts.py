"""The current facts of a session, for panels and other front ends."""

from heatlens.model.boxes import Box
from heatlens.model.depth_histogram import DepthHistogram
from heatlens.model.lens import Lens
from heatlens.model.shot import Shot
from heatlens.model.view import ViewState
from heatlens.model.view_geometry import PictureShape
from heatlens.plate.plate import Plate
from heatlens.preview.shown import Shown
from heatlens.session.desks import PictureDesk, TimeDesk
from heatlens.session.opened.open_source import OpenSource
from heatlens.session.pictures.reference import Reference
from heatlens.session.pictures.ruler import Pixel
from heatlens.session.shot.editing import Editing
from heatlens.source.stream_source import StreamSource


class Facts:
    """A read-only view of the session; every value is that of the moment it is asked for."""

    def __init__(
        self, source: OpenSource, editing: Editing, pictures: PictureDesk, time: TimeDesk
    ) -> None:
        self._source = source
        self._editing = editing
        self._pictures = pictures
        self._time = time

    @property
    def shot(self) -> Shot:
        """The current shot."""
        return self._editing.shot

    @property
    def seen_shot(self) -> Shot:
        """The shot of the picture: the current one, or one with trial values."""
        return self._editing.seen_shot

    @property
    def lens(self) -> Lens:
        """The lens of the shot at the playhead."""
        return self._editing.lens

    @property
    def has_lens(self) -> bool:
        """True if there is a lens at the playhead."""
        return self._editing.has_lens

    @property
    def frame(self) -> int:
        """The frame at the playhead."""
        return self._editing.frame

    @property
    def view(self) -> ViewState:
        """The view state: exposure, zoom, overlay, comparison."""
        return self._pictures.view.state

    @property
    def unit(self) -> str:
        """The unit of distances, "m" or "ft"."""
        return self.view.unit

    @property
    def plate(self) -> Plate | None:
        """The picture before the blur; None while there is none."""
        return self._source.plate

    @property
    def has_camera(self) -> bool:
        """True if the open source has a camera that can move."""
        return self._source.has_camera

    @property
    def has_many_views(self) -> bool:
        """True if the open source can be seen from many points of the lens."""
        return self._pictures.renderer.has_many_views

    @property
    def histogram(self) -> DepthHistogram | None:
        """The histogram of the plate's distances; None if it has none."""
        return self._source.picture.histogram

    @property
    def marks_m(self) -> tuple[tuple[str, float], ...]:
        """Names and distances in m of the marks that have one at this frame."""
        marks = self._time.marks
        found = [(mark.name, marks.distance_m(mark)) for mark in self.shot.marks]
        return tuple((name, distance_m) for name, distance_m in found if distance_m is not None)

    @property
    def keyed_focus_m(self) -> float | None:
        """The focus of the keys in m, where the lens has another one: tried or performed."""
        curve = self.shot.curves.focus_distance_m
        keyed_m = curve.value_at(self.frame) if curve.keys else self.lens.focus_distance_m
        return None if keyed_m == self.lens.focus_distance_m else keyed_m

    @property
    def beats_left(self) -> int:
        """The number of the count-in before a pull is recorded: 3, 2, 1; 0 without one."""
        return self._time.recording.beats_left

    @property
    def reference(self) -> Reference | None:
        """The reference picture, to be shown as B; None if none is loaded."""
        return self._pictures.references.current

    @property
    def picture_shape(self) -> PictureShape:
        """The shape of the display window; one pixel while nothing is open."""
        return self._source.picture_shape(self.shot)

    @property
    def seen(self) -> Shown | None:
        """The picture through the lens to show."""
        return self._time.scheduler.seen

    @property
    def is_plain(self) -> bool:
        """True while only the live picture through the lens is shown."""
        return self._pictures.view.is_lens_alone and not self._time.pull.is_alone

    @property
    def part_done(self) -> float | None:
        """How much of the whole picture is rendered, 0 to 1; None once it is complete."""
        return None if self.plays_kept else self._pictures.live.part_done

    @property
    def plays_kept(self) -> bool:
        """True while kept frames play, instead of the plate that is loaded."""
        return self._time.pull.is_alone

    # What is open

    @property
    def opening(self) -> str:
        """The name of the source that is being opened; "" for none."""
        return self._source.opener.opening or ""

    @property
    def stream(self) -> StreamSource | None:
        """The renderer that may send pictures; None if none is listened to."""
        return self._source.stream

    @property
    def is_waiting(self) -> bool:
        """True while nothing is shown and a stream waits for its first picture."""
        return self._source.is_waiting

    @property
    def is_black(self) -> bool:
        """True if the frame at the playhead has no file and is shown black."""
        return self._source.picture.is_black

    @property
    def plate_version(self) -> int:
        """A number that changes with the picture before the blur."""
        return self._source.picture.version

    def windows(self) -> tuple[Box, Box]:
        """Return data window and display window of the whole picture."""
        return self._source.feed.windows(self.shot)

    def frame_px(self, pixel: Pixel) -> Pixel:
        """Return the pixel of the frame that is seen at a pixel of the picture."""
        return self._source.frame_px(self.lens, pixel)

    def plate_px(self, pixel: Pixel) -> Pixel:
        """Return the pixel of the plate for one of the frame; a preview's plate is smaller."""
        return self._source.feed.plate_px(self.shot, pixel)

    def picture_point(self, point: tuple[float, float]) -> tuple[float, float]:
        """Return where a point of the frame lies in the picture."""
        return self._source.picture_point(self.lens, point)
