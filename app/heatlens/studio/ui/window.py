"""Run the loop of the window, which draws only when something has changed."""

from collections.abc import Callable, Sequence
from contextlib import closing
from functools import partial

# Both packages bring a libglfw. Whichever is imported first decides which one both of them use:
# imgui-bundle's, version 3.5.1 at the time of writing, or glfw's own 3.4.0. imgui-bundle also sets
# PYGLFW_LIBRARY for the other.
from imgui_bundle import imgui  # import before glfw, so that both share one libglfw

from heatlens.studio.ui.devices import (
    is_keyboard_taken,
    pad_axes,
    screen_name,
    screen_width_px,
    units_scale,
)

import glfw  # isort: skip

from heatlens.core.base.outside_text import printable
from heatlens.core.base.paths import preferences_dir, rendered_frames_dir
from heatlens.core.base.stopping import StopSignals
from heatlens.media.live.ring.sources import PadInput
from heatlens.render.display.front_end import FrontEnd
from heatlens.render.display.screen_pictures import ScreenPictures
from heatlens.render.frame_renderer import FrameRenderer
from heatlens.render.gpu.context import is_software
from heatlens.studio.board.session import Session
from heatlens.studio.board.window_handover import WindowHandover
from heatlens.studio.settings.preferences import WINDOW_LEAST, Preferences
from heatlens.studio.settings.start import Start
from heatlens.studio.share.sharing import Sharing
from heatlens.studio.ui import theme
from heatlens.studio.ui.clean_feed import CleanFeed, fill_screen
from heatlens.studio.ui.devices import GlfwInput
from heatlens.studio.ui.frame_pace import FramePace
from heatlens.studio.ui.input_queue import InputQueue
from heatlens.studio.ui.layout import restore_layout
from heatlens.studio.ui.open_window import open_window, take_wake, wake_window
from heatlens.studio.ui.screen import Screen
from heatlens.studio.ui.window_gpu import WindowGpu, imgui_drawing
from heatlens.studio.ui.work_bar import export_title


# A wait for events without a limit never sees Ctrl-C: Python handles a signal only between two of
# its own instructions. The signals are therefore taken by `StopSignals`, which ends the wait with
# an empty event.
def run_window(start: Start, sharing: Sharing | None = None) -> None:
    """Open the window and return when it is closed; `sharing` shares its session.

    Raise NoWindowError if none can be opened, and Stopped if Ctrl-C in the terminal closed it.
    """
    preferences = Preferences.load(preferences_dir())
    try:
        with closing(open_window(preferences.values)) as window:
            loop = Loop(window, start, preferences, sharing or Sharing(wake=wake_window))
            with (
                closing(WindowHandover(wake_window)) as handover,
                StopSignals(wake_window) as stops,
            ):
                loop.run(stops, handover)
            stops.raise_if_stopped()
    finally:
        glfw.terminate()


