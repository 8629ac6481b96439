"""Draw the picture with its legend and marks, and apply the mouse gestures in it."""

from dataclasses import replace

from imgui_bundle import ImVec2, imgui

from heatlens.core.model.focus.coc import sharp_px
from heatlens.core.model.view.overlays import entries
from heatlens.core.model.view.view import Compare
from heatlens.core.model.view.view_geometry import geometry
from heatlens.render.display.picture_pass import PlacedPicture
from heatlens.render.display.screen_pictures import ScreenPictures, layer_limits_px
from heatlens.render.gpu.device import Framebuffer, Sampling
from heatlens.studio.board.board import Board
from heatlens.studio.board.requests import FocusAt, MarkAt, MoveCamera, NudgeFocus, TakeLook
from heatlens.studio.session.desks import LensDesk, PictureDesk
from heatlens.studio.session.facts import Facts
from heatlens.studio.session.marks.lessons import Lessons
from heatlens.studio.session.playing.kept_screen import KeptScreen
from heatlens.studio.ui import probe, theme
from heatlens.studio.ui.layout import PICTURE, PICTURE_ALONE
from heatlens.studio.ui.panels.focus_bar import focus_bar, focus_bar_height
from heatlens.studio.ui.panels.marks_panel import draw_point_marks, mark_in_window
from heatlens.studio.ui.picture.fade import PictureFade
from heatlens.studio.ui.picture.grid import Pictures
from heatlens.studio.ui.picture.guides_over import draw_beat, draw_guides
from heatlens.studio.ui.picture.held_alone import HeldAlone
from heatlens.studio.ui.picture.legend import draw_legend, legend_facts
from heatlens.studio.ui.picture.loupe import Loupe, over_flag
from heatlens.studio.ui.picture.notices import StreamNotice, draw_lessons, draw_waiting
from heatlens.studio.ui.picture.pixel_values import draw_ruler
from heatlens.studio.ui.picture.seen_pictures import SeenPictures
from heatlens.studio.ui.picture.viewport import ViewportPanel, ViewportResult
from heatlens.studio.ui.start.start_screen import StartScreen
from heatlens.studio.ui.state import UiState

_WITH_CTRL = (imgui.Key.y, imgui.Key.left_shift, imgui.Key.right_shift)
_LINE_EM = 0.15  # height of the progress line under the picture
_Window = imgui.WindowFlags_


