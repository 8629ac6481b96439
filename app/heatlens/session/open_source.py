"""The source that is open in the window: opened on a thread, and its pictures fed to the GPU."""

from collections.abc import Callable

from heatlens.model.boxes import Box
from heatlens.model.depth_histogram import DepthHistogram
from heatlens.model.framing import SceneTiming
from heatlens.model.lens import Lens
from heatlens.model.plate_options import PlateOptions
from heatlens.model.shot import Shot
from heatlens.model.timecode import Timecode
from heatlens.model.view_geometry import PictureShape
from heatlens.plate.breathing_window import picture_point, plate_pixel
from heatlens.plate.plate import Plate
from heatlens.plate.timecode import timecode_of
from heatlens.render import FrameRenderer
from heatlens.scene.scene import Scene
from heatlens.session.gpu_picture import GpuPicture
from heatlens.session.picture_feed import PictureFeed, Playhead, feed_of
from heatlens.source.disk_watch import DiskWatch
from heatlens.source.opened import Opened
from heatlens.source.opener import SourceOpener
from heatlens.source.stream_source import StreamSource


class OpenSource:
    """Holds one opened source, whatever kind it is, until the next one has a picture."""

    def __init__(
        self,
        renderer: FrameRenderer,
        wake: Callable[[], None],
        stream: StreamSource | None = None,
    ) -> None:
        """Take `stream`, a renderer that may send frames.

        It is closed together with this object.
        """
        self.stream = stream
        if stream is not None:
            stream.wake = wake
        self.opener = SourceOpener(wake, stream)
        self.opened: Opened | None = None
        self.picture = GpuPicture(renderer)
        self.feed = PictureFeed(self.picture)
        self._watch = DiskWatch()

    def open(
        self,
        text: str,
        options: PlateOptions,
        frame: int | None = None,
        timing: SceneTiming | None = None,
    ) -> None:
        """Begin to open a file, a pattern, a folder, a scene or the stream, see `SourceOpener`."""
        self.opener.open(text, options, frame, timing)

    def arrived(self) -> Opened | None:
        """Return what has been opened since, now on the GPU; the one before is closed only then.

        Raises HeatlensError where opening failed; what was open stays.
        """
        opened = self.opener.poll()
        if opened is None:
            return None
        feed = feed_of(opened, self.picture)
        self.picture.begin_axis()
        try:
            feed.begin()
        except BaseException:
            opened.close()
            raise
        self._close_opened()
        self.opened, self.feed, self._watch.cache = opened, feed, opened.cache
        if self.stream is not None:
            self.stream.show(opened.source is self.stream)
        return opened

    def _close_opened(self) -> None:
        if self.opened is not None:
            self.opened.close()
        self.opened = self._watch.cache = None

    # What is open

    @property
    def renderer(self) -> FrameRenderer:
        """The renderer that holds it."""
        return self.picture.renderer

    @property
    def scene(self) -> Scene | None:
        """The 3D scene, placed as the shot says; None where there is none."""
        return None if self.opened is None else self.feed.scene

    @property
    def is_repeatable(self) -> bool:
        """True where frames can be rendered again later, for a file; False for a stream."""
        return self.opened is None or self.opened.source.is_repeatable

    @property
    def has_scene(self) -> bool:
        """Return True where a 3D scene is open, which can be seen from more points than one."""
        return self.scene is not None

    def picture_shape(self, shot: Shot) -> PictureShape:
        """Return the shape of the display window; one pixel while nothing is open."""
        if self.plate is None:
            return PictureShape(1, 1)
        _, window = self.windows(shot)
        return PictureShape(window.width, window.height, self.plate.pixel_aspect_ratio)

    @property
    def is_waiting(self) -> bool:
        """True while nothing is shown, and what a renderer sends will be."""
        return self.plate is None and self.stream is not None and self.stream.is_wanted

    # The picture on the GPU, see `GpuPicture`

    @property
    def plate(self) -> Plate | None:
        """The picture without a lens; None while there is none."""
        return self.picture.plate

    @property
    def histogram(self) -> DepthHistogram | None:
        """Where its surfaces lie; None where it has no distances."""
        return self.picture.histogram

    @property
    def version(self) -> int:
        """Counts the pictures that were put on the GPU."""
        return self.picture.version

    @property
    def is_finer(self) -> bool:
        """True where the latest picture is the one before with less noise."""
        return self.picture.is_finer

    @property
    def is_black(self) -> bool:
        """True where a missing frame is shown as black."""
        return self.picture.is_black

    @property
    def problem(self) -> str:
        """Why the frame cannot be shown, in a sentence; "" where it can."""
        return self.picture.problem

    def is_settled_at(self, frame: int) -> bool:
        """Return True where the picture of this frame is there, as far as it can be."""
        return self.picture.is_settled and self.picture.frame == frame

    @property
    def wanted(self) -> object:
        """What was last asked of the frame cache: another value means other frames are read."""
        return self.feed.wanted

    # How pictures come to the GPU, see `PictureFeed`

    @property
    def is_good(self) -> bool:
        """True where the picture is worth a blur."""
        return self.feed.is_good

    @property
    def is_whole(self) -> bool:
        """True where the picture is as good as it gets."""
        return self.feed.is_whole

    def show(self, shot: Shot, playhead: Playhead) -> None:
        """Have the picture at the playhead on the GPU, now or as soon as it is read."""
        self.feed.show(shot, playhead)

    def follow(self, shot: Shot, frame: int) -> None:
        """Answer a change of the shot since `show`."""
        self.feed.follow(shot, frame)

    def refine(self, slice_s: float) -> None:
        """Go on for a moment with a better picture of what rests."""
        self.feed.refine(slice_s)

    def refresh(self) -> None:
        """Take over what has arrived by itself. Raises HeatlensError without room on the GPU."""
        self.feed.refresh()

    def seen(self, shot: Shot) -> Shot:
        """Return the shot as it is drawn now: a scene is drawn smaller while something moves."""
        return self.feed.seen(shot)

    def windows(self, shot: Shot) -> tuple[Box, Box]:
        """Return data and display window of the whole picture, however small it is drawn now."""
        return self.feed.windows(shot)

    def plate_px(self, shot: Shot, pixel: tuple[int, int]) -> tuple[int, int]:
        """Return the pixel of the plate on the GPU under one of the display window."""
        return self.feed.plate_px(shot, pixel)

    def frame_px(self, lens: Lens, pixel: tuple[int, int]) -> tuple[int, int]:
        """Return the pixel of the frame that is seen at one of the picture.

        Before a plate, a lens that breathes shows another part of the frame; a scene is drawn as
        the lens sees it.
        """
        is_cut = self.plate is not None and not self.has_scene
        return plate_pixel(self.plate, lens, pixel) if is_cut and self.plate else pixel

    def picture_point(self, lens: Lens, point: tuple[float, float]) -> tuple[float, float]:
        """Return where a point of the frame is seen in the picture; see `frame_px`."""
        is_cut = self.plate is not None and not self.has_scene
        return picture_point(self.plate, lens, point) if is_cut and self.plate else point

    def timecode_at(self, shot: Shot, frame: int) -> tuple[int, Timecode] | None:
        """Return the frame of the plate that is shown and its timecode, where one is told."""
        told = None if self.plate is None else timecode_of(self.plate.attributes)
        timecode = shot.timecode_at(frame, told)
        return None if timecode is None else (frame, timecode)

    def seconds_until_needed(self) -> float | None:
        """Return how long until `refine` has something to do; None where it has nothing."""
        return self.feed.seconds_until_needed()

    def close(self) -> None:
        """Stop every thread."""
        self._watch.close()
        self.opener.close()
        if self.stream is not None:
            self.stream.close()
        self._close_opened()
