"""Rendered frames on the screen: uploaded to the GPU when shown, and not rendered again."""

from collections.abc import Iterator
from dataclasses import replace

from heatlens.core.model.boxes import Box
from heatlens.core.model.view.picture_view import PictureView
from heatlens.core.model.view.view import ViewState
from heatlens.render.display.screen_frames import MOST_BYTES, ScreenFrames, ScreenTransform
from heatlens.render.display.screen_pictures import MIPMAPS_UNDER, ScreenPictures
from heatlens.render.gpu.context import is_software
from heatlens.render.gpu.resources import Texture
from heatlens.render.gpu.textures import new_texture
from heatlens.render.preview.shown import ShownPicture
from heatlens.render.rendered_frames.cached_pictures import CachedPicture
from heatlens.render.rendered_frames.frame_filler import FrameJob
from heatlens.render.rendered_frames.screen_work import CachedFrame, ScreenWork
from heatlens.studio.session.opened.open_source import OpenSource
from heatlens.studio.session.playing.ahead_jobs import FramesRequest
from heatlens.studio.session.playing.frames_ahead import FramesAhead
from heatlens.studio.session.shot.editing import Editing

# The requested frames, and how they are shown: the view, version of the view transform, zoom.
ScreenRequest = tuple[FramesRequest | None, ViewState, int, float]


