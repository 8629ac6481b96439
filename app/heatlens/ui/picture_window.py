"""Draw the picture with its legend and marks, and apply the mouse gestures in it."""

from dataclasses import replace

from imgui_bundle import ImVec2, imgui

from heatlens.display.screen_pictures import ScreenPictures, layer_limits_px
from heatlens.model.coc import sharp_px
from heatlens.model.guides import NO_GUIDES, Guides, guide_shapes, inner_rect
from heatlens.model.view import Compare
from heatlens.model.view_geometry import PictureShape, geometry
from heatlens.session.marks.lessons import Lessons
from heatlens.session.pictures.picture_view import PictureView
from heatlens.session.playing.kept_screen import KeptScreen
from heatlens.session.session import Session
from heatlens.ui import probe, theme
from heatlens.ui.layout import PICTURE, PICTURE_ALONE
from heatlens.ui.panels.marks_panel import draw_point_marks
from heatlens.ui.picture.alt_held import AltHeld
from heatlens.ui.picture.legend import LegendFacts, draw_legend, entries
from heatlens.ui.picture.lessons import draw_lessons
from heatlens.ui.picture.pictures import Pictures
from heatlens.ui.picture.ruler import draw_ruler
from heatlens.ui.picture.seen_pictures import SeenPictures
from heatlens.ui.picture.stream_notice import StreamNotice, draw_waiting
from heatlens.ui.picture.viewport import ViewportPanel, ViewportResult
from heatlens.ui.start.start_screen import StartScreen
from heatlens.ui.state import UiState


def draw_guides(guides: Guides, shape: PictureShape, place: PictureView) -> None:
    """Draw the guides over the picture at `place`, in the current window."""
    if guides == NO_GUIDES:
        return
    first = place.geometry.window_at_picture((0.0, 0.0))
    last = place.geometry.window_at_picture((shape.width_px, shape.height_px))
    picture = (*first, *last)
    shapes = guide_shapes(guides, picture)
    draw = imgui.get_window_draw_list()
    (x, y), (width, height) = place.viewport.corner, place.viewport.size
    draw.push_clip_rect(ImVec2(x, y), ImVec2(x + width, y + height), True)
    shade = theme.packed((0.0, 0.0, 0.0, guides.opacity))
    for rect in shapes.shades:
        draw.add_rect_filled(ImVec2(*rect[:2]), ImVec2(*rect[2:]), shade)
    for rect in shapes.frames:
        draw.add_rect(ImVec2(*rect[:2]), ImVec2(*rect[2:]), theme.OVER_PICTURE.guide)
    for line in shapes.lines:
        draw.add_line(ImVec2(*line[:2]), ImVec2(*line[2:]), theme.OVER_PICTURE.guide)
    draw.pop_clip_rect()
    probe.note_at("matte in the picture", inner_rect(picture, guides.aspect))


_Window = imgui.WindowFlags_


