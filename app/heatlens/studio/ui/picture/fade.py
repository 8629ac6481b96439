"""Fade the whole picture in over its preview, so that it does not jump."""

import time
from collections.abc import Callable
from dataclasses import replace

from imgui_bundle import ImVec2, imgui

from heatlens.core.model.view.view_geometry import ViewGeometry, Viewport
from heatlens.render.gpu.device import Device, Framebuffer
from heatlens.render.preview.shown import Shown
from heatlens.studio.ui import theme

FADE_S = 0.12
_FRAME_S = 1 / 60


# Between a preview and the whole picture there was a jump. What fades is a copy of the screen with
# the preview on it, so that nothing is rendered or converted again. It is used only while lens,
# frame and zoom are the same: a fade over another picture would be a double exposure.
class PictureFade:
    """Keeps the preview as it was on the screen, and fades it out over the whole picture.

    length_s  duration of the fade; 0 for none
    """

    def __init__(self, ctx: Device, clock: Callable[[], float] = time.perf_counter):
        self._ctx = ctx
        self._clock = clock
        self.length_s = FADE_S
        self._kept: Framebuffer | None = None  # the screen with a preview on it
        self._kept_of: object = None  # content and position of the kept preview; None without one
        self._shows: object = None  # the same for the frame being drawn, if it shows a preview
        self._passed: object = None  # what the frame before showed
        self._begun_at: float | None = None

    def draw(self, seen: Shown | None, place: Viewport, geometry: ViewGeometry) -> None:
        """Draw the fading preview over the picture, in the current window."""
        shown = None if seen is None else (replace(seen.picture_key, settings=seen.shot.defocus))
        where = shown, place, geometry
        is_whole = seen is not None and seen.is_whole
        self._shows = None if is_whole or seen is None else where
        if self._kept_of != where or not is_whole or not self.length_s:
            self._begun_at = None
            self._kept_of = None if self._kept_of != where else self._kept_of
            return
        now = self._clock()
        self._begun_at = now if self._begun_at is None else self._begun_at
        left = 1.0 - (now - self._begun_at) / self.length_s
        if left <= 0.0:
            self._begun_at = self._kept_of = None
            return
        self._draw_kept(place, left)

    def _draw_kept(self, place: Viewport, opacity: float) -> None:
        assert self._kept is not None
        (x, y), (width, height) = place.corner, place.size
        scale, size = place.framebuffer_scale, self._kept.size
        first = ImVec2(x * scale / size[0], 1.0 - y * scale / size[1])
        last = ImVec2((x + width) * scale / size[0], 1.0 - (y + height) * scale / size[1])
        texture = imgui.ImTextureRef(self._kept.color_attachments[0].handle)
        tint = theme.packed((1.0, 1.0, 1.0, opacity))
        draw, end = imgui.get_window_draw_list(), ImVec2(x + width, y + height)
        draw.add_image(texture, ImVec2(x, y), end, first, last, tint)

    def keep(self, target: Framebuffer, size_px: tuple[int, int]) -> None:
        """Keep a copy of the painted preview; call this before ImGui draws over it.

        While a mouse button is held, the next preview may follow at once: one is kept when it is
        shown again.
        """
        is_passing = self._shows != self._passed and any(map(imgui.is_mouse_down, range(3)))
        self._passed = self._shows
        if self._shows is None or not self.length_s or is_passing:
            return
        if self._kept is None or self._kept.size != size_px:
            self.release()
            self._kept = self._ctx.framebuffer([self._ctx.texture(size_px, 3)])
        self._ctx.copy_framebuffer(self._kept, target)
        self._kept_of = self._shows

    def seconds_until_needed(self) -> float | None:
        """Return the seconds until the next frame of a fade; None if nothing fades."""
        return None if self._begun_at is None else _FRAME_S

    def release(self) -> None:
        """Free the texture."""
        if self._kept is not None:
            for texture in self._kept.color_attachments:
                texture.release()
            self._kept.release()
            self._kept = None
