"""One frame of the interface: menus, panels, the picture and the status bar, in that order."""

from imgui_bundle import ImVec2, imgui

from heatlens.errors import HeatlensError
from heatlens.faults import faults_told
from heatlens.ui.actions import pressed
from heatlens.ui.app import App
from heatlens.ui.docked_panels import DockedPanels
from heatlens.ui.files.shot_question import shot_question
from heatlens.ui.keys_window import keys_window
from heatlens.ui.layout import dock_panels, menu_bar
from heatlens.ui.panels.marks_panel import pull_popup
from heatlens.ui.picture_window import PictureWindow
from heatlens.ui.start.start_screen import hears_keys
from heatlens.ui.status_bar import StatusBar
from heatlens.ui.timeline.rendered_panel import rendered_popup

_Window = imgui.WindowFlags_


class Screen:
    """Draws an App with ImGui; holds nothing that matters."""

    def __init__(self, app: App) -> None:
        self._app = app
        self.picture = PictureWindow(app)
        self.status = StatusBar(app)
        self._panels = DockedPanels(app)

    def draw(self) -> None:
        """Draw between ImGui's new_frame and its render; what fails is said, the rest goes on."""
        state = imgui.internal.ErrorRecoveryState()
        imgui.internal.error_recovery_store_state(state)
        try:
            with faults_told("The window could not be drawn"):
                self._draw()
        except HeatlensError as error:
            _close_what_is_open(state)
            self._app.say_error(error)

    def _draw(self) -> None:
        app = self._app
        app.poll()
        hears = hears_keys()  # before a popup takes its Enter and is gone
        self._do_actions()
        is_new_layout = app.wants_layout
        self._frame_window()
        self._panels.draw(self.picture.hovered)
        if is_new_layout:
            for name in ("Lens", "Look"):  # in front of those that share a place with them
                imgui.set_window_focus(name)
        app.turns.update()
        self.picture.draw(hears)
        app.editing.rest(is_held=imgui.is_any_item_active())
        app.color.apply(app.view, app.screen)

    def _do_actions(self) -> None:
        app = self._app
        chosen = menu_bar(app, app.actions)
        is_asked = app.filing.browser.is_open or app.documents.offer is not None
        keyed = () if is_asked else (a for a in pressed(app.actions) if not app.first.sleeps(a))
        for action in (*keyed, chosen, app.palette.draw(app)):
            if action is not None:
                action.do(app)
        if app.shows_keys:
            app.shows_keys = keys_window(app.actions, app.has_scene)
        pull_popup(app)
        rendered_popup(app)
        shot_question(app)
        app.filing.draw()

    def _frame_window(self) -> None:
        """The window that everything docks in, and the status bar under it."""
        app, screen = self._app, imgui.get_main_viewport()
        imgui.set_next_window_pos(screen.work_pos)
        imgui.set_next_window_size(screen.work_size)
        bare = (
            _Window.no_decoration | _Window.no_move | _Window.no_docking | _Window.no_saved_settings
        )
        bare |= _Window.no_bring_to_front_on_focus | _Window.no_nav_focus | _Window.no_background
        imgui.push_style_var(imgui.StyleVar_.item_spacing, ImVec2(0, 0))
        imgui.push_style_var(imgui.StyleVar_.window_padding, ImVec2(0, 0))
        imgui.begin("heatlens", None, bare)
        imgui.pop_style_var()
        status_height = imgui.get_frame_height()
        size = ImVec2(screen.work_size.x, max(screen.work_size.y - status_height, 50.0))
        dock_panels(app.wants_layout, size)
        app.wants_layout = False
        self.status.draw(self.picture.hovered)
        imgui.end()
        imgui.pop_style_var()


def _close_what_is_open(state: imgui.internal.ErrorRecoveryState) -> None:
    """End the windows, menus and styles that a failure left begun: ImGui asserts that none is."""
    io = imgui.get_io()
    before = io.config_error_recovery_enable_assert, io.config_error_recovery_enable_debug_log
    io.config_error_recovery_enable_assert = io.config_error_recovery_enable_debug_log = False
    io.config_error_recovery_enable_tooltip = False
    imgui.internal.error_recovery_try_to_recover_state(state)
    io.config_error_recovery_enable_assert, io.config_error_recovery_enable_debug_log = before