class PictureWindow:
    """Draws the picture, or the start screen or a notice while there is none."""

    def __init__(
        self, session: Session, ui: UiState, screen: ScreenPictures, kept: KeptScreen
    ) -> None:
        self._session = session
        self._ui = ui
        self._seen = SeenPictures(session, screen, kept)
        ctx = session.pictures.renderer.ctx
        self._start = StartScreen(ctx)
        self._notice = StreamNotice()
        self._lessons = Lessons(session.editing, session.time.marks)
        self.viewport = ViewportPanel(ctx, session.pictures.view)
        self.hovered: tuple[int, int] | None = None  # pixel of the display window under the pointer
        self.alt = AltHeld()
        self.pictures: Pictures | None = None  # the pictures shown in this frame

    def draw(self, hears_keys: bool, is_seen: bool = True) -> None:
        """Draw the picture; `hears_keys` is False while a dialog, field or menu takes the keys.

        With `is_seen` False the pictures of the frame before are enough.
        """
        imgui.push_style_var(imgui.StyleVar_.window_padding, ImVec2(0, 0))
        self._begin()
        imgui.pop_style_var()
        is_held_off = self.alt.is_over(self.hovered is not None)
        self._session.pictures.view.is_lens_held_off = is_held_off
        is_there = self._session.source.plate is not None and self._session.facts.seen is not None
        if is_seen or not is_there:
            self.pictures = self._seen.now()
        if self._session.files.start_choices.is_wanted:
            self.hovered = None
            self._choose(hears_keys)
        else:
            with theme.over_picture():
                self._draw_picture(self.pictures)
        probe.note("picture")
        imgui.end()

    def _draw_picture(self, pictures: Pictures | None) -> None:
        """Draw the picture and everything over it, or the reason why there is none."""
        if self._session.source.picture.is_black and not self._session.time.pull.is_alone:
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
            self._apply(self.viewport.draw(pictures, self._session.facts.view, scale))
            self._draw_over(pictures)
            if not (self._ui.is_bare or pictures.tiles):
                draw_lessons(self._lessons, self._session.pictures.view.viewport)
            if self._session.source.stream is not None and self._session.source.stream.is_shown:
                self._notice.draw(self._session.source.stream, self._session.pictures.view.viewport)

    def _draw_over(self, pictures: Pictures) -> None:
        """Draw guides, marks and the legend over the picture; in a grid, guides in each cell."""
        view, place = self._session.facts.view, self.viewport.place
        for cell in self.viewport.cells:
            here = geometry(view, cell, pictures.shape)
            draw_guides(view.guides, pictures.shape, replace(place, viewport=cell, geometry=here))
        if not pictures.tiles:
            draw_point_marks(self._session)
            draw_ruler(self._session, self.hovered)
            self._legend()

    def _begin(self) -> None:
        """Begin the ImGui window in its dock, or over the whole screen if the picture is alone."""
        still = _Window.no_scrollbar | _Window.no_scroll_with_mouse | _Window.no_background
        if not self._ui.is_bare:
            imgui.begin(PICTURE, None, still)
            return
        screen = imgui.get_main_viewport()
        imgui.set_next_window_pos(screen.pos)
        imgui.set_next_window_size(screen.size)
        alone = _Window.no_decoration | _Window.no_move | _Window.no_docking
        imgui.begin(PICTURE_ALONE, None, still | alone | _Window.no_saved_settings)

    def _choose(self, hears_keys: bool) -> None:
        """Draw the start screen and act on the user's choice."""
        choices, opening = self._session.files.start_choices, self._session.source.opener.opening
        answer = self._start.draw(choices.cards(), opening, hears_keys, choices.most_recent)
        if answer.taken is not None and not choices.take(answer.taken):
            self._ui.dialogs.ask("open")
        elif answer.leaves:
            choices.leave()

    def _legend(self) -> None:
        session = self._session
        if not session.facts.view.has_overlay or session.facts.view.compare is Compare.FLIP:
            return
        if not session.editing.has_lens:
            return
        plate = session.pictures.renderer.loaded.plate
        optics = session.pictures.renderer.optics(session.editing.seen_shot, session.editing.frame)
        sharp = sharp_px(session.facts.lens, plate.display_window.width)
        limits = layer_limits_px(optics, session.editing.seen_shot)
        facts = LegendFacts(optics, sharp, limits, plate.depth, session.facts.view.unit)
        peaking = session.facts.view.peaking if session.facts.view.is_peaking else None
        legend = entries(session.facts.view.overlay, facts, peaking)
        is_right = bool(self._lessons.left)  # the lessons are at the left
        draw_legend(legend, session.pictures.view.viewport, is_right)

    def _apply(self, result: ViewportResult) -> None:
        self._session.pictures.view.state, self.hovered = result.view, result.hovered_px
        if result.camera is not None:
            self._session.scenes.move(result.camera)
        if result.focus_notches:
            self._session.lens.commands.nudge_focus(result.focus_notches)
        if result.tile is not None:
            self._choose_tile(result.tile)
        if result.focus_px is None:
            return
        io, ruler = imgui.get_io(), self._session.pictures.commands.ruler
        is_clicked = imgui.is_mouse_clicked(imgui.MouseButton_.left)
        if ruler.is_on:
            (ruler.press if is_clicked else ruler.drag)(result.focus_px)
        elif not (io.key_ctrl and io.key_shift):
            self._session.lens.commands.focus_at(result.focus_px)
        elif is_clicked:
            self._session.time.marks.set_point(result.focus_px)

    def _choose_tile(self, index: int) -> None:
        """Use the lens of the look that was clicked in the grid, and leave the grid."""
        assert self.pictures is not None
        self._session.pictures.looks.go_to(self.pictures.tiles[index].name)
        self._session.pictures.commands.change(compare=Compare.OFF)
