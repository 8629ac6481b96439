"""Draw one frame of the interface: menus, panels, the picture and the status bar."""

from collections.abc import Callable, Sequence
from functools import partial

from imgui_bundle import ImVec2, imgui

from heatlens.core.base.errors import HeatlensError
from heatlens.core.base.faults import report_faults
from heatlens.core.model.shot.pull import RecordingState
from heatlens.render.display.screen_pictures import ScreenPictures
from heatlens.studio.board.board import Board
from heatlens.studio.board.command import Command
from heatlens.studio.board.lessons import Lessons
from heatlens.studio.board.loop_turn import LoopTurn
from heatlens.studio.board.session import Session
from heatlens.studio.share.sharing import Sharing
from heatlens.studio.ui import topmost
from heatlens.studio.ui.docked_panels import DockedPanels
from heatlens.studio.ui.files.questions import draw_questions
from heatlens.studio.ui.keys_window import keys_window
from heatlens.studio.ui.layout import dock_panels, grow_for_curve, menu_bar, shrink_large_panels
from heatlens.studio.ui.panels.marks_panel import pull_popup
from heatlens.studio.ui.picture_window import PictureWindow
from heatlens.studio.ui.seek import forget_after_click
from heatlens.studio.ui.setting_places import setting_places, settings
from heatlens.studio.ui.sharing import WindowSharing
from heatlens.studio.ui.shortcuts import in_order, opens, pressed
from heatlens.studio.ui.start.start_screen import has_keyboard
from heatlens.studio.ui.state import UiState
from heatlens.studio.ui.status_bar import StatusBar
from heatlens.studio.ui.timeline.rendered_panel import rendered_popup
from heatlens.studio.ui.window_commands import window_commands

_Window = imgui.WindowFlags_
_DOCKING_FRAMES = 3  # after a panel was docked; until then its tab is cut off
# Menus whose shortcuts work on the start screen; those of the other menus need a picture.
_START_SCREEN_MENUS = ("File", "Window", "Help")


