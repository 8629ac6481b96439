"""The whole picture fades in over its preview; a line under it shows its render progress."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest
from imgui_bundle import imgui

from heatlens.core.model.shot.settings import Bokeh, DefocusSettings, Quality
from heatlens.render.gpu.device import Device
from heatlens.render.preview.shown import ShownPicture
from heatlens.studio.ui.picture.fade import FADE_S, PictureFade
from support.gui import Gui, gui_of
from support.session_files import room_file


@pytest.fixture
def gui(session_context: Device, tmp_path) -> Iterator[Gui]:
    whole = DefocusSettings(Bokeh.DISC, Quality.DRAFT)
    with gui_of(session_context, room_file(tmp_path / "room.exr"), defocus=whole) as gui:
        gui.settled()
        yield gui


class FadeScreen:
    """The window with a `PictureFade` whose clock only the test moves."""

    def __init__(self, gui: Gui, monkeypatch: pytest.MonkeyPatch) -> None:
        self.gui, self.clock_s = gui, 10.0
        self.fade = PictureFade(gui.ctx, lambda: self.clock_s)
        gui.screen.picture.fade = self.fade
        gui.session.pictures.view.state = replace(gui.session.facts.view, pixel_grid=False)
        self.whole = gui.session.pictures.live.output
        assert self.whole is not None and self.whole.is_whole
        black = gui.ctx.texture(self.whole.texture.size, 4, dtype="f2")
        black.write(np.zeros((*self.whole.texture.size[::-1], 4), np.float16))
        quicker = replace(self.whole.settings, proxy=0.5)
        self.preview = replace(self.whole, texture=black, settings=quicker)
        monkeypatch.setattr(gui.screen.picture._picture_collector, "_detail", lambda *_: None)

    def show(self, picture: ShownPicture) -> None:
        """Show a picture for a frame."""
        live = self.gui.session.pictures.live
        self.gui.session.editing.begin(picture.shot)
        live.output, live._work = picture, None
        live._request = replace(picture.picture_key, settings=picture.shot.defocus)
        self.gui.frame()

    def measure_brightness(self, picture: ShownPicture) -> float:
        """Show a picture for a frame; return the mean of its pixels on the screen."""
        self.show(picture)
        (x, y), (width, height) = (
            self.gui.session.pictures.view.viewport.corner,
            self.gui.session.pictures.view.viewport.size,
        )
        x, y, end_x, end_y = (int(v) for v in (x, y, x + width, y + height))
        return float(self.gui.screenshot()[y : end_y - 4, x:end_x].mean())


@pytest.fixture
def screen(gui, monkeypatch) -> FadeScreen:
    return FadeScreen(gui, monkeypatch)


def test_whole_picture_fades_in_over_its_preview_within_fade_s(screen):
    end = screen.measure_brightness(screen.whole)
    brightness = [screen.measure_brightness(screen.preview)]
    for fraction in (0.0, 0.25, 0.5, 0.75, 1.01):
        screen.clock_s = 10.0 + fraction * FADE_S
        brightness.append(screen.measure_brightness(screen.whole))
        assert (screen.fade.seconds_until_needed() is None) == (fraction > 1.0)
    assert brightness[1] == pytest.approx(brightness[0], abs=0.5) and brightness[-1] == end
    rises = np.diff(brightness[1:])
    assert np.all(rises > 0.15 * (end - brightness[0]))


def test_picture_of_another_lens_is_shown_without_a_fade(screen):
    other_shot = replace(screen.whole.shot, lens=replace(screen.whole.shot.lens, f_stop=7.0))
    end = screen.measure_brightness(replace(screen.whole, shot=other_shot))
    screen.measure_brightness(screen.preview)
    assert screen.measure_brightness(replace(screen.whole, shot=other_shot)) == end
    assert screen.fade.seconds_until_needed() is None


def test_held_button_fades_only_after_a_preview_shown_twice(screen, monkeypatch):
    """While a button is held, the copy for a fade is made only for a preview shown twice.

    The copy takes a processor long, and the next preview follows at once.
    """
    monkeypatch.setattr(imgui, "is_mouse_down", lambda button: button == 0)
    for times, fades in ((1, False), (2, True)):
        screen.show(screen.whole)
        for _ in range(times):
            screen.show(screen.preview)
        screen.show(screen.whole)
        assert (screen.fade.seconds_until_needed() is not None) is fades


def test_zoom_ends_a_fade(screen):
    screen.measure_brightness(screen.preview)
    screen.measure_brightness(screen.whole)
    assert screen.fade.seconds_until_needed() is not None
    screen.gui.session.pictures.view.state = replace(screen.gui.session.facts.view, zoom=3.0)
    screen.measure_brightness(screen.whole)
    assert screen.fade.seconds_until_needed() is None


def test_progress_line_grows_while_the_whole_picture_is_rendered(gui):
    live = gui.session.pictures.live
    gui.drawn.clear()
    gui.frame()
    assert live.rendered_share is None and "part of the picture" not in gui.drawn
    levels = live.levels  # those of a slow machine
    levels.while_moving = lambda request, *_: replace(request.settings, proxy=0.25)
    gui.session.lens.commands.focus(1.7)
    gui.frame()
    live._changed_at -= 1.0  # the hand rests
    parts = []
    while live.is_working:
        live.work(0.0)
        if live._work is not None and live._work.settings == live._work.key.settings:
            next(live._work.steps, None)
            live._work.seconds += 0.1 * levels.predict_s(live._work.settings)
            gui.drawn.clear()
            gui.frame()
            x0, y0, x1, _ = gui.rect("part of the picture")
            (x, y), (width, height) = (
                gui.session.pictures.view.viewport.corner,
                gui.session.pictures.view.viewport.size,
            )
            assert (x0, y0) == (x, y + height)
            parts.append((x1 - x0) / width)
        if len(parts) == 5:
            break
    assert parts == sorted(parts) and parts[0] == pytest.approx(0.1, abs=0.05)
    assert parts[-1] == pytest.approx(0.5, abs=0.1)