class PictureWindow:
    """Draws the picture, or the start screen or a notice while there is none."""

    def __init__(
        self,
        facts: Facts,
        board: Board,
        desk: PictureDesk,
        lessons: Lessons,
        ui: UiState,
        screen: ScreenPictures,
        kept: KeptScreen,
        lens: LensDesk,
    ) -> None:
        self._facts, self._board, self._desk = facts, board, desk
        self._ui = ui
        self._seen = SeenPictures(facts, desk, screen, kept)
        ctx = desk.renderer.ctx
        self._start = StartScreen(ctx)
        self._notice = StreamNotice()
        self._lessons = lessons
        self._lens = lens.commands
        self._loupe = Loupe(self._lens.look_at, self._lens.names_of)
        self.viewport = ViewportPanel(ctx, desk.view)
        self.hovered: tuple[int, int] | None = None  # pixel of the display window under the pointer
        self.alt = HeldAlone(imgui.Key.mod_alt)
        self.ctrl = HeldAlone(imgui.Key.mod_ctrl, _WITH_CTRL)
        self.fade = PictureFade(ctx)
        self._holds_bar = False  # the focus bar is dragged
        self.pictures: Pictures | None = None  # the pictures shown in this frame

    def draw(self, hears_keys: bool, is_seen: bool = True) -> None:
        """Draw the picture; `hears_keys` is False while a dialog, field or menu takes the keys.

        With `is_seen` False it may show the pictures of the previous frame.
        """
        imgui.push_style_var(imgui.StyleVar_.window_padding, ImVec2(0, 0))
        self._begin()
        imgui.pop_style_var()
        is_held_off = self.alt.is_over(self.hovered is not None)
        self._desk.view.is_lens_held_off = is_held_off
        is_there = self._facts.plate is not None and self._facts.seen is not None
        if is_seen or not is_there:
            self.pictures = self._seen.now()
        if self._ui.files.start_choices.is_wanted:
            self.hovered = None
            self._choose(hears_keys)
            probe.note("picture")
        else:
            room = imgui.get_content_region_avail()
            below = focus_bar_height(room.y) if self._has_focus_bar else 0.0
            corner = imgui.get_cursor_screen_pos()
            with theme.over_picture():
                self._draw_picture(self.pictures, below)
            probe.note("picture")
            if below:
                corner = ImVec2(corner.x, corner.y + room.y - below)
                self._draw_focus_bar(corner, ImVec2(room.x, below))
                self._draw_part_done()
        imgui.end()

    @property
    def _has_focus_bar(self) -> bool:
        facts = self._facts
        return not self._ui.is_bare and facts.histogram is not None and facts.has_lens

    def paint(self, target: Framebuffer, size_px: tuple[int, int]) -> None:
        """Draw the pictures of this frame; call this before ImGui draws over them."""
        self.viewport.paint(target, size_px)
        self.fade.keep(target, size_px)

    def _draw_part_done(self) -> None:
        """Draw the line under the picture that fills while the whole picture is rendered."""
        part, place = self._facts.part_done, self.viewport.place.viewport
        if part:
            (x, y), (width, height) = place.corner, place.size
            low = ImVec2(x, y + height)
            end = ImVec2(x + part * width, low.y + _LINE_EM * imgui.get_font_size())
            imgui.get_window_draw_list().add_rect_filled(low, end, theme.colors.text_dim)
            probe.note_at("part of the picture", (low.x, low.y, end.x, end.y))

    def _draw_focus_bar(self, corner: ImVec2, size: ImVec2) -> None:
        facts, histogram = self._facts, self._facts.histogram
        assert histogram is not None
        lens, pointed = focus_bar(facts, histogram, corner, size)
        self._holds_bar = imgui.is_item_active()
        if pointed is not None:
            self._draw_place_of(pointed)
        if lens != facts.lens:
            self._board.change(lens)

    def _draw_picture(self, pictures: Pictures | None, below: float) -> None:
        """Draw the picture and everything over it, or the reason why there is none."""
        facts, stream = self._facts, self._facts.stream
        if facts.is_black and not facts.plays_kept:
            imgui.text_disabled(f"  Frame {facts.frame} has no file.")
        elif facts.is_waiting and stream is not None:
            draw_waiting(stream)
        elif pictures is None:
            is_coming = facts.plate is not None or facts.opening
            words = "Opening ..." if is_coming else "Nothing is open: Ctrl+O, or drop a file here."
            imgui.text_disabled(f"  {words}")
        else:
            scale = imgui.get_io().display_framebuffer_scale.x or 1.0
            self._apply(self.viewport.draw(pictures, facts.view, scale, below))
            place = self.viewport.place
            seen = facts.seen if facts.is_plain else None
            self.fade.draw(seen, place.viewport, place.geometry)
            self._draw_over(pictures)

    def _draw_over(self, pictures: Pictures) -> None:
        """Draw everything over the picture: guides (one set a cell), marks, legend and lessons.

        While the focus is dragged, words leave the picture free.
        """
        is_dragging = imgui.is_mouse_dragging(imgui.MouseButton_.left)
        is_free = is_dragging and (self._holds_bar or self.viewport.is_focusing)
        view, place = self._facts.view, self.viewport.place
        for cell in self.viewport.cells:
            here = geometry(view, cell, pictures.shape)
            whole = replace(place, viewport=cell, geometry=here)
            draw_guides(view.guides, pictures.shape, whole, self._facts.crop)
        if not pictures.tiles:
            draw_ruler(self._desk.commands.ruler, self._desk.view, self._facts, self.hovered)
        if not (pictures.tiles or is_free):
            draw_point_marks(self._facts, self._desk.view)
            self._legend()
            self._draw_loupe(pictures)
        if self._facts.beats_left:
            draw_beat(self._facts.beats_left, place.viewport)
        if not (self._ui.is_bare or pictures.tiles):
            draw_lessons(self._lessons, self._desk.view.viewport, is_free)
        stream = self._facts.stream
        if stream is not None and stream.is_shown:
            self._notice.draw(stream, self._desk.view.viewport)

    def _draw_loupe(self, pictures: Pictures) -> None:
        """Draw the loupe if it is on or Ctrl is held, unless a button is down or A is compared."""
        facts, ruler, pixel = self._facts, self._desk.commands.ruler, self.hovered
        is_plain = facts.view.compare is Compare.OFF and not (facts.plays_kept or ruler.is_on)
        is_held = self.ctrl.is_over(pixel is not None)
        if is_held and imgui.is_key_pressed(imgui.Key.y, False):
            self._lens.focus_on_other()
        is_shown = is_plain and (facts.view.loupe or is_held)
        if not is_shown or pixel is None or imgui.is_any_mouse_down():
            return
        pinhole, place = self._seen.pinhole(), self._desk.view
        placed = self._loupe.draw(facts, place, pictures, pinhole, pixel)
        if placed is not None:
            self._place_enlarged(placed)

    def _draw_place_of(self, mark: str) -> None:
        """Draw the surroundings of a mark, for its flag on the focus bar, unless A is compared."""
        facts, place, pictures = self._facts, self._desk.view, self.pictures
        at = mark_in_window(facts, place, mark)
        if at is not None and pictures is not None and facts.is_plain and not pictures.tiles:
            self._place_enlarged(over_flag(place, pictures, self._seen.pinhole(), at))

    def _place_enlarged(self, placed: PlacedPicture) -> None:
        placed.texture.sampling = Sampling.LINEAR
        self.viewport.place_over([placed])

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
        choices, opening = self._ui.files.start_choices, self._facts.opening
        answer = self._start.draw(choices.cards(), opening, hears_keys, choices.most_recent)
        if answer.taken is not None and not choices.take(answer.taken):
            self._ui.dialogs.ask("open")
        elif answer.leaves:
            choices.leave()

    def _legend(self) -> None:
        facts, view = self._facts, self._facts.view
        if not view.has_overlay or view.compare is Compare.FLIP or not facts.has_lens:
            return
        plate = self._desk.renderer.loaded.plate
        optics = self._desk.renderer.optics(facts.seen_shot, facts.frame)
        sharp = sharp_px(facts.lens, plate.display_window.width)
        limits = layer_limits_px(optics, facts.seen_shot)
        shown = legend_facts(optics, sharp, limits, plate.depth, view.unit)
        legend = entries(view.overlay, shown, view.peaking if view.is_peaking else None)
        is_right = bool(self._lessons.left)  # the lessons are at the left
        draw_legend(legend, self._desk.view.viewport, is_right)

    def _apply(self, result: ViewportResult) -> None:
        board, self.hovered = self._board, result.hovered_px
        board.change(result.view)
        if result.camera is not None:
            board.do(MoveCamera(result.camera.kind, result.camera.right, result.camera.down))
        if result.focus_notches:
            board.do(NudgeFocus(result.focus_notches))
        if result.tile is not None:
            self._choose_tile(result.tile)
        if result.focus_px is None:
            return
        io, ruler = imgui.get_io(), self._desk.commands.ruler
        is_clicked = imgui.is_mouse_clicked(imgui.MouseButton_.left)
        if ruler.is_on:
            (ruler.press if is_clicked else ruler.drag)(result.focus_px)
        elif not (io.key_ctrl and io.key_shift):
            board.do(FocusAt(*result.focus_px))
        elif is_clicked:
            board.do(MarkAt(*result.focus_px))

    def _choose_tile(self, index: int) -> None:
        """Use the lens of the look that was clicked in the grid, and leave the grid."""
        assert self.pictures is not None
        name = self.pictures.tiles[index].name
        if name:
            self._board.do(TakeLook(name))
        else:
            self._board.change(replace(self._facts.view, compare=Compare.OFF))