class Screen:
    """Draws a Session with ImGui; all lasting state is in the session."""

    def __init__(
        self,
        session: Session,
        pictures: ScreenPictures,
        sharing: Sharing,
        wake: Callable[[], None] = lambda: None,
        is_keyboard_taken: Callable[[], bool] = lambda: False,
    ) -> None:
        """Create the screen with the pictures that the session's `FrontEnd` has, and its `sharing`.

        Threads call `wake` to have the window drawn again.

        `is_keyboard_taken` returns True while another program has grabbed the keyboard.
        """
        self._session = session
        self.turn = LoopTurn(session)
        self._board = board = Board(session, self._make_still)
        files, time, control = session.files, session.time, session.pictures
        self.sharing = WindowSharing(session, board, sharing)
        self.ui = UiState(time, files, session.preferences, session.messages, wake, self.sharing)
        self.commands = board.with_commands_of(window_commands(self.ui))
        self.typed_keys: Sequence[
            imgui.Key
        ] = ()  # keys that went down in this frame, in their order
        self._hears_keys = False  # the keys of this frame are for the picture
        self._had_timeline = False  # in the last frame
        self._pictures, cached_screen = pictures, time.frames_ahead.screen
        lessons = Lessons(session.editing, time.marks)
        self.picture = PictureWindow(
            *(board, control, lessons, self.ui, self._pictures, cached_screen),
            *(session.lens, session.time, is_keyboard_taken),
        )
        self.status = StatusBar(board, control, self.ui, cached_screen)
        self._panels = DockedPanels(session, board, self.ui, self._pictures)

    def _make_still(self) -> str | None:
        return self._panels.stills.make_still(self.picture.pictures)

    def must_wait_after(self, key: imgui.Key, mods: int) -> bool:
        """Return True if keys typed after this one must wait for its effect."""
        is_covered = topmost.is_any_open() or self._session.files.documents.offer is not None
        is_not_in_picture = (
            is_covered or self.ui.is_bare or self._session.files.start_choices.is_shown
        )
        return is_not_in_picture or opens(self.commands, key, mods)

    def make_frame(self, show: Callable[[], None], is_visible: bool = True) -> bool:
        """Make a frame after ImGui's new_frame; return True if it has a new picture.

        `show` brings what ImGui has drawn to the screen. With `is_visible` False the frame stays
        invisible, since more input waits: it collects no results of threads and makes no picture.
        """

        has_panels = False

        def draw_panels() -> None:
            nonlocal has_panels
            has_panels = _draw_safely(self._session, self._draw_panels)

        def draw_and_show() -> None:
            if has_panels:  # else the picture's window would leave its place among them
                _draw_safely(self._session, partial(self._draw_picture, is_visible))
            show()

        return self.turn.make_frame(draw_panels, draw_and_show, _is_held, is_visible)

    def publish(self) -> None:
        """Give the picture of this frame to the pages that share it."""
        self.sharing.publish(self.picture.pictures, self._pictures.transform_version)

    def _draw_panels(self) -> None:
        """Carry out the commands of keys and menus, and draw everything but the picture."""
        self.ui.theme.apply()
        self._hears_keys = has_keyboard()  # before a popup can handle Enter and close
        topmost.close_escaped()
        forget_after_click()
        self._do_commands()
        is_new_layout = self.ui.wants_layout
        self._draw_main_window()
        if not self.ui.is_bare:
            self._panels.draw(self.picture.hovered_px, self.picture.pictures)
            self._fit_panels()
            session, ui = self._session, self.ui
            shows_curve = session.time.keys.rows.shows_curve and ui.is_timeline_shown
            grow_for_curve(ui.timeline, shows_curve, imgui.get_main_viewport().work_size.y)
        if self._had_timeline != self.ui.is_timeline_shown:
            self._had_timeline = self.ui.is_timeline_shown
            self.turn.draw_soon(_DOCKING_FRAMES)
        if is_new_layout:
            imgui.set_window_focus("Lens")  # in front of the other tabs
        # Again, for samples that arrived while the panels were drawn.
        self._session.lens.ring.poll()

    def _draw_picture(self, is_visible: bool) -> None:
        """Draw the picture, with what lies over it."""
        self.picture.draw(self._hears_keys, self._session.update if is_visible else None)
        topmost.note_frame()

    def _fit_panels(self) -> None:
        """Leave room for the picture if the panels have just become larger."""
        if self.ui.scale.is_new:
            self.ui.scale.is_new = False
            shrink_large_panels(self.ui.panels)

    def _do_commands(self) -> None:
        """Carry out the commands chosen by key, in the menu or in the palette; draw the popups."""
        session, ui = self._session, self.ui
        if not topmost.is_any_open() and imgui.is_key_pressed(imgui.Key.escape, False):
            self._leave_mode()
        keyed = self._actions_of_keys()
        chosen = None if ui.is_bare else menu_bar(session.files, ui, self.commands)
        for command in (*keyed, chosen, self._draw_palette()):
            if command is not None:
                self._board.do(command)
        self._draw_popups()

    def _leave_mode(self) -> None:
        """Discard a recording, switch off the ruler, leave a notice or a mode of the picture."""
        session, notice = self._session, self._session.files.notices.first
        if session.time.recording.state is not RecordingState.OFF:
            if not imgui.get_io().want_text_input:
                session.time.recording.discard()
        elif session.pictures.commands.leave_mode():
            pass
        elif notice is not None and self.picture.pictures is not None and not self.ui.is_bare:
            self.ui.messages.clear()
            session.files.notices.answer(notice)
        else:
            self.ui.leave_bare()

    def _actions_of_keys(self) -> list[Command]:
        """Return the commands of pressed keys, in order; Fit over the curve fits that instead."""
        if topmost.is_any_open() or self._session.files.documents.offer is not None:
            return []
        key_actions = in_order(
            (it for it in pressed(self.commands) if not self._is_blocked_by_start_screen(it)),
            self.typed_keys,
        )
        view = self.ui.timeline
        if view.is_hovered and any(command.name == "Fit" for command in key_actions):
            view.toggle_fit()
            key_actions = [command for command in key_actions if command.name != "Fit"]
        view.is_hovered = False  # the curve editor sets it again when drawn
        return key_actions

    def _draw_popups(self) -> None:
        """Draw the popups, dialogs and questions that are open."""
        session, ui = self._session, self.ui
        if ui.shows_keys:
            ui.shows_keys = keys_window(self.commands, session.source.has_camera)
        pull_popup(session.time, ui, session.pictures.view.state.unit)
        rendered_popup(session.time, ui.timeline)
        draw_questions(ui, session.files.exports.run)
        ui.dialogs.draw()
        self.sharing.draw_popup()

    def _draw_palette(self) -> Command | None:
        """Draw the palette, which also lists settings if a picture is open."""
        palette = self.ui.palette
        has_settings = palette.is_open and self._session.source.plate is not None
        return palette.draw((*self.commands, *(self.settings() if has_settings else ())))

    def settings(self) -> tuple[Command, ...]:
        """Return a command for each setting of the panels, and for each value that it can have."""
        session, board = self._session, self._board
        views = session.pictures.color.views(board.facts.view.display)
        place_actions = setting_places(board, session.time, self.ui)
        return (*place_actions, *settings(board, views, self.ui))

    def _is_blocked_by_start_screen(self, command: Command) -> bool:
        """Return True if the start screen is shown and may use the command's key itself."""
        return (
            self._session.files.start_choices.is_shown and command.menu not in _START_SCREEN_MENUS
        )

    def _draw_main_window(self) -> None:
        """Draw the window with the dock space, and the status bar under it."""
        screen = imgui.get_main_viewport()
        imgui.set_next_window_pos(screen.work_pos)
        imgui.set_next_window_size(screen.work_size)
        flags = (
            _Window.no_decoration | _Window.no_move | _Window.no_docking | _Window.no_saved_settings
        )
        flags |= _Window.no_bring_to_front_on_focus | _Window.no_nav_focus | _Window.no_background
        imgui.push_style_var(imgui.StyleVar_.item_spacing, ImVec2(0, 0))
        imgui.push_style_var(imgui.StyleVar_.window_padding, ImVec2(0, 0))
        imgui.begin("heatlens", None, flags)
        imgui.pop_style_var()
        status_height = imgui.get_frame_height()
        size = ImVec2(screen.work_size.x, max(screen.work_size.y - status_height, 50.0))
        dock_panels(self.ui.wants_layout, size, self.ui.is_bare)
        self.ui.wants_layout = False
        if not self.ui.is_bare:
            self.status.draw(self.picture.hovered_px)
        imgui.end()
        imgui.pop_style_var()


