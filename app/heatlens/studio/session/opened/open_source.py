"""The source that is open in the window: opened on a thread, and its pictures fed to the GPU."""

from collections.abc import Callable
from contextlib import suppress
from threading import Event, Thread

from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.shot import Shot
from heatlens.core.model.timecode import Timecode
from heatlens.core.model.view.view_geometry import PictureShape
from heatlens.media.frame_cache.cache import FrameCache
from heatlens.media.plate.header.timecode import timecode_of
from heatlens.media.plate.overscan_need import picture_point, plate_pixel
from heatlens.media.plate.plate import Plate
from heatlens.media.scene.placing import Placing
from heatlens.media.scene.scene import Scene
from heatlens.render.frame_renderer import FrameRenderer
from heatlens.render.source.named import has_camera
from heatlens.render.source.opened import Opened
from heatlens.render.source.opener import SourceOpener, feed_of, only_once_reason
from heatlens.render.source.stream_source import StreamSource
from heatlens.studio.session.opened.gpu_picture import GpuPicture
from heatlens.studio.session.opened.picture_feed import PictureFeed

_MIN_PAUSE_S = 2.0
_FRAMES_A_SECOND = 2000  # a folder with more files is scanned less often


class DiskWatch:
    """A thread that makes `cache` scan the disk."""

    def __init__(self) -> None:
        self.cache: FrameCache | None = None
        self._is_over = Event()
        Thread(target=self._watch, name="disk-watch", daemon=True).start()

    def _watch(self) -> None:
        """Scan the folder of the cache again and again until the thread is stopped."""
        while not self._is_over.wait(self._pause_s()):
            with suppress(Exception):  # the cache raises it again when the loop asks for a frame
                if self.cache is not None:
                    self.cache.refresh()

    def _pause_s(self) -> float:
        """Return the pause between two scans in seconds, longer for a large folder."""
        frames = 0 if self.cache is None else len(self.cache.sequence.frames)
        return max(_MIN_PAUSE_S, frames / _FRAMES_A_SECOND)

    def close(self) -> None:
        """Stop the thread."""
        self._is_over.set()


# The window uses one class for an open source of any kind. Plates, scenes and streams differ only
# in the feed that brings their pictures to the GPU.
class OpenSource:
    """The open source of any kind, kept until the next one has a picture."""

    def __init__(
        self,
        renderer: FrameRenderer,
        wake: Callable[[], None],
        stream: StreamSource | None = None,
        placing_of: Callable[[str], Placing] = lambda _text: Placing(),
    ) -> None:
        """Create it; `stream` is a renderer that may send frames, or None.

        `placing_of` returns the user's choice for a scene whose file does not define its unit and
        up axis.

        The stream is closed together with this object. `picture` is the shown picture on the GPU,
        and `feed` brings it there; each source has its own feed.
        """
        self.stream = stream
        self.opener = SourceOpener(wake, stream, placing_of)
        self.opened: Opened | None = None
        self._asked: Opened | None = None  # of which `_has_camera` tells
        self._has_camera = False
        self.picture = GpuPicture(renderer)
        self.feed = PictureFeed(self.picture)
        self._watch = DiskWatch()

    def switch_source(self) -> Opened | None:
        """Return a newly opened source once its picture is on the GPU, and close the previous one.

        Raise HeatlensError if opening failed; the previous source stays open.
        """
        opened = self.opener.poll()
        if opened is None:
            return None
        feed: PictureFeed = feed_of(opened, self.picture)
        self.picture.reset_axis()
        try:
            feed.begin()
        except BaseException:
            opened.close()
            raise
        self._close_opened()
        self.opened, self.feed, self._watch.cache = opened, feed, opened.cache
        if self.stream is not None:
            self.stream.show(opened.text == self.stream.text)
        return opened

    def _close_opened(self) -> None:
        """Close the open source, if any."""
        if self.opened is not None:
            self.opened.close()
        self.opened = self._watch.cache = None

    # The open source

    @property
    def scene(self) -> Scene | None:
        """The 3D scene with the shot's placement; None if no scene is open."""
        return None if self.opened is None else self.feed.scene

    @property
    def why_shown_once(self) -> str:
        """A sentence why frames cannot be rendered again later; "" if they can."""
        return "" if self.opened is None else only_once_reason(self.opened)

    @property
    def is_sequence(self) -> bool:
        """True if it has more than one frame."""
        frames = None if self.opened is None else self.opened.frames
        return frames is not None and frames.count > 1

    @property
    def has_camera(self) -> bool:
        """True if the open source has a camera that can move, as a 3D scene has."""
        if self._asked is not self.opened:  # each frame of the window asks many times
            self._asked = self.opened
            self._has_camera = self.opened is not None and has_camera(self.opened.text)
        return self._has_camera

    def picture_shape(self, shot: Shot) -> PictureShape:
        """Return the shape of the display window; one pixel while nothing is open."""
        if self.plate is None:
            return PictureShape(1, 1)
        _, window = self.feed.windows(shot)
        return PictureShape(window.width, window.height, self.plate.pixel_aspect_ratio)

    @property
    def is_waiting(self) -> bool:
        """True while nothing is shown and a stream waits for its first frame."""
        return self.plate is None and self.stream is not None and self.stream.should_show

    @property
    def plate(self) -> Plate | None:
        """The picture before the blur; None while there is none."""
        return self.picture.plate

    def is_settled_at(self, frame: int) -> bool:
        """Return True if this frame is shown, or cannot be."""
        return self.picture.is_settled and self.picture.frame == frame

    def frame_px(self, lens: Lens, pixel: tuple[int, int]) -> tuple[int, int]:
        """Return the pixel of the plate's frame that is visible at a pixel of the picture.

        A breathing lens shows another part of a plate's frame; a scene is drawn as the lens sees
        it, so both pixels are the same.
        """
        return plate_pixel(self.plate, lens, pixel) if self.plate and not self.has_camera else pixel

    def plate_px(self, lens: Lens, shot: Shot, pixel: tuple[int, int]) -> tuple[int, int]:
        """Return the pixel of the loaded plate that is visible at a pixel of the picture."""
        return self.feed.plate_px(shot, self.frame_px(lens, pixel))

    def picture_point(self, lens: Lens, point: tuple[float, float]) -> tuple[float, float]:
        """Return where a point of the frame lies in the picture, the inverse of `frame_px`."""
        return (
            picture_point(self.plate, lens, point) if self.plate and not self.has_camera else point
        )

    def timecode_at(self, shot: Shot, frame: int) -> tuple[int, Timecode] | None:
        """Return the frame of the shown plate and its timecode; None if it has no timecode."""
        plate_timecode = None if self.plate is None else timecode_of(self.plate.attributes)
        timecode = shot.timecode_at(frame, plate_timecode)
        return None if timecode is None else (frame, timecode)

    def close(self) -> None:
        """Stop every thread."""
        self._watch.close()
        self.opener.close()
        if self.stream is not None:
            self.stream.close()
        self._close_opened()
