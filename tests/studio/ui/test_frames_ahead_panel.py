"""Frames rendered ahead in the window: rendered while it is idle, and played."""

from collections.abc import Iterator
from dataclasses import replace

import pytest
from imgui_bundle import imgui

from heatlens.core.model.shot.settings import DefocusSettings, Quality
from heatlens.render.rendered_frames.screen_work import CachedFrame
from heatlens.studio.settings.preferences import Preferences
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


def rendered_frames(gui: Gui) -> list[int]:
    """Return the frames that the bar shows as rendered."""
    return [frame for run in gui.session.time.frames_ahead.progress.runs for frame in run]


def fill(gui: Gui, count: int = COUNT) -> None:
    """Wait until this many frames are rendered and in memory."""
    pull, store = gui.session.time.frames_ahead, gui.session.time.frames_ahead.store
    gui.until(
        lambda: len(pull.progress.rendered_frames) >= count, f"{count} rendered frames", 120.0
    )
    store.wait()
    gui.frame(2)


def wait_for_rest(gui: Gui) -> None:
    gui.until(lambda: not gui.session.time.scheduler.is_working, "rest", 120.0)


def test_replayed_frames_show_the_same_pixels_each_time(gui):
    fill(gui)
    wait_for_rest(gui)
    session, clock = gui.session, gui.session.time.timeline.playback._clock
    gui.key(K.space)
    screens = {}
    for _ in range(2 * COUNT):  # the second time from the frames in the colours of the screen
        clock.now_s += 1 / 24
        gui.frame()
        x0, y0, x1, y1 = (round(value) for value in gui.rect("picture"))
        screen = gui.screenshot()[y0:y1, x0:x1].tobytes()
        assert screens.setdefault(session.facts.frame, screen) == screen
    assert len(set(screens.values())) == COUNT


def test_playback_without_rendered_frames_shows_quick_pictures(gui):
    fill(gui, 1)
    session, clock = gui.session, gui.session.time.timeline.playback._clock
    session.time.frames_ahead.store.resize(0, 0)  # no frame fits any more
    gui.key(K.space)
    clock.now_s += 1 / 24
    gui.frame(2)
    gui.until(
        lambda: session.pictures.live.output.frame == session.facts.frame, "the quick picture"
    )
    assert not session.time.frames_ahead.plays_cached_frames and not isinstance(
        session.facts.shown_picture, CachedFrame
    )
    words = rendered_words(session.time)
    assert words.startswith("preview: ") and words.endswith("frames rendered")


def test_focus_drag_is_answered_at_once_while_frames_are_rendered(gui):
    position = gui.at_picture(60, 32)
    gui.until(lambda: gui.session.time.frames_ahead._filler is not None, "the first frame")
    gui.press(position)
    for step in range(1, 6):
        gui.session.work()
        gui.move((position[0] - 8 * step, position[1]))
        assert gui.session.pictures.live.output.shot == gui.session.facts.shot
        assert gui.session.facts.shown_picture.shot == gui.session.facts.shot
    gui.release()


def test_scrubbing_shows_the_kept_frame_until_the_picture_is_whole(gui):
    gui.session.editing.edit(
        replace(gui.session.facts.shot, defocus=DefocusSettings(quality=Quality.FILM))
    )
    gui.frame()
    fill(gui)
    wait_for_rest(gui)
    gui.session.time.timeline.go_to(FIRST + 4)
    shown_pictures = []

    def is_whole():
        shown = gui.session.pictures.live.output
        shown_pictures.append(gui.session.facts.shown_picture)
        return shown.is_whole and shown.frame == FIRST + 4

    gui.until(is_whole, "the whole picture")
    cached_pictures = [picture for picture in shown_pictures if isinstance(picture, CachedFrame)]
    assert cached_pictures and {picture.frame for picture in cached_pictures} == {FIRST + 4}
    gui.settled()
    assert (
        gui.session.facts.shown_picture is gui.session.pictures.live.output
        and gui.session.pictures.live.output.is_whole
    )


def test_frames_ahead_can_be_switched_off_and_cleared(gui, tmp_path):
    fill(gui)
    wait_for_rest(gui)
    gui.do("Render frames ahead")
    assert not gui.session.time.frames_ahead.is_on and rendered_frames(gui) == []
    gui.do("Render frames ahead")
    assert len(rendered_frames(gui)) == COUNT
    gui.do("Clear rendered frames")
    gui.frame()
    assert (
        rendered_frames(gui) == [] and gui.session.time.frames_ahead.store.memory.bytes_in_use == 0
    )
    fill(gui)


def test_rendered_frames_popup_sets_memory_and_disk_limits(ctx, tmp_path):
    preferences = Preferences()
    pattern, folder = sequence_files(tmp_path), tmp_path / "kept"
    with gui_of(ctx, pattern, preferences, defocus=QUICK, frames_folder=folder) as gui:
        fill(gui)
        gui.do("Rendered frames...")
        gui.frame(2)
        for name, text in (("memory for frames", "3 GB"), ("disk for frames", "0")):
            gui.later()
            gui.click(gui.middle(name))
            gui.key(K.a, ctrl=True)
            gui.type(text)
            gui.key(K.enter)
        assert (preferences.values.memory_mb, preferences.values.disk_mb) == (3000, 0)
        store = gui.session.time.frames_ahead.store
        store.wait()
        assert store.memory.limit_bytes == 3 * 10**9 and store.disk.bytes_in_use == 0
        gui.later()
        gui.click(gui.middle("clear frames"))
        store.wait()
        assert store.memory.keys() == set()
