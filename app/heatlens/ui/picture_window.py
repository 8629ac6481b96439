"""The picture in its place: drawn, with its legend and marks, and the hand on it."""

from dataclasses import replace

from imgui_bundle import ImVec2, imgui

from heatlens.display.screen_pictures import layer_limits_px, picture_of_b
from heatlens.model.coc import sharp_px
from heatlens.model.view import Compare, Overlay
from heatlens.ui import widgets
from heatlens.ui.app import App
from heatlens.ui.layout import PICTURE
from heatlens.ui.panels.marks_panel import draw_point_marks
from heatlens.ui.picture.legend import draw_legend, entries
from heatlens.ui.picture.viewport import MIPMAPS_UNDER, Pictures, ViewportResult
from heatlens.ui.start.start_screen import StartScreen
from heatlens.ui.timeline.kept_screen import KeptFrame

_Window = imgui.WindowFlags_


class PictureWindow:
    """Draws the picture, or what stands in its place while there is none."""

    def __init__(self, app: App) -> None:
        self._app = app
        self._start = StartScreen(app.ctx)
        self.hovered: tuple[int, int] | None = None  # pixel of the display window

    def draw(self, hears_keys: bool) -> None:
        """`hears_keys`: they are meant for what lies beneath dialogs, fields and menus."""
        imgui.push_style_var(imgui.StyleVar_.window_padding, ImVec2(0, 0))
        still = _Window.no_scrollbar | _Window.no_scroll_with_mouse | _Window.no_background
        imgui.begin(PICTURE, None, still)
        imgui.pop_style_var()
        pictures = self._pictures()
        if self._app.first.is_wanted:
            self.hovered = None
            self._start.choose(self._app, hears_keys)
        elif self._app.source.is_black and not self._app.pull.is_alone:
            imgui.text_disabled(f"  Frame {self._app.editing.frame} has no file.")
        elif self._app.source.is_waiting:
            imgui.text_disabled("  Waiting for a renderer. Ctrl+O opens a file instead.")
        elif pictures is None:
            is_coming = self._app.source.plate is not None or self._app.source.opener.opening
            words = "Opening ..." if is_coming else "Nothing is open: Ctrl+O, or drop a file here."
            imgui.text_disabled(f"  {words}")
        else:
            scale = imgui.get_io().display_framebuffer_scale.x or 1.0
            self._take(self._app.viewport.draw(pictures, self._app.view, scale))
            draw_point_marks(self._app)
            self._legend()
        widgets.note("picture")
        imgui.end()

    def _legend(self) -> None:
        app = self._app
        if app.view.overlay is Overlay.NONE or app.view.compare is Compare.FLIP:
            return
        if not app.editing.has_lens:
            return
        plate = app.renderer.loaded.plate
        optics = app.renderer.optics(app.shot, app.editing.frame)
        sharp = sharp_px(app.lens, plate.display_window.width)
        limits = layer_limits_px(optics, app.shot)
        legend = entries(app.view.overlay, optics, sharp, limits, plate.depth, app.view.unit)
        draw_legend(legend, app.viewport.viewport)

    def _take(self, result: ViewportResult) -> None:
        self._app.view, self.hovered = result.view, result.hovered_px
        if result.camera is not None:
            self._app.scenes.move(result.camera)
        if result.focus_px is None:
            return
        io = imgui.get_io()
        if not (io.key_ctrl and io.key_shift):
            self._app.focus_at(result.focus_px)
        elif imgui.is_mouse_clicked(imgui.MouseButton_.left):
            self._app.timeline.marks.set_point(result.focus_px)

    def _pictures(self) -> Pictures | None:
        """What the viewport shows, drawn again where it changed."""
        app, plate = self._app, self._app.source.plate
        app.turns.is_lens_held_off = self._alt()
        shown = app.turns.seen
        if plate is None or shown is None:
            return None
        screen, loaded = app.screen, app.renderer.loaded
        depth_of_field = app.view.depth_of_field and not app.turns.is_lens_held_off
        view = replace(app.view, depth_of_field=depth_of_field)
        view = replace(view, exposure_stops=view.exposure_stops + app.lens.transmission_stops)
        screen.with_mipmaps = app.viewport.zoom < MIPMAPS_UNDER
        reference = app.reference.texture if app.reference else None
        of_method = app.sides.of_method(view)
        linear_b = picture_of_b(view, loaded, reference, of_method)
        if is_kept := isinstance(shown, KeptFrame):
            a = app.pull.screen.texture(shown, view)
        else:
            a = screen.a(shown, app.sides.version, loaded, view, linear_b)
        b = a
        if view.compare in (Compare.WIPE, Compare.FLIP):
            b = screen.b(linear_b, loaded, view, app.sides.version if of_method else 0)
        detail = None
        if view.depth_of_field and view.compare is not Compare.DIFFERENCE and not is_kept:
            detail = screen.detail(shown, loaded, view)
        overlay = None
        if view.overlay is not Overlay.NONE and app.editing.has_lens:
            overlay = screen.overlay(loaded, app.shot, app.editing.frame, view.overlay)
        windows = app.pull.screen.windows(shown) or app.source.windows(app.shot)
        return Pictures(
            a,
            b,
            detail,
            overlay,
            *windows,
            plate.pixel_aspect_ratio,
            is_proxy=a.size != (windows[0].width, windows[0].height),
            is_b_proxy=of_method is not None and b.size != loaded.color.size,
            has_camera=app.scenes.scene is not None,
        )

    def _alt(self) -> bool:
        io = imgui.get_io()
        return bool(io.key_alt) and not io.want_text_input
