"""The frames of a shot in the window: rendered while nothing else is to do, and played."""

from collections.abc import Iterator
from dataclasses import replace

import pytest
from imgui_bundle import imgui

from heatlens.core.model.shot.settings import DefocusSettings, Quality
from heatlens.studio.session.playing.kept_screen import KeptFrame
from heatlens.studio.session.settings.preferences import Preferences
from heatlens.studio.ui.timeline.rendered_panel import rendered_words
from support.gui import Gui, gui_of
from support.sequences import FIRST, LAST, sequence_files
from support.session_files import QUICK
from support.timeline_window import Clock

K = imgui.Key
COUNT = LAST - FIRST + 1


@pytest.fixture
def gui(ctx, tmp_path) -> Iterator[Gui]:
    with gui_of(ctx, sequence_files(tmp_path), defocus=QUICK) as gui:
        gui.session.time.timeline.playback._clock = Clock()
        yield gui


def rendered(gui: Gui) -> list[int]:
    """Return the frames under the bar."""
    return [frame for run in gui.session.time.pull.progress.runs for frame in run]


def fill(gui: Gui, count: int = COUNT) -> None:
    """Wait until this many frames are rendered and in memory."""
    pull, store = gui.session.time.pull, gui.session.time.pull.store
    gui.until(lambda: len(pull.progress.rendered) >= count, f"{count} rendered frames", 120.0)
    store.wait()
    gui.frame(2)


def at_rest(gui: Gui) -> None:
    gui.until(lambda: not gui.session.time.scheduler.is_working, "rest", 120.0)


def test_what_is_played_is_what_is_on_the_screen(gui):
    fill(gui)
    at_rest(gui)
    session, clock = gui.session, gui.session.time.timeline.playback._clock
    gui.key(K.space)
    screens = {}
    for _ in range(2 * COUNT):  # the second time from the frames in the colours of the screen
        clock.now_s += 1 / 24
        gui.frame()
        x0, y0, x1, y1 = (round(it) for it in gui.rect("picture"))
        screen = gui.screenshot()[y0:y1, x0:x1].tobytes()
        assert screens.setdefault(session.facts.frame, screen) == screen
    assert len(set(screens.values())) == COUNT


def test_where_frames_are_not_rendered_it_says_so_and_shows_the_quick_picture(gui):
    fill(gui, 1)
    session, clock = gui.session, gui.session.time.timeline.playback._clock
    session.time.pull.store.resize(0, 0)  # no frame fits any more
    gui.key(K.space)
    clock.now_s += 1 / 24
    gui.frame(2)
    gui.until(lambda: session.pictures.live.shown.frame == session.facts.frame, "the quick picture")
    assert not session.time.pull.is_alone and not isinstance(session.facts.seen, KeptFrame)
    words = rendered_words(session.time)
    assert words.startswith("preview: ") and words.endswith("frames rendered")


def test_a_drag_is_answered_at_once_while_frames_are_rendered(gui):
    at = gui.at_picture(60, 32)
    gui.until(lambda: gui.session.time.pull._filler is not None, "the first frame")
    gui.press(at)
    for step in range(1, 6):
        gui.session.work()
        gui.move((at[0] - 8 * step, at[1]))
        assert gui.session.pictures.live.shown.shot == gui.session.facts.shot
        assert gui.session.facts.seen.shot == gui.session.facts.shot
    gui.release()


def test_scrubbing_shows_what_was_rendered_until_the_new_picture_is_there(gui):
    gui.session.editing.edit(
        replace(gui.session.facts.shot, defocus=DefocusSettings(quality=Quality.FILM))
    )
    gui.frame()
    fill(gui)
    at_rest(gui)
    gui.session.time.timeline.go(FIRST + 4)
    seen = []

    def is_whole():
        shown = gui.session.pictures.live.shown
        seen.append(gui.session.facts.seen)
        return shown.is_whole and shown.frame == FIRST + 4

    gui.until(is_whole, "the whole picture")
    kept = [picture for picture in seen if isinstance(picture, KeptFrame)]
    assert kept and {picture.frame for picture in kept} == {FIRST + 4}
    gui.settled()
    assert (
        gui.session.facts.seen is gui.session.pictures.live.shown
        and gui.session.pictures.live.shown.is_whole
    )


def test_forgetting_and_switching_off(gui, tmp_path):
    fill(gui)
    at_rest(gui)
    gui.do("Render frames ahead")
    assert not gui.session.time.pull.is_on and rendered(gui) == []
    gui.do("Render frames ahead")
    assert len(rendered(gui)) == COUNT
    gui.do("Clear rendered frames")
    gui.frame()
    assert rendered(gui) == [] and gui.session.time.pull.store.memory.bytes_in_use == 0
    fill(gui)


def test_the_popup_tells_what_is_kept_and_bounds_it(ctx, tmp_path):
    preferences = Preferences()
    pattern, folder = sequence_files(tmp_path), tmp_path / "kept"
    with gui_of(ctx, pattern, preferences, defocus=QUICK, frames_folder=folder) as gui:
        fill(gui)
        gui.click(gui.middle("rendered frames"))
        for name, text in (("memory for frames", "3 GB"), ("disk for frames", "0")):
            gui.later()
            gui.click(gui.middle(name))
            gui.key(K.a, ctrl=True)
            gui.type(text)
            gui.key(K.enter)
        assert (preferences.now.memory_mb, preferences.now.disk_mb) == (3000, 0)
        store = gui.session.time.pull.store
        store.wait()
        assert store.memory.limit_bytes == 3 * 10**9 and store.disk.bytes_in_use == 0
        gui.later()
        gui.click(gui.middle("clear frames"))
        store.wait()
        assert store.memory.keys() == set()