def _is_held() -> bool:
    """Return True while a control or a button of the mouse is held."""
    return imgui.is_any_item_active() or any(imgui.is_mouse_down(button) for button in range(3))


def _draw_safely(session: Session, draw: Callable[[], None]) -> bool:
    """Call a function that draws, and return True if it has ended without an error.

    An error is shown as a message, and leaves nothing of ImGui open.
    """
    state = imgui.internal.ErrorRecoveryState()
    imgui.internal.error_recovery_store_state(state)
    try:
        with report_faults("The window could not be drawn"):
            draw()
    except HeatlensError as error:
        _recover_from_error(state)
        session.show_error(error)
        return False
    return True


# An error in a panel leaves windows, menus and styles of ImGui open, and its next frame would stop
# the program with an assertion. The recovery that ImGui has for other languages closes them. Its
# own reports are switched off, because the status bar shows the error.
def _recover_from_error(state: imgui.internal.ErrorRecoveryState) -> None:
    """Close windows, menus and styles that an error left open; ImGui asserts there are none."""
    io = imgui.get_io()
    old_settings = io.config_error_recovery_enable_assert, io.config_error_recovery_enable_debug_log
    io.config_error_recovery_enable_assert = io.config_error_recovery_enable_debug_log = False
    io.config_error_recovery_enable_tooltip = False
    imgui.internal.error_recovery_try_to_recover_state(state)
    io.config_error_recovery_enable_assert, io.config_error_recovery_enable_debug_log = old_settings
