"""Fade the whole picture in over its preview, so that it does not jump."""

import time
from collections.abc import Callable
from dataclasses import replace

from imgui_bundle import ImVec2, imgui

from heatlens.core.model.view.view_geometry import ViewGeometry, Viewport
from heatlens.render.gpu.device import Device
from heatlens.render.gpu.framebuffer import Framebuffer
from heatlens.render.preview.shown import ShownPicture
from heatlens.studio.ui import theme

FADE_S = 0.12
_FRAME_S = 1 / 60


# A copy of the screen with the preview on it fades out over the whole picture, so that nothing is
# rendered or converted again. The copy is used only while lens, frame and zoom are the same: a fade
# over another picture would look like a double exposure.
class PictureFade:
    """Keeps the preview as it was on the screen, and fades it out over the whole picture.

    length_s  duration of the fade; 0 for none
    """

    def __init__(self, ctx: Device, clock: Callable[[], float] = time.perf_counter):
        self._ctx = ctx
        self._clock = clock
        self.length_s = FADE_S
        self._preview: Framebuffer | None = None  # the screen with a preview on it
        self._preview_key: object = (
            None  # content and position of the kept preview; None without one
        )
        self._frame_key: object = None  # the same for the frame being drawn, if it shows a preview
        self._last_frame_key: object = None  # the same for the frame before
        self._start_s: float | None = None  # when the current fade began; None while nothing fades

    def draw(
        self, picture: ShownPicture | None, viewport: Viewport, geometry: ViewGeometry
    ) -> None:
        """Draw the fading preview over the picture, in the current window.

        Nothing is drawn while `picture` is itself a preview, or if the kept preview has another
        content or position.
        """
        picture_key = (
            None
            if picture is None
            else (replace(picture.picture_key, settings=picture.shot.defocus))
        )
        frame_key = picture_key, viewport, geometry
        is_whole = picture is not None and picture.is_whole
        self._frame_key = None if is_whole or picture is None else frame_key
        if self._preview_key != frame_key or not is_whole or not self.length_s:
            self._start_s = None
            self._preview_key = None if self._preview_key != frame_key else self._preview_key
            return
        now_s = self._clock()
        self._start_s = now_s if self._start_s is None else self._start_s
        opacity = 1.0 - (now_s - self._start_s) / self.length_s
        if opacity <= 0.0:
            self._start_s = self._preview_key = None
            return
        self._draw_preview(viewport, opacity)

    def _draw_preview(self, viewport: Viewport, opacity: float) -> None:
        """Draw the kept copy of the screen over the viewport."""
        assert self._preview is not None
        (x, y), (width, height) = viewport.corner, viewport.size
        scale, size = viewport.framebuffer_scale, self._preview.size
        first = ImVec2(x * scale / size[0], 1.0 - y * scale / size[1])
        last = ImVec2((x + width) * scale / size[0], 1.0 - (y + height) * scale / size[1])
        texture = imgui.ImTextureRef(self._preview.color_attachments[0].handle)
        tint = theme.pack_color((1.0, 1.0, 1.0, opacity))
        draw, end = imgui.get_window_draw_list(), ImVec2(x + width, y + height)
        draw.add_image(texture, ImVec2(x, y), end, first, last, tint)

    def keep_preview(self, target: Framebuffer, size_px: tuple[int, int]) -> None:
        """Keep a copy of the painted preview; call this before ImGui draws over it.

        While a mouse button is held, the next preview may follow at once, so a preview is kept only
        if it is drawn a second time.
        """
        is_during_drag = self._frame_key != self._last_frame_key and any(
            map(imgui.is_mouse_down, range(3))
        )
        self._last_frame_key = self._frame_key
        if self._frame_key is None or not self.length_s or is_during_drag:
            return
        if self._preview is None or self._preview.size != size_px:
            self.release()
            self._preview = self._ctx.framebuffer([self._ctx.texture(size_px, 3)])
        self._ctx.copy_framebuffer(self._preview, target)
        self._preview_key = self._frame_key

    def seconds_until_needed(self) -> float | None:
        """Return the seconds until the next frame of a fade; None if nothing fades."""
        return None if self._start_s is None else _FRAME_S

    def release(self) -> None:
        """Free the kept copy of the screen."""
        if self._preview is not None:
            for texture in self._preview.color_attachments:
                texture.release()
            self._preview.release()
            self._preview = None