class Loop:
    """The main loop: draws the screen after events, and renders the picture in between."""

    def __init__(
        self, gpu: WindowGpu, start: Start, preferences: Preferences, sharing: Sharing
    ) -> None:
        self._gpu = gpu
        self._window = window = gpu.handle
        self._show_background()
        imgui.create_context()
        self._pictures = pictures = ScreenPictures(gpu.device)
        front_end = FrontEnd(wake_window, pictures, True, sharing.shared.other_holder)
        self._session = session = Session(
            *(FrameRenderer(gpu.device), start, front_end, preferences),
            *(rendered_frames_dir(), is_software(gpu.device)),
        )
        self._show_background()  # a window manager may have changed its size
        self._pad = start.lens_in if isinstance(start.lens_in, PadInput) else None
        self._screen = Screen(
            *(session, pictures, sharing, wake_window), partial(is_keyboard_taken, window)
        )
        self._turn = self._screen.turn
        self._pace = FramePace(session, self._turn)
        self._input = InputQueue(self._screen.must_wait_after)
        self._start_imgui()
        self._ui = self._screen.ui
        self._adapt_scale()
        restore_layout(self._ui, preferences.values.layout, preferences.values.layout_em)
        self._feed = CleanFeed(gpu)
        # Size and position before full screen.
        self._window_placement = glfw.get_window_size(window), glfw.get_window_pos(window)
        self._title = ""
        self._session.begin()

    # The window is cleared as soon as it has its size, and once more when the session is made.
    # Otherwise it would be black until the first frame, which waits for shaders to be compiled.
    def _show_background(self) -> None:
        """Show an empty window at once, because compiling the shaders takes some time."""
        glfw.poll_events()
        self._gpu.begin_frame(glfw.get_framebuffer_size(self._window), theme.SURROUND)
        self._gpu.show_frame()

    def run(self, stops: StopSignals, handover: WindowHandover) -> None:
        """Run until the window is closed or a stop signal comes."""
        session = self._session
        while not (self._ui.is_over or stops.number):
            self._wait_for_events()
            self._open_names(handover.pop_names())  # files that another start of heatlens passes on
            if self._pad is not None:
                self._pad.poll(pad_axes)
            if self._screen.sharing.run_requests():
                self._turn.note_input()
            if glfw.window_should_close(self._window):
                self._request_close()
            self._pace.pulse()
            if self._turn.begin_due_frame():
                self._draw_frame()
            is_handing_out = self._input.has_waiting
            glfw.poll_events()  # the input that came while the frame was drawn
            if take_wake():  # a thread with results, which the frame did not see
                self._turn.draw_soon()
            # Also between frames, so that a moving pointer cannot prevent rendering.
            if not is_handing_out:
                self._turn.work(is_input_newer=self._input.has_waiting)
        self._save_preferences()
        self._feed.close()
        self._screen.sharing.sharing.end()
        session.close()
        self._imgui.close()
        imgui.backends.glfw_shutdown()
        imgui.destroy_context()

    # Closing overtakes the input that waits, but never a save, which is done first. Otherwise, on a
    # busy machine, the window would close minutes after the last key, when all typed input has been
    # handled.
    def _request_close(self) -> None:
        """End the program, after input that saves; an export that is running asks first."""
        self._input.drop_after_save()
        if not self._input.has_waiting_save:
            glfw.set_window_should_close(self._window, False)
            self._ui.quit()
            self._pace.note_event()

    def _wait_for_events(self) -> None:
        """Handle events; sleep until the next one if there is nothing to do."""
        picture = self._screen.picture
        wait_s = self._pace.seconds_to_sleep(
            self._ui.seconds_until_needed(),
            *(part.seconds_until_needed() for part in (picture.alt, picture.ctrl, picture.fade)),
            self._screen.sharing.seconds_until_needed(),
        )
        if wait_s == 0.0:
            glfw.poll_events()
            return
        if not self._session.lens.ring.is_turning:  # the next turn of the loop handles it
            self._save_preferences()
        if wait_s is None:
            glfw.wait_events()
        else:
            glfw.wait_events_timeout(wait_s)
        take_wake()
        self._turn.draw_soon()  # a thread with results also wakes the loop

    def _save_preferences(self) -> None:
        """Store window size and panels in the preferences, which are written if they changed."""
        is_maximized = bool(glfw.get_window_attrib(self._window, glfw.MAXIMIZED))
        is_full = bool(glfw.get_window_monitor(self._window))
        is_normal = not is_full and not glfw.get_window_attrib(self._window, glfw.ICONIFIED)
        window_fields: dict[str, object] = {"is_maximized": is_maximized} if is_normal else {}
        size = glfw.get_window_size(self._window)
        if is_normal and not is_maximized and min(size) >= WINDOW_LEAST:
            window_fields["window_size"] = size
        hidden_panels = self._ui.hidden_panels
        if self._ui.timeline.height_before is None:  # it has grown only for the curve
            layout = imgui.save_ini_settings_to_memory()
            window_fields |= {"layout": layout, "layout_em": self._ui.scale.em}
        self._session.save_preferences(hidden_panels=hidden_panels, **window_fields)

    def _draw_frame(self) -> None:
        """Hand out input to ImGui, and draw the window unless more input waits."""
        self._adapt_to_monitor()
        self._imgui.begin_frame()
        imgui.backends.glfw_new_frame()
        self._input.hand_out()
        is_visible = not self._input.has_waiting
        imgui.new_frame()
        self._screen.typed_keys = self._input.typed_keys
        show = self._show_frame if is_visible else imgui.end_frame
        is_new = self._screen.make_frame(show, is_visible)
        if self._screen.picture.pictures is None:
            self._pictures.prepare()
        # Panels show facts of a new picture one frame later, but the next sample of a turning ring
        # is more urgent.
        has_more = self._pictures.take_request() or is_new
        if has_more and not self._session.lens.ring.is_turning:
            self._turn.draw_soon()

    # A pass of heatlens paints the picture under ImGui; it is not an image of ImGui. The backend of
    # imgui-bundle sets its own samplers, and the backgrounds of windows as large as the screen took
    # 30 of 48 ms of a frame on a software rasterizer, so the windows over the picture have no
    # background.
    def _show_frame(self) -> None:
        """Bring the frame to the screen, the second window, the pages and the title."""
        imgui.render()
        size = glfw.get_framebuffer_size(self._window)
        target = self._gpu.begin_frame(size, theme.SURROUND)
        if min(size) > 0:  # it is not minimised
            self._screen.picture.paint(target, size)
            self._imgui.draw(target)
        self._gpu.show_frame()
        pictures, view = self._screen.picture.pictures, self._session.pictures.view.state
        self._ui.has_feed = self._feed.draw(
            self._ui.has_feed, pictures, view, self._ui.has_feed_labels
        )
        self._screen.publish()
        self._update_title()

    # The size and position of the window are stored at the moment before the switch to full screen,
    # so that the window comes back at the same place.
    def _adapt_to_monitor(self) -> None:
        """Adapt scale and full screen to the monitor; remember where a normal window was."""
        self._adapt_scale()
        is_full = bool(glfw.get_window_monitor(self._window))
        if is_full != self._ui.is_full_screen:
            if not is_full:
                self._window_placement = (
                    glfw.get_window_size(self._window),
                    glfw.get_window_pos(self._window),
                )
            fill_screen(self._window, not is_full, *self._window_placement)

    def _adapt_scale(self) -> None:
        """Adapt the scale of the interface to the monitor that the window is on."""
        scale = self._ui.scale
        scale.screen_scale = units_scale(self._window)
        scale.screen = screen_name(self._window)
        scale.screen_width_px = screen_width_px(self._window)
        scale.apply()

    def _update_title(self) -> None:
        """Set the window title to the name of the open source, once it is shown."""
        session = self._session
        if session.pictures.live.output is not None and session.source.plate is not None:
            name = session.files.window_title
            title = f"{export_title(session.files.exports.run.state)}{name} - heatlens"
            if title != self._title:
                self._title = title
                glfw.set_window_title(self._window, printable(title))

    def _watch_events(self) -> None:
        """Request frames after any event."""
        note_event: Callable[..., None] = lambda *_: self._pace.note_event()  # noqa: E731
        GlfwInput(self._window, queue=self._input, wake=self._pace.note_event)
        for register in (
            glfw.set_framebuffer_size_callback,
            glfw.set_window_refresh_callback,
            glfw.set_window_content_scale_callback,
        ):
            register(self._window, note_event)
        glfw.set_drop_callback(self._window, self._open_dropped)  # type: ignore[arg-type]  # see stub

    def _open_names(self, names: list[str]) -> None:
        """Open the files that a later command line named, and bring the window to the front."""
        if names:
            self._pace.note_event()
            self._session.files.commands.open_named(names)
            if glfw.get_window_attrib(self._window, glfw.ICONIFIED):
                glfw.restore_window(self._window)
            glfw.focus_window(self._window)
            glfw.request_window_attention(self._window)

    def _open_dropped(self, _window: object, paths: Sequence[str]) -> None:
        """Open files that were dropped on the window."""
        self._pace.note_event()
        if paths:
            self._session.files.commands.open_dropped([str(path) for path in paths])

    def _start_imgui(self) -> None:
        """Configure ImGui, and connect it to the window and to what draws it."""
        io = imgui.get_io()
        io.config_flags |= imgui.ConfigFlags_.docking_enable
        io.config_mac_osx_behaviors = False  # our input exchanges Cmd and Ctrl already
        io.set_ini_filename("")
        self._watch_events()
        self._imgui = imgui_drawing(self._gpu.device)
