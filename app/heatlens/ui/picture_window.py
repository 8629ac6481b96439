"""The picture in its place: drawn, with its legend and marks, and the hand on it."""

from dataclasses import replace

import moderngl
from imgui_bundle import ImVec2, imgui

from heatlens.display.screen_pictures import (
    MIPMAPS_UNDER,
    ScreenPictures,
    layer_limits_px,
    picture_of_b,
)
from heatlens.model.coc import sharp_px
from heatlens.model.view import Compare, Overlay, ViewState
from heatlens.session.kept_screen import KeptFrame, KeptScreen
from heatlens.session.session import Session
from heatlens.ui import probe
from heatlens.ui.layout import PICTURE, PICTURE_ALONE
from heatlens.ui.panels.marks_panel import draw_point_marks
from heatlens.ui.picture.alt_held import AltHeld
from heatlens.ui.picture.guides import draw_guides
from heatlens.ui.picture.legend import draw_legend, entries
from heatlens.ui.picture.stream_notice import StreamNotice, draw_waiting
from heatlens.ui.picture.viewport import Pictures, ViewportPanel, ViewportResult
from heatlens.ui.start.start_screen import StartScreen
from heatlens.ui.state import UiState

_Window = imgui.WindowFlags_


class PictureWindow:
    """Draws the picture, or what stands in its place while there is none."""

    def __init__(
        self, session: Session, ui: UiState, screen: ScreenPictures, kept: KeptScreen
    ) -> None:
        self._session = session
        self._ui = ui
        self._screen = screen
        self._kept = kept
        ctx = session.renderer.ctx
        self._start = StartScreen(ctx)
        self._notice = StreamNotice()
        self.viewport = ViewportPanel(ctx, session.picture_view)
        self.hovered: tuple[int, int] | None = None  # pixel of the display window
        self.alt = AltHeld()
        self.pictures: Pictures | None = None  # that are seen

    def draw(self, hears_keys: bool) -> None:
        """Draw the picture; `hears_keys`: no dialog, field or menu takes the keys."""
        imgui.push_style_var(imgui.StyleVar_.window_padding, ImVec2(0, 0))
        self._begin()
        imgui.pop_style_var()
        self.pictures = pictures = self._pictures()
        if self._session.start_choices.is_wanted:
            self.hovered = None
            self._choose(hears_keys)
        elif self._session.source.is_black and not self._session.pull.is_alone:
            imgui.text_disabled(f"  Frame {self._session.editing.frame} has no file.")
        elif self._session.source.is_waiting and self._session.source.stream is not None:
            draw_waiting(self._session.source.stream)
        elif pictures is None:
            is_coming = (
                self._session.source.plate is not None or self._session.source.opener.opening
            )
            words = "Opening ..." if is_coming else "Nothing is open: Ctrl+O, or drop a file here."
            imgui.text_disabled(f"  {words}")
        else:
            scale = imgui.get_io().display_framebuffer_scale.x or 1.0
            self._take(self.viewport.draw(pictures, self._session.view, scale))
            draw_guides(self._session.view.guides, pictures.shape, self.viewport.place)
            draw_point_marks(self._session)
            self._legend()
            if self._session.source.stream is not None and self._session.source.stream.is_shown:
                self._notice.draw(self._session.source.stream, self._session.picture_view.viewport)
        probe.note("picture")
        imgui.end()

    def _begin(self) -> None:
        """Begin the window in its dock, or over the whole screen where it is seen alone."""
        still = _Window.no_scrollbar | _Window.no_scroll_with_mouse | _Window.no_background
        if not self._ui.is_bare:
            imgui.begin(PICTURE, None, still)
            return
        screen = imgui.get_main_viewport()
        imgui.set_next_window_pos(screen.pos)
        imgui.set_next_window_size(screen.size)
        alone = _Window.no_decoration | _Window.no_move | _Window.no_docking
        imgui.begin(PICTURE_ALONE, None, still | alone | _Window.no_saved_settings)

    def _overlay(self, view: ViewState) -> moderngl.Texture:
        session = self._session
        shot, frame = session.editing.seen_shot, session.editing.frame
        loaded = session.renderer.loaded
        return self._screen.overlay(loaded, shot, frame, view.overlay, view.peaking_stops)

    def _choose(self, hears_keys: bool) -> None:
        """Draw the start screen and do what the hand wants."""
        choices, opening = self._session.start_choices, self._session.source.opener.opening
        answer = self._start.draw(choices.cards(), opening, hears_keys, choices.most_recent)
        if answer.taken is not None and not choices.take(answer.taken):
            self._ui.dialogs.ask("open")
        elif answer.leaves:
            choices.leave()

    def _legend(self) -> None:
        session = self._session
        if session.view.overlay is Overlay.NONE or session.view.compare is Compare.FLIP:
            return
        if not session.editing.has_lens:
            return
        plate = session.renderer.loaded.plate
        optics = session.renderer.optics(session.editing.seen_shot, session.editing.frame)
        sharp = sharp_px(session.lens, plate.display_window.width)
        limits = layer_limits_px(optics, session.editing.seen_shot)
        legend = entries(
            session.view.overlay, optics, sharp, limits, plate.depth, session.view.unit
        )
        draw_legend(legend, session.picture_view.viewport)

    def _take(self, result: ViewportResult) -> None:
        self._session.view, self.hovered = result.view, result.hovered_px
        if result.camera is not None:
            self._session.scenes.move(result.camera)
        if result.focus_notches:
            self._session.lens_commands.nudge_focus(result.focus_notches)
        if result.focus_px is None:
            return
        io = imgui.get_io()
        if not (io.key_ctrl and io.key_shift):
            self._session.lens_commands.focus_at(result.focus_px)
        elif imgui.is_mouse_clicked(imgui.MouseButton_.left):
            self._session.marks.set_point(result.focus_px)

    def _pictures(self) -> Pictures | None:
        """Return what the viewport shows, drawn again where it changed."""
        session, plate = self._session, self._session.source.plate
        session.picture_view.is_lens_held_off = self.alt.is_over(self.hovered is not None)
        shown = session.seen
        if plate is None or shown is None:
            return None
        screen, loaded = self._screen, session.renderer.loaded
        depth_of_field = session.view.depth_of_field and not session.picture_view.is_lens_held_off
        view = replace(session.view, depth_of_field=depth_of_field)
        view = replace(view, exposure_stops=view.exposure_stops + session.lens.transmission_stops)
        screen.with_mipmaps = session.picture_view.zoom < MIPMAPS_UNDER
        reference = session.reference.texture if session.reference else None
        of_method = session.sides.of_method(view)
        linear_b = picture_of_b(view, loaded, reference, of_method)
        if is_kept := isinstance(shown, KeptFrame):
            a = self._kept.texture(shown, view)
        else:
            a = screen.a(shown, session.sides.pictures, loaded, view, linear_b)
        b = a
        if view.compare in (Compare.WIPE, Compare.FLIP):
            b = screen.b(linear_b, loaded, view, of_method)
        detail = None
        if view.depth_of_field and view.compare is not Compare.DIFFERENCE and not is_kept:
            detail = screen.detail(shown, loaded, view)
        overlay = None
        if view.overlay is not Overlay.NONE and session.editing.has_lens:
            overlay = self._overlay(view)
        windows = self._kept.windows(shown) or session.source.windows(session.shot)
        return Pictures(
            a,
            b,
            detail,
            overlay,
            *windows,
            plate.pixel_aspect_ratio,
            is_proxy=a.size != (windows[0].width, windows[0].height),
            is_b_proxy=of_method is not None and b.size != loaded.color.size,
            has_camera=session.scenes.scene is not None,
        )
