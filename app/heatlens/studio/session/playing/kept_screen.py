"""Rendered frames on the screen: uploaded to the GPU when shown, and not rendered again."""

from collections.abc import Iterator
from dataclasses import dataclass, replace

from heatlens.core.model.boxes import Box
from heatlens.core.model.view.view import ViewState
from heatlens.render.display.screen_frames import MOST_BYTES, ScreenFrames
from heatlens.render.display.screen_pictures import MIPMAPS_UNDER, ScreenPictures
from heatlens.render.gpu.context import is_software
from heatlens.render.gpu.device import Texture
from heatlens.render.gpu.textures import new_texture
from heatlens.render.preview.shown import Shown
from heatlens.render.rendered_frames.frame_filler import FrameJob
from heatlens.render.rendered_frames.kept_pictures import KeptPicture
from heatlens.studio.session.opened.open_source import OpenSource
from heatlens.studio.session.pictures.picture_view import PictureView
from heatlens.studio.session.playing.pull_jobs import Wanted
from heatlens.studio.session.playing.rendered_pull import RenderedPull, ScreenWork
from heatlens.studio.session.shot.editing import Editing

# Exposure in stops, gamma, version of the view transform, with mipmaps.
ScreenLook = tuple[float, float, int, bool]
# The wanted frames, and how they are shown: the view, version of the view transform, zoom.
ScreenWanted = tuple[Wanted | None, ViewState, int, float]


@dataclass(frozen=True, eq=False)
class KeptFrame(Shown):
    """A frame that was rendered before. Its texture is filled by `KeptScreen.uploaded`."""

    key: str = ""
    picture: KeptPicture | None = None

    @property
    def is_whole(self) -> bool:
        """Return True: it was rendered at full quality and the size of the window."""
        return True


class KeptScreen(ScreenWork):
    """Shows the frames of a `RenderedPull`."""

    def __init__(
        self,
        pull: RenderedPull,
        source: OpenSource,
        editing: Editing,
        view: PictureView,
        screen: ScreenPictures,
    ) -> None:
        ctx = source.picture.renderer.ctx
        self._ctx, self._pull, self._source = ctx, pull, source
        self._editing, self._view, self._screen = editing, view, screen
        self._frames = ScreenFrames(ctx)
        self._is_slow = is_software(ctx)
        self._texture: Texture | None = None
        self._on_gpu = ""  # key of the frame in the texture
        self._seen: KeptFrame | None = None
        self._prepared: ScreenWanted | None = None  # for which all frames were prepared

    def begin(self) -> None:
        """Forget all frames, because something else was opened or they were cleared."""
        self._seen, self._on_gpu, self._prepared = None, "", None
        self._frames.clear()

    def shown(self) -> KeptFrame | None:
        """Return the picture at the playhead; while it is read from disk, the previous one."""
        pull = self._pull
        is_kept = pull.is_on and self._view.is_lens_alone and not self._editing.tried
        job = pull.jobs.of(self._editing.frame) if is_kept else None
        if job is None:
            return None
        picture = pull.store.memory.get(job.key)
        if picture is None:
            return self._seen if pull.is_alone else None
        seen = self._seen
        is_new = seen is None or (seen.key, seen.frame) != (job.key, self._editing.frame)
        if seen is None or is_new or seen.texture is not self._texture:
            self._seen = self._kept(job, picture)
        return self._seen

    def _kept(self, job: FrameJob, picture: KeptPicture) -> KeptFrame:
        height, width = picture.pixels.shape[:2]
        if self._texture is None or self._texture.size != (width, height):
            if self._texture is not None:
                self._texture.release()
            self._texture = new_texture(self._ctx, (width, height), 4, "f2", "rendered frame")
            self._on_gpu = ""
        shot, frame = self._editing.shot, self._editing.frame
        return KeptFrame(
            self._texture, shot, frame, shot.defocus, 0.0, key=job.key, picture=picture
        )

    def uploaded(self, shown: Shown) -> Shown:
        """Return the same picture with its texture filled."""
        if isinstance(shown, KeptFrame) and shown.picture is not None and self._on_gpu != shown.key:
            shown.texture.write(shown.picture.pixels.data.cast("B"))
            self._on_gpu = shown.key
        return shown

    def windows(self, shown: Shown) -> tuple[Box, Box] | None:
        """Return data and display window of a kept frame; None if they are the current ones."""
        picture = shown.picture if isinstance(shown, KeptFrame) else None
        return None if picture is None else self._source.feed.kept_windows(picture)

    def texture(self, shown: KeptFrame, view: ViewState) -> Texture:
        """Return the frame in the colors of the screen.

        The exposure of `view` includes the transmission of the lens.
        """
        look = self._look(view, shown.texture.size)
        if self._is_slow:
            size, keys = shown.texture.size, self._pull.progress.keys
            memory = self._pull.store.memory
            self._frames.most_bytes = min(MOST_BYTES, memory.limit_bytes // 2)

            def draw(out: Texture) -> None:
                self._draw(shown, look, out)

            prepared = self._frames.texture(shown.key, look, size, keys, draw)
            if prepared is not None:
                return prepared
        screen = self._screen
        screen.with_mipmaps = look[-1]
        self.uploaded(shown)
        plate = self._source.picture.renderer.loaded
        return screen.a(shown, shown.key, plate, view, shown.texture)

    def _look(self, view: ViewState, size: tuple[int, int]) -> ScreenLook:
        zoom = self._view.zoom * self._source.picture_shape(self._editing.shot).height_px / size[1]
        version = self._screen.transform_version
        return view.exposure_stops, view.gamma, version, zoom < MIPMAPS_UNDER

    def _draw(self, shown: KeptFrame, look: ScreenLook, out: Texture) -> None:
        self.uploaded(shown)
        self._screen.display.run(shown.texture, out, *look[:2])
        if look[-1]:
            out.build_mipmaps()

    # A kept frame holds light, and needs the view transform before it is seen. A software
    # rasteriser takes 94 to 257 ms for that in 1920x1080, several frames of a film, so it is done
    # beforehand while the window rests. A GPU converts each frame as it is shown, and needs no
    # second copy.
    @property
    def has_work(self) -> bool:
        """Return True while a frame in memory still needs its slow conversion for the screen."""
        if not self._is_slow or self._prepared == self._wanted:
            return False
        if next(self._unprepared(), None) is None:
            self._prepared = self._wanted
            return False
        return True

    @property
    def _wanted(self) -> ScreenWanted:
        """What all prepared frames depend on."""
        version, view = self._screen.transform_version, self._view
        return self._pull.progress.wanted, view.state, version, view.zoom

    def prepare(self) -> None:
        """Convert one more frame to the colors of the screen."""
        shown = next(self._unprepared(), None) if self.has_work else None
        if shown is not None:
            self.texture(shown, self._exposed(shown))

    def _unprepared(self) -> Iterator[KeptFrame]:
        pull = self._pull
        for job in pull.progress.jobs:
            picture = pull.store.memory.get(job.key)
            if picture is None:
                continue
            size = picture.pixels.shape[1], picture.pixels.shape[0]
            shown = replace(self._kept(job, picture), frame=job.frame)
            if not self._frames.has_room(job.key, size, pull.progress.keys):
                return
            if not self._frames.holds(job.key, self._look(self._exposed(shown), size)):
                yield shown

    def _exposed(self, shown: KeptFrame) -> ViewState:
        view, lens = self._view.state, shown.shot.lens_at(shown.frame)
        return view.exposed_through(lens)