class CachedScreen(ScreenWork):
    """Shows the frames that a `FramesAhead` keeps, and converts them for the screen beforehand."""

    def __init__(
        self,
        frames_ahead: FramesAhead,
        source: OpenSource,
        editing: Editing,
        view: PictureView,
        screen: ScreenPictures,
    ) -> None:
        ctx = source.picture.renderer.ctx
        self._ctx, self._frames_ahead, self._source = ctx, frames_ahead, source
        self._editing, self._view, self._screen = editing, view, screen
        self._frames = ScreenFrames(ctx)
        self._is_slow = is_software(ctx)
        self._texture: Texture | None = None
        self._gpu_key = ""  # key of the frame in the texture
        self._current_frame: CachedFrame | None = None
        self._prepared_for: ScreenRequest | None = None  # the request whose frames are all prepared

    def forget_frames(self) -> None:
        """Forget all frames, because something else was opened or they were cleared."""
        self._current_frame, self._gpu_key, self._prepared_for = None, "", None
        self._frames.clear()

    def frame_at_playhead(self) -> CachedFrame | None:
        """Return the picture at the playhead; while it is read from disk, the previous one."""
        frames_ahead = self._frames_ahead
        is_kept = (
            frames_ahead.is_on and self._view.is_lens_alone and not self._editing.trial_parameters
        )
        job = frames_ahead.jobs.job_of(self._editing.frame) if is_kept else None
        if job is None:
            return None
        picture = frames_ahead.store.memory.get(job.key)
        if picture is None:
            return self._current_frame if frames_ahead.plays_cached_frames else None
        last_frame = self._current_frame
        is_new = last_frame is None or (last_frame.key, last_frame.frame) != (
            job.key,
            self._editing.frame,
        )
        if last_frame is None or is_new or last_frame.texture is not self._texture:
            self._current_frame = self._cached_frame(job, picture)
        return self._current_frame

    def _cached_frame(self, job: FrameJob, picture: CachedPicture) -> CachedFrame:
        """Return a picture from memory as a frame, whose shared texture is not filled yet."""
        height, width = picture.pixels.shape[:2]
        if self._texture is None or self._texture.size != (width, height):
            if self._texture is not None:
                self._texture.release()
            self._texture = new_texture(self._ctx, (width, height), 4, "f2", "rendered frame")
            self._gpu_key = ""
        shot, frame = self._editing.shot, self._editing.frame
        return CachedFrame(
            self._texture, shot, frame, shot.defocus, 0.0, key=job.key, picture=picture
        )

    def upload(self, cached_frame: ShownPicture) -> ShownPicture:
        """Return the same picture; fill the texture of a cached frame first."""
        if (
            isinstance(cached_frame, CachedFrame)
            and cached_frame.picture is not None
            and self._gpu_key != cached_frame.key
        ):
            cached_frame.texture.write(cached_frame.picture.pixels.data.cast("B"))
            self._gpu_key = cached_frame.key
        return cached_frame

    def windows(self, cached_frame: ShownPicture) -> tuple[Box, Box] | None:
        """Return data and display window of a cached frame; None if they are the current ones."""
        picture = cached_frame.picture if isinstance(cached_frame, CachedFrame) else None
        return None if picture is None else self._source.feed.kept_windows(picture)

    def texture(self, cached_frame: CachedFrame, view: ViewState) -> Texture:
        """Return the frame in the colors of the screen.

        The exposure of `view` includes the transmission of the lens.
        """
        transform = self._screen_transform(view, cached_frame.texture.size)
        if self._is_slow:
            size, keys = cached_frame.texture.size, self._frames_ahead.progress.keys
            memory = self._frames_ahead.store.memory
            self._frames.most_bytes = min(MOST_BYTES, memory.limit_bytes // 2)

            def draw(out: Texture) -> None:
                self._draw_colors(cached_frame, transform, out)

            prepared_texture = self._frames.texture(cached_frame.key, transform, size, keys, draw)
            if prepared_texture is not None:
                return prepared_texture
        screen = self._screen
        screen.with_mipmaps = transform.has_mipmaps
        self.upload(cached_frame)
        plate = self._source.picture.renderer.loaded
        return screen.a(cached_frame, cached_frame.key, plate, view, cached_frame.texture)

    def _screen_transform(self, view: ViewState, size: tuple[int, int]) -> ScreenTransform:
        """Return what decides the colors of a frame of this size on the screen."""
        zoom = self._view.zoom * self._source.picture_shape(self._editing.shot).height_px / size[1]
        version = self._screen.transform_version
        return ScreenTransform(view.exposure_stops, view.gamma, version, zoom < MIPMAPS_UNDER)

    def _draw_colors(
        self, cached_frame: CachedFrame, transform: ScreenTransform, target: Texture
    ) -> None:
        """Draw a frame in the colors of the screen into `target`."""
        self.upload(cached_frame)
        self._screen.display.run(
            cached_frame.texture, target, transform.exposure_stops, transform.gamma
        )
        if transform.has_mipmaps:
            target.build_mipmaps()

    # A cached frame holds scene-linear light, and needs the view transform before it is shown. A
    # software rasterizer takes 94 to 257 ms for that in 1920x1080, several frames of a film, so
    # frames are converted beforehand while the window rests. A GPU converts each frame as it is
    # shown, and needs no second copy.
    @property
    def has_work(self) -> bool:
        """True while a frame in memory still needs its slow conversion for the screen."""
        if not self._is_slow or self._prepared_for == self._screen_request:
            return False
        if next(self._unprepared_frames(), None) is None:
            self._prepared_for = self._screen_request
            return False
        return True

    @property
    def _screen_request(self) -> ScreenRequest:
        """What prepared frames depend on: request, view, version of its transform, and zoom."""
        version, view = self._screen.transform_version, self._view
        return self._frames_ahead.progress.request, view.state, version, view.zoom

    def prepare(self) -> None:
        """Convert one more frame to the colors of the screen."""
        cached_frame = next(self._unprepared_frames(), None) if self.has_work else None
        if cached_frame is not None:
            self.texture(cached_frame, self._exposed_view(cached_frame))

    def _unprepared_frames(self) -> Iterator[CachedFrame]:
        """Yield the frames in memory that still need their conversion, while memory allows."""
        frames_ahead = self._frames_ahead
        for job in frames_ahead.progress.jobs:
            picture = frames_ahead.store.memory.get(job.key)
            if picture is None:
                continue
            size = picture.pixels.shape[1], picture.pixels.shape[0]
            cached_frame = replace(self._cached_frame(job, picture), frame=job.frame)
            if not self._frames.can_fit(job.key, size, frames_ahead.progress.keys):
                return
            if not self._frames.has_frame(
                job.key, self._screen_transform(self._exposed_view(cached_frame), size)
            ):
                yield cached_frame

    def _exposed_view(self, cached_frame: CachedFrame) -> ViewState:
        """Return the view with the transmission of the frame's lens in its exposure."""
        view, lens = self._view.state, cached_frame.shot.lens_at(cached_frame.frame)
        return view.with_transmission(lens)
