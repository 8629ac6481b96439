"""The whole interface without a window: ImGui on a device, with injected mouse and keys."""

import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

import numpy as np
from imgui_bundle import imgui

from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.render.display.front_end import FrontEnd
from heatlens.render.display.screen_pictures import ScreenPictures
from heatlens.render.frame_renderer import FrameRenderer
from heatlens.render.gpu.context import is_software
from heatlens.render.gpu.device import Device
from heatlens.render.gpu.framebuffer import Framebuffer
from heatlens.studio.board.command import Command
from heatlens.studio.board.session import Session
from heatlens.studio.settings.preferences import Preferences
from heatlens.studio.settings.start import Start
from heatlens.studio.share.sharing import Sharing
from heatlens.studio.ui import rects, seek, theme
from heatlens.studio.ui.screen import Screen
from heatlens.studio.ui.window_gpu import imgui_drawing

SIZE = (1280, 800)
Point = tuple[float, float]


class Gui:
    """A Session and its Screen, with methods that simulate mouse and keys."""

    def __init__(
        self,
        ctx: Device,
        start: Start,
        size: Point = SIZE,
        preferences: Preferences | None = None,
        scale: float = 1.0,
        frames_folder: Path | None = None,
    ) -> None:
        """Create the session; `scale` is the number of screen pixels per unit of the window."""
        self.ctx = ctx
        self.size = size
        self.pixels = round(size[0] * scale), round(size[1] * scale)
        self.io = imgui.get_io()
        self.io.set_ini_filename("")
        self.io.display_size = size
        self.io.display_framebuffer_scale = scale, scale
        self.io.delta_time = 1 / 60
        self.io.config_flags |= imgui.ConfigFlags_.docking_enable
        theme.apply()
        self._imgui = imgui_drawing(ctx)
        self._texture = ctx.texture(self.pixels, 4)
        self._target = ctx.framebuffer([self._texture])
        # frames nobody looks at cost no pixels
        self._corner = ctx.framebuffer([ctx.texture((8, 8), 4)])
        pictures, sharing = ScreenPictures(ctx), Sharing()
        self.session = Session(
            renderer=FrameRenderer(ctx),
            start=start,
            front_end=FrontEnd(screen=pictures, other_holder=sharing.shared.other_holder),
            preferences=preferences,
            frames_folder=frames_folder,
            is_software=is_software(ctx),
        )
        self.screen = Screen(self.session, pictures, sharing)
        speed = self.session.time.speed
        speed.note_frame = lambda *_: None  # type: ignore[method-assign]  # no load changes a test
        self.screen.picture.fade.length_s = 0.0  # a picture is there at once
        self.session.pictures.sides.rehearsal.most_tries = 0  # it drew a picture more in each test
        self.session.begin()
        self.ui = self.screen.ui
        self._listening = rects.listening()
        self.drawn = self._listening.__enter__()  # where each control was drawn last

    def frame(self, count: int = 1) -> None:
        """Draw `count` frames, and check for errors of the device after each."""
        for _ in range(count):
            self.ui.scale.apply()
            self.begin_imgui_frame()
            self.screen.make_frame(self._show)

    def begin_imgui_frame(self) -> None:
        self._imgui.begin_frame()
        imgui.new_frame()

    def _show(self) -> None:
        imgui.render()
        self._paint(self._corner)
        # As a window does when it swaps: what waits to be drawn takes memory in llvmpipe.
        self.ctx.finish()

    def _paint(self, target: Framebuffer) -> None:
        target.use()
        target.clear(*theme.SURROUND)
        self.screen.picture.paint(target, self.pixels)
        self._imgui.draw(target)
        assert self.ctx.error == ""

    def until(self, condition, label: str, seconds: float = 20.0) -> None:
        """Draw frames until `condition()` is true; fail after `seconds`, a generous limit."""
        end, message = time.monotonic() + seconds, ""
        while not condition():
            message = self.session.messages.text or message
            assert time.monotonic() < end, f"{label} never came. {message}"
            self.frame()
            for _ in range(8):  # the window works on without a frame while nothing is new
                self.session.work()
            time.sleep(0.001)  # threads have their turn, as they have while a window swaps

    def opened(self) -> None:
        self.until(lambda: self.session.pictures.live.output is not None, "a picture")
        self.frame(3)

    def settled(self) -> None:
        """Draw frames until the whole picture is rendered and on the screen."""
        self.until(lambda: not self.session.time.scheduler.is_rendering, "the whole picture", 60.0)
        self.frame(2)

    def rect(self, name: str) -> tuple[float, float, float, float]:
        return self.drawn[name]

    def middle(self, name: str) -> Point:
        x0, y0, x1, y1 = self.rect(name)
        return (x0 + x1) / 2, (y0 + y1) / 2

    def move(self, at: Point) -> None:
        self.io.add_mouse_pos_event(*at)
        self.frame()

    def press(self, at: Point, button: int = 0) -> None:
        self.move(at)
        self.io.add_mouse_button_event(button, True)
        self.frame()

    def release(self, button: int = 0) -> None:
        self.io.add_mouse_button_event(button, False)
        self.frame(2)

    def click(self, at: Point, button: int = 0) -> None:
        self.press(at, button)
        self.release(button)

    def drag(self, start: Point, end: Point, button: int = 0, steps: int = 4) -> None:
        self.press(start, button)
        for i in range(1, steps + 1):
            part = i / steps
            self.move(
                (start[0] + part * (end[0] - start[0]), start[1] + part * (end[1] - start[1]))
            )
        self.release(button)

    def wheel(self, at: Point, notches: float) -> None:
        self.move(at)
        self.io.add_mouse_wheel_event(0.0, notches)
        self.frame(2)

    def hold(self, key: imgui.Key, down: bool = True) -> None:
        self.io.add_key_event(key, down)
        self.frame()

    def key(self, key: imgui.Key, ctrl: bool = False, shift: bool = False) -> None:
        """Press and release a key, with modifiers."""
        for mod, is_held in ((imgui.Key.mod_ctrl, ctrl), (imgui.Key.mod_shift, shift)):
            if is_held:
                self.hold(mod)
        self.hold(key)
        self.hold(key, down=False)
        for mod, is_held in ((imgui.Key.mod_ctrl, ctrl), (imgui.Key.mod_shift, shift)):
            if is_held:
                self.hold(mod, down=False)

    def type(self, text: str) -> None:
        self.io.add_input_characters_utf8(text)
        self.frame(2)

    def do(self, name: str) -> None:
        """Run an action by its name."""
        self.screen._board.do(next(a for a in self.screen.commands if a.name == name))
        self.frame(2)

    def choose_in_menu(self, command: Command) -> None:
        """Choose a command in its menu, or in the submenu where it stands, with the mouse."""
        self.click(self.middle(f"menu {command.menu}"))
        if command.submenu:
            self.click(self.middle(f"menu {command.submenu}"))
        self.click(self.middle(f"item {command.name}"))

    def unfolded(self, header: str, control: str) -> None:
        """Open a header of a panel unless its control is drawn."""
        self.drawn.pop(control, None)
        self.frame()
        if control not in self.drawn:
            self.click(self.middle(header))
            self.frame(2)

    def rest(self) -> None:
        """End the current gesture of the history, as a pause would."""
        self.session.editing.history = self.session.editing.history.end_gesture()
        self.frame()

    def undo_count(self) -> int:
        """Let the input rest, then return the number of steps that undo can go back."""
        self.rest()
        return len(self.session.editing.history.past)

    def later(self) -> None:
        """Let half a second pass, so that a click is no double click any more."""
        self.io.delta_time = 0.5
        self.frame()
        self.io.delta_time = 1 / 60

    def begin_again(self) -> None:
        """Reset the window: no keys held, no popups open, the first plate read again."""
        session = self.session
        self.io.clear_input_keys()
        for button in range(3):
            self.io.add_mouse_button_event(button, False)
        self.io.add_mouse_pos_event(-1e4, -1e4)
        for _ in range(3):  # a popup over a dialog, say
            self.key(imgui.Key.escape)
        imgui.internal.clear_active_id()
        self.ui.shows_keys = self.ui.is_over = False
        self.ui.scale.reset()
        self.ui.leave_bare()
        self.ui.has_feed = False
        session.time.timeline.playback.stop()
        session.pictures.references.current = None
        session.pictures.renderer.stopwatch.is_on = False
        session.pictures.view.state = session.pictures.color.limit_to_config(
            session.given.start.view
        )
        self.ui.reset_layout()
        self.open(session.given.start.source)
        session.editing.begin(
            replace(
                session.facts.shot,
                lens=session.lens.commands.start_lens.lens,
                defocus=session.given.start.defocus,
            )
        )
        session.pictures.view.state = replace(session.facts.view, zoom=None, center_px=None)
        session.messages.clear()
        self.frame(3)

    def open(self, source: Path | str, options: PlateOptions | None = None) -> None:
        """Open another plate and wait for its picture."""
        picture, opener = self.session.source.picture, self.session.source.opener
        version_before = picture.version
        self.session.files.commands.open(str(source), options)
        # A frame that was awaited before counts as a version too, but not as what is opened.
        self.until(lambda: opener.opening is None and picture.version > version_before, "the plate")
        self.frame(3)

    def screenshot(self) -> np.ndarray:
        """Return (H, W, 3) bytes of the screen as the last frame drew it, the top row first."""
        self._paint(self._target)
        pixels = np.frombuffer(self._target.read(components=3), np.uint8)
        return pixels.reshape(self.pixels[1], self.pixels[0], 3)[::-1]

    def at_picture(self, x: float, y: float) -> Point:
        """Return the window position of a point of the picture."""
        return self.session.pictures.view.geometry.window_at_picture((x, y))

    def close(self) -> None:
        self._listening.__exit__(None, None, None)
        seek.show_setting("", "")  # no other window highlights what this one did
        self.session.close()
        self._imgui.close()
        # the device binds again what was bound before: something that stays must be
        self.ctx.framebuffer([self.ctx.texture((1, 1), 4)]).use()
        self._corner.release()
        self._target.release()
        self._texture.release()


@contextmanager
def gui_of(
    ctx: Device,
    source: Path | str,
    preferences: Preferences | None = None,
    size: tuple[int, int] = SIZE,
    scale: float = 1.0,
    frames_folder: Path | None = None,
    **start: object,
) -> Iterator[Gui]:
    """Yield a Gui with its own ImGui, the first picture on the screen."""
    previous_context, context = imgui.get_current_context(), imgui.create_context()
    imgui.set_current_context(context)
    begin = Start(str(source), **start)  # type: ignore[arg-type]
    gui = Gui(ctx, begin, size, preferences, scale, frames_folder)
    try:
        gui.opened()
        yield gui
    finally:
        gui.close()
        imgui.destroy_context(context)
        if previous_context is not None:
            imgui.set_current_context(previous_context)
