"""What stands in front of the lens: the open plates, the one on the GPU, and B's reference."""

import time
from collections.abc import Callable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from heatlens.errors import GpuError, HeatlensError, InputError
from heatlens.frame_cache.cache import Damaged, Direction
from heatlens.gpu.context import check_plate_fits
from heatlens.gpu.textures import new_texture, upload
from heatlens.model.boxes import Box
from heatlens.model.depth_histogram import DepthHistogram, depth_histogram
from heatlens.model.framing import Framing
from heatlens.model.plate_options import PlateOptions
from heatlens.model.shot import Shot
from heatlens.plate.plate import FloatImage, Plate
from heatlens.render import FrameRenderer
from heatlens.sequence.sequence import MissingPolicy
from heatlens.session.disk_watch import DiskWatch
from heatlens.session.plate_opening import Opened, PlateOpener
from heatlens.session.reference import Reference, read_reference
from heatlens.session.scene_opening import OpenedScene
from heatlens.session.scene_preview import ScenePreview
from heatlens.session.stream_source import OpenedStream, StreamSource


class OpenSource:
    """Opens plates and references; keeps the plate of the frame on the GPU."""

    def __init__(
        self,
        renderer: FrameRenderer,
        wake: Callable[[], None],
        stream: StreamSource | None = None,
    ) -> None:
        self.renderer = renderer
        self.stream = stream  # a renderer that may send frames; closed with the source
        if stream is not None:
            stream.wake = wake
        self.is_streaming = False  # its frames are what is seen
        self.opener = PlateOpener(wake)
        self.opened: Opened | None = None  # plates
        self.scene: OpenedScene | None = None  # or a scene in their place
        self.sight = ScenePreview(renderer)
        self.plate: Plate | None = None
        self.histogram: DepthHistogram | None = None
        self.reference: Reference | None = None
        self.upload_s = 0.0
        self.version = 0  # counts plates put on the GPU
        self.is_finer = False  # the latest of them is the one before with less noise
        self._frame, self._is_settled, self._is_playing = 0, False, False
        self.is_black = False  # there is no file, and nothing stands in for it
        self.problem = ""  # why the frame cannot be seen, in a sentence
        self.wanted: tuple[int, Direction, int] | None = None  # of the cache, as last told
        self._wake = wake
        self._reader = ThreadPoolExecutor(1, thread_name_prefix="reference")
        self._coming: Future[tuple[Path, FloatImage]] | None = None
        self._watch = DiskWatch()

    def open(self, text: str, options: PlateOptions, frame: int | None = None) -> None:
        """Begin to open a file, a pattern, a folder, or to show what a renderer sends."""
        if self.stream is not None and text == self.stream.text:
            self.opener.cancel()
            self.stream.begin(options)
        else:
            self.opener.open(text, options, frame)

    def arrived(self) -> Opened | OpenedScene | OpenedStream | None:
        """What has been opened since, now on the GPU; the one before goes only then.

        Raises HeatlensError where opening failed; what was open stays.
        """
        opened = self.opener.poll()
        if opened is None:
            return self._stream_arrived()
        if isinstance(opened, OpenedScene):
            self._take_scene(opened)
            return opened
        try:
            self._load(opened.plate)
        except BaseException:
            opened.cache.close()
            raise
        self._close_plates()
        self.opened, self.scene = opened, None
        self._frame, self._is_settled, self._watch.cache = opened.frame, True, opened.cache
        return opened

    def _take_scene(self, opened: OpenedScene) -> None:
        """To the GPU in the place of what was there before."""
        self.renderer.load_scene(opened.scene)
        self.plate = None
        self.sight.begin()
        self._close_plates()
        self.scene = opened
        self.look(opened.shot, opened.frame)

    @property
    def is_waiting(self) -> bool:
        """Nothing is seen, and what a renderer sends will be."""
        return self.plate is None and self.stream is not None and self.stream.is_wanted

    def _stream_arrived(self) -> OpenedStream | None:
        """The first frame of a renderer takes the place of what was there before."""
        stream = self.stream
        plate = None if stream is None or self.is_streaming else stream.poll()
        if stream is None or plate is None:
            return None
        self._load(plate)
        self._close_plates()
        self.scene = None
        self.is_streaming = stream.is_wanted = self._is_settled = True
        return OpenedStream(stream.text, stream.options, plate)

    def refresh(self) -> None:
        """What the renderer has sent since, in the place of its frame before.

        Raises HeatlensError where the GPU has no room for it.
        """
        plate = self.stream.poll() if self.stream is not None and self.is_streaming else None
        if plate is not None:
            self._load(plate)

    def seen(self, shot: Shot) -> Shot:
        """The shot as it is drawn now: of a scene perhaps smaller, while something moves."""
        return shot if self.scene is None else self.sight.seen(shot)

    def windows(self, shot: Shot) -> tuple[Box, Box]:
        """Data and display window; of a scene those of its whole picture, however small it is."""
        if self.scene is not None:
            box = Box(0, 0, *(shot.framing or Framing()).size)
            return box, box
        assert self.plate is not None
        return self.plate.data_window, self.plate.display_window

    def plate_px(self, shot: Shot, pixel: tuple[int, int]) -> tuple[int, int]:
        """The plate's pixel under one of the display window: a scene's plate may be smaller."""
        if self.scene is None or self.plate is None:
            return pixel
        window, (_, whole) = self.plate.display_window, self.windows(shot)
        return pixel[0] * window.width // whole.width, pixel[1] * window.height // whole.height

    def seconds_until_needed(self) -> float | None:
        """Until a scene is to be drawn whole; None where nothing is."""
        return None if self.is_whole else self.sight.seconds_to_rest()

    def _close_plates(self) -> None:
        if self.opened is not None:
            self.opened.cache.close()
        self.opened = self.wanted = self._watch.cache = None
        self.is_streaming = False
        if self.stream is not None:
            self.stream.is_wanted = False

    @property
    def is_good(self) -> bool:
        """What is on the GPU is worth a blur: of a scene that rests, large and antialiased."""
        return self.scene is None or bool(self.problem) or self.sight.is_good

    @property
    def is_whole(self) -> bool:
        """What is on the GPU is as good as it gets."""
        return self.scene is None or bool(self.problem) or self.sight.is_whole

    def look(self, shot: Shot, frame: int, is_playing: bool = False) -> None:
        """Have the scene's pinhole picture at `frame`; drawn again only where something moved."""
        self.problem, self.is_black, self._frame = "", False, frame
        self._is_playing = is_playing
        with self._drawing():
            self.sight.look(shot, frame, is_playing)
        self._is_settled = True

    def follow(self, shot: Shot, frame: int) -> None:
        """Look again where the shot has changed since: a blur would wait for its whole picture."""
        if self.scene is not None and self.plate is not None:
            self.look(shot, frame, self._is_playing)

    def refine(self, slice_s: float) -> None:
        """Go on with a better picture of a scene that rests."""
        if self.is_whole:
            return
        was_good = self.is_good
        with self._drawing():
            self.sight.refine(slice_s)
        self.is_finer = was_good and self.sight.is_whole

    @contextmanager
    def _drawing(self) -> Iterator[None]:
        """Show what was drawn in the block; what could not be drawn is a problem."""
        try:
            yield
        except HeatlensError as error:
            self.problem = str(error)
            if isinstance(error, GpuError):
                self.plate = None  # it was drawn over
            return
        if self.renderer.loaded.plate is not self.plate:
            self._show_loaded()

    def show(
        self, frame: int, direction: int = 1, window: int = 0, missing: MissingPolicy = "hold"
    ) -> None:
        """Have the plate of `frame` on the GPU as soon as it is read, `window` others read ahead.

        `problem` says why it is not there. `missing` says what stands in for a frame without a
        file.
        """
        self.problem, self.is_black, self._frame = "", False, frame
        if self.opened is None:
            return
        cache = self.opened.cache
        try:
            stands_in = cache.sequence.shown_frame(frame, missing)
        except InputError as error:
            self.problem, self._is_settled = str(error), True
            return
        if stands_in is None:
            self.is_black = self._is_settled = True
            return
        ahead: Direction = 1 if direction >= 0 else -1
        wanted = (stands_in, ahead, window)
        if wanted != self.wanted:
            cache.want(*wanted)
            self.wanted = wanted
        self._take(cache.get(stands_in))

    def is_settled_at(self, frame: int) -> bool:
        """What is to be seen at this frame is there, as far as it can be."""
        return self._is_settled and self._frame == frame

    def _take(self, found: Plate | Damaged | None) -> None:
        self._is_settled = found is not None
        if isinstance(found, Damaged):
            self.problem = found.sentence
        elif found is not None and found is not self.plate:
            self._load(found)

    def _load(self, plate: Plate) -> None:
        """To the GPU, in the place of the one before; without room for it, none is there."""
        start = time.perf_counter()
        self.plate = None
        self.renderer.load(plate)
        self.renderer.ctx.finish()
        self.upload_s = time.perf_counter() - start
        self._show_loaded()

    def _show_loaded(self) -> None:
        """What is on the GPU is what is seen from now on."""
        loaded = self.renderer.loaded
        self.plate = loaded.plate
        self.histogram = depth_histogram(loaded.bins) if loaded.plate.has_distances else None
        self.version += 1
        self.is_finer = False

    def open_reference(self, path: Path) -> None:
        """Begin to read an EXR to compare with."""
        self._coming = self._reader.submit(read_reference, path)
        self._coming.add_done_callback(lambda _: self._wake())

    def reference_arrived(self) -> bool:
        """True once, when the reference can be compared with. Raises HeatlensError if it cannot."""
        if self._coming is None or not self._coming.done():
            return False
        coming, self._coming = self._coming, None
        path, pixels = coming.result()
        size = (pixels.shape[1], pixels.shape[0])
        check_plate_fits(self.renderer.ctx, *size)
        texture = new_texture(self.renderer.ctx, size, 4, label="reference")
        upload(texture, np.ascontiguousarray(pixels))
        if self.reference is not None:
            self.reference.texture.release()
        self.reference = Reference(path, texture)
        return True

    def close(self) -> None:
        """Stop every thread."""
        self._watch.close()
        self.opener.close()
        self._reader.shutdown(wait=True, cancel_futures=True)
        if self.stream is not None:
            self.stream.close()
        if self.opened is not None:
            self.opened.cache.close()
