"""Draw the picture with its legend and marks, and apply the mouse gestures in it."""

from collections.abc import Callable
from dataclasses import replace

from imgui_bundle import ImVec2, imgui

from heatlens.core.model.focus.coc import sharp_px
from heatlens.core.model.view.overlays import legend_entries
from heatlens.core.model.view.view import Compare
from heatlens.core.model.view.view_geometry import Viewport, geometry
from heatlens.render.display.picture_pass import PlacedPicture
from heatlens.render.display.screen_pictures import ScreenPictures, layer_limits_px
from heatlens.render.gpu.framebuffer import Framebuffer
from heatlens.render.gpu.resources import Sampling
from heatlens.render.rendered_frames.screen_work import ScreenWork
from heatlens.studio.board.board import Board
from heatlens.studio.board.controls import LensControl, PictureControl, TimeControl
from heatlens.studio.board.lessons import Lessons
from heatlens.studio.board.requests import FocusAt, MarkAt, MoveCamera, NudgeFocus, TakeLook
from heatlens.studio.ui import rects, theme
from heatlens.studio.ui.layout import PICTURE, PICTURE_ALONE
from heatlens.studio.ui.panels.focus_bar import focus_bar, focus_bar_height
from heatlens.studio.ui.panels.marks_panel import draw_point_marks, mark_in_window
from heatlens.studio.ui.picture.fade import PictureFade
from heatlens.studio.ui.picture.grid import Pictures
from heatlens.studio.ui.picture.guides_over import draw_beat, draw_guides
from heatlens.studio.ui.picture.held_alone import HeldAlone
from heatlens.studio.ui.picture.legend import draw_legend, legend_facts
from heatlens.studio.ui.picture.lit_matte import MatteDrawer
from heatlens.studio.ui.picture.loupe import Loupe, draw_flag_loupe
from heatlens.studio.ui.picture.notices import (
    draw_lessons,
    draw_notice,
    draw_problem,
    draw_progress,
    draw_reason,
    has_no_frame,
    has_problem,
)
from heatlens.studio.ui.picture.pixel_values import draw_ruler
from heatlens.studio.ui.picture.seen_pictures import SeenPictures
from heatlens.studio.ui.picture.viewport import ViewportPanel, ViewportResult
from heatlens.studio.ui.start.start_screen import StartScreen
from heatlens.studio.ui.state import UiState

_KEYS_WITH_CTRL = (imgui.Key.y, imgui.Key.left_shift, imgui.Key.right_shift)
_Window = imgui.WindowFlags_


class PictureWindow:
    """Draws the picture, or the start screen or a notice while there is none."""

    def __init__(
        self,
        board: Board,
        control: PictureControl,
        lessons: Lessons,
        ui: UiState,
        screen: ScreenPictures,
        cached_screen: ScreenWork,
        lens: LensControl,
        time: TimeControl,
        is_keyboard_taken: Callable[[], bool],
    ) -> None:
        self._board, self._control = board, control
        self._ui = ui
        self._picture_collector = SeenPictures(board, control, screen, cached_screen)
        ctx = control.renderer.ctx
        self._start_screen = StartScreen(ctx)
        self._lessons = lessons
        self._lens_commands = lens.commands
        self._loupe = Loupe(self._lens_commands.find_surfaces, self._lens_commands.names_of)
        self.viewport = ViewportPanel(ctx, control.view)
        # The pixel of the display window under the pointer.
        self.hovered_px: tuple[int, int] | None = None
        self.alt = HeldAlone(imgui.Key.mod_alt, is_keyboard_taken=is_keyboard_taken)
        self.ctrl = HeldAlone(imgui.Key.mod_ctrl, _KEYS_WITH_CTRL)
        self.fade = PictureFade(ctx)
        self._light, self._matte_drawer = time.marks.light, MatteDrawer(ctx)
        self._is_bar_dragged = False  # the focus bar is dragged
        self.pictures: Pictures | None = None  # the pictures shown in this frame

    def draw(self, has_keyboard: bool, answer: Callable[[], None] | None) -> None:
        """Draw the picture; `has_keyboard` is False while a dialog, field or menu takes the keys.

        `answer` answers what the mouse changes in the window, so that the picture of this frame is
        that of the newest focus. With None it may show the pictures of the previous frame.
        """
        imgui.push_style_var(imgui.StyleVar_.window_padding, ImVec2(0, 0))
        self._begin_window()
        imgui.pop_style_var()
        self._control.view.is_lens_held_off = self.alt.update(self.hovered_px is not None)
        free_size, corner = imgui.get_content_region_avail(), imgui.get_cursor_screen_pos()
        bar_height = focus_bar_height(free_size.y) if self._has_focus_bar else 0.0
        if self._ui.files.start_choices.is_shown:
            self._collect(answer is not None)
            self.hovered_px = None
            self._draw_start_screen(has_keyboard)
            rects.note("picture")
        else:
            pointed_mark = None
            if bar_height:
                bar_corner = ImVec2(corner.x, corner.y + free_size.y - bar_height)
                pointed_mark = self._draw_focus_bar(bar_corner, ImVec2(free_size.x, bar_height))
                imgui.set_cursor_screen_pos(corner)
            with theme.over_picture():
                self._draw_picture(bar_height, answer)
                rects.note("picture")
                if self.pictures is not None and not self._ui.is_bare:
                    draw_notice(self._ui, self._control.view.viewport, has_keyboard)
            self._draw_mark_loupe(pointed_mark)
            if bar_height:
                draw_progress(self._board.facts, self.viewport.picture_view.viewport)
        if not self._hides_words:
            area = Viewport((corner.x, corner.y), (free_size.x, free_size.y - bar_height))
            draw_problem(self._ui, area)
        imgui.end()

    @property
    def _hides_words(self) -> bool:
        """True while the focus is dragged, when words leave the picture."""
        is_dragging = imgui.is_mouse_dragging(imgui.MouseButton_.left)
        return is_dragging and (self._is_bar_dragged or self.viewport.is_focusing)

    def _collect(self, is_visible: bool) -> None:
        """Collect the pictures to show; an invisible frame may keep the previous ones."""
        facts = self._board.facts
        if is_visible or facts.plate is None or facts.shown_picture is None:
            self.pictures = self._picture_collector.collect()

    @property
    def _has_focus_bar(self) -> bool:
        facts = self._board.facts
        return not self._ui.is_bare and facts.histogram is not None and facts.has_lens

    def paint(self, target: Framebuffer, size_px: tuple[int, int]) -> None:
        """Draw the pictures of this frame; call this before ImGui draws over them."""
        self.viewport.paint(target, size_px)
        self.fade.keep_preview(target, size_px)

    def _draw_focus_bar(self, corner: ImVec2, size: ImVec2) -> str | None:
        """Draw the focus bar, change the lens as it was dragged; return the mark pointed at."""
        facts, histogram = self._board.facts, self._board.facts.histogram
        assert histogram is not None
        lens, pointed_mark = focus_bar(facts, histogram, corner, size, self._ui.pull_target)
        self._is_bar_dragged = imgui.is_item_active()
        self._light.pointed_name = pointed_mark
        if lens != facts.lens:
            self._board.change(lens)
        return pointed_mark

    # The mouse acts before the picture is answered and drawn. Otherwise the picture of a frame
    # would be that of the previous position of the hand.
    def _draw_picture(self, bar_height: float, answer: Callable[[], None] | None) -> None:
        """Draw the picture and everything over it, or the reason why there is none."""
        seen = None if has_no_frame(self._board.facts) else self.pictures
        if seen is not None and self._board.facts.plate is not None:
            self._take_input(seen, bar_height)
        if answer is not None:
            answer()
        self._collect(answer is not None)
        if self.pictures is None or has_no_frame(self._board.facts):
            draw_reason(self._board.facts)
            return
        if seen is None:
            self._take_input(self.pictures, bar_height)
        facts, picture_view = self._board.facts, self.viewport.picture_view
        self.viewport.draw(self.pictures, facts.view)
        fading_picture = facts.shown_picture if facts.is_live_alone else None
        self.fade.draw(fading_picture, picture_view.viewport, picture_view.geometry)
        self._draw_over(self.pictures)

    def _take_input(self, pictures: Pictures, bar_height: float) -> None:
        """Apply what the mouse does over the pictures."""
        scale, view = imgui.get_io().display_framebuffer_scale.x or 1.0, self._board.facts.view
        self._apply_gestures(self.viewport.take_input(pictures, view, scale, bar_height))

    def _draw_over(self, pictures: Pictures) -> None:
        """Draw everything over the picture: guides (one set a cell), marks, legend and lessons.

        While the focus is dragged, marks, legend and lessons are hidden.
        """
        hides_words, facts = self._hides_words, self._board.facts
        view, picture_view = facts.view, self.viewport.picture_view
        for cell in self.viewport.cells:
            cell_geometry = geometry(view, cell, pictures.shape)
            cell_view = replace(picture_view, viewport=cell, geometry=cell_geometry)
            draw_guides(view.guides, pictures.shape, cell_view, facts.crop)
        if not pictures.tiles:
            draw_ruler(self._control, facts, self.hovered_px)
        if not (pictures.tiles or hides_words):
            self._matte_drawer.draw(self._light.matte, facts, picture_view)
            draw_point_marks(facts, self._control.view)
            self._draw_legend()
            self._draw_loupe(pictures)
        if facts.beats_left:
            draw_beat(facts.beats_left, picture_view.viewport)
        if not (self._ui.is_bare or pictures.tiles):
            is_hidden = hides_words or has_problem(self._ui)
            draw_lessons(self._lessons, self._control.view.viewport, is_hidden)

    def _draw_loupe(self, pictures: Pictures) -> None:
        """Draw the loupe if it is on or Ctrl is held, unless a button is down or A is compared."""
        facts, ruler, pixel = self._board.facts, self._control.commands.ruler, self.hovered_px
        is_plain = facts.view.compare is Compare.OFF and not (
            facts.plays_cached_frames or ruler.is_on
        )
        is_held = self.ctrl.update(pixel is not None)
        if is_held and imgui.is_key_pressed(imgui.Key.y, False):
            self._lens_commands.focus_on_other()
        is_shown = is_plain and (facts.view.loupe or is_held)
        if not is_shown or pixel is None or imgui.is_any_mouse_down():
            return
        pinhole, picture_view = self._picture_collector.pinhole(), self._control.view
        enlarged = self._loupe.draw(facts, picture_view, pictures, pinhole, pixel)
        if enlarged is not None:
            self._place_enlarged(enlarged)

    def _draw_mark_loupe(self, mark: str | None) -> None:
        """Draw the loupe of a mark whose flag is under the pointer, unless A is compared."""
        facts, picture_view, pictures = self._board.facts, self._control.view, self.pictures
        mark_point = None if mark is None else mark_in_window(facts, picture_view, mark)
        if mark_point is None or pictures is None or pictures.tiles:
            return
        if facts.is_live_alone:
            pinhole = self._picture_collector.pinhole()
            self._place_enlarged(draw_flag_loupe(picture_view, pictures, pinhole, mark_point))

    def _place_enlarged(self, enlarged: PlacedPicture) -> None:
        """Show a picture over the viewport's own, enlarged smoothly."""
        enlarged.texture.sampling = Sampling.LINEAR
        self.viewport.place_over([enlarged])

    def _begin_window(self) -> None:
        """Begin the ImGui window in its dock, or over the whole screen if the picture is alone."""
        fixed_flags = _Window.no_scrollbar | _Window.no_scroll_with_mouse | _Window.no_background
        if not self._ui.is_bare:
            imgui.begin(PICTURE, None, fixed_flags)
            return
        screen = imgui.get_main_viewport()
        imgui.set_next_window_pos(screen.pos)
        imgui.set_next_window_size(screen.size)
        alone_flags = _Window.no_decoration | _Window.no_move | _Window.no_docking
        imgui.begin(PICTURE_ALONE, None, fixed_flags | alone_flags | _Window.no_saved_settings)

    def _draw_start_screen(self, has_keyboard: bool) -> None:
        """Draw the start screen, and open the chosen card or leave."""
        choices, opening = self._ui.files.start_choices, self._board.facts.opening
        answer = self._start_screen.draw(
            choices.cards(), opening, has_keyboard, choices.max_recent_count
        )
        if answer.card is not None and not choices.open_card(answer.card):
            self._ui.dialogs.ask("open")
        elif answer.leaves:
            choices.leave()

    def _draw_legend(self) -> None:
        """Draw the legend of the overlay, if one is shown."""
        facts, view = self._board.facts, self._board.facts.view
        if not view.has_overlay or view.compare is Compare.FLIP or not facts.has_lens:
            return
        plate = self._control.renderer.loaded.plate
        optics = self._control.renderer.optics(facts.seen_shot, facts.frame)
        sharp_width_px = sharp_px(facts.lens, plate.display_window.width)
        limits_px = layer_limits_px(optics, facts.seen_shot)
        numbers = legend_facts(optics, sharp_width_px, limits_px, plate.depth, view.unit)
        legend = legend_entries(view.overlay, numbers, view.peaking if view.is_peaking else None)
        is_right = bool(self._lessons.remaining)  # the lessons are at the left
        draw_legend(legend, self._control.view.viewport, is_right)

    def _apply_gestures(self, result: ViewportResult) -> None:
        """Apply the mouse gestures: view, camera, focus, ruler, marks and tiles."""
        board, self.hovered_px = self._board, result.hovered_px
        board.change(result.view)
        if result.camera is not None:
            board.do(MoveCamera(result.camera.kind, result.camera.right, result.camera.down))
        if result.focus_notches:
            board.do(NudgeFocus(result.focus_notches))
        if result.tile is not None:
            self._choose_tile(result.tile)
        if result.focus_px is None:
            return
        io, ruler = imgui.get_io(), self._control.commands.ruler
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
            self._board.change(replace(self._board.facts.view, compare=Compare.OFF))
