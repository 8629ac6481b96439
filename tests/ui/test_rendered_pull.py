"""The frames of a shot in the window: rendered while nothing else is to do, and played."""

from collections.abc import Iterator
from dataclasses import replace
from threading import current_thread

import numpy as np
import pytest
from imgui_bundle import imgui

from heatlens.gpu.textures import download
from heatlens.model.frames import FrameRange
from heatlens.model.pull import pull
from heatlens.model.settings import DefocusSettings, Quality
from heatlens.model.shot import LensParameter
from heatlens.model.view import Overlay
from heatlens.plate.read import read_plate
from heatlens.render import FrameRenderer
from heatlens.rendered_frames.frame_filler import FrameJob
from heatlens.rendered_frames.kept_picture import half_of
from heatlens.session.playing.kept_screen import KeptFrame
from heatlens.session.settings.preferences import Preferences
from heatlens.source.opened_plates import OpenedPlates
from heatlens.ui.timeline.rendered_panel import rendered_words
from support.gui import Gui, gui_of
from support.scene_window import as_opened
from support.sequences import FIRST, LAST, frame_file, sequence_files
from support.session_files import QUICK, room_file, write_scene
from support.timeline_window import Clock

K = imgui.Key
COUNT = LAST - FIRST + 1
FOCUS = LensParameter.FOCUS_DISTANCE


@pytest.fixture
def gui(ctx, tmp_path) -> Iterator[Gui]:
    with gui_of(ctx, sequence_files(tmp_path), defocus=QUICK) as gui:
        gui.session.time.timeline.playback._clock = Clock()
        yield gui


def rendered(gui: Gui) -> list[int]:
    """Return the frames under the bar."""
    return [frame for run in gui.session.time.pull.runs for frame in run]


def fill(gui: Gui, count: int = COUNT) -> None:
    """Wait until this many frames are rendered and in memory."""
    pull, store = gui.session.time.pull, gui.session.time.pull.store
    gui.until(lambda: len(pull.rendered) >= count, f"{count} rendered frames", 120.0)
    store.wait()
    gui.frame(2)


def at_rest(gui: Gui) -> None:
    gui.until(lambda: not gui.session.time.scheduler.is_working, "rest", 120.0)


def own_picture(gui: Gui, own: FrameRenderer, frame: int) -> np.ndarray:
    job = gui.session.time.pull.jobs.of(frame)
    own.load(read_plate(job.plate.path))
    return half_of(own.pixels(job.shot, frame))


def test_while_nothing_is_to_do_frames_are_rendered_from_the_playhead_on(gui):
    gui.session.time.timeline.go(FIRST + 5)
    gui.frame()
    order = []
    while len(order) < COUNT:
        fill(gui, len(order) + 1)
        order += sorted(gui.session.time.pull.rendered - set(order))
    assert order[0] == FIRST + 5 and order[1] == FIRST + 6
    assert gui.session.time.pull.runs == (FrameRange(FIRST, LAST),)
    assert rendered_words(gui.session.time) == f"all {COUNT} frames rendered"


def test_a_kept_frame_is_what_the_renderer_gives_at_that_size(gui, renderer):
    fill(gui)
    pictures = []
    for frame in range(FIRST, LAST + 1):
        kept = gui.session.time.pull.store.get(gui.session.time.pull.jobs.of(frame).key)
        np.testing.assert_array_equal(kept.pixels, own_picture(gui, renderer, frame))
        pictures.append(kept.pixels.tobytes())
    assert len(set(pictures)) == COUNT


def test_once_all_is_rendered_nothing_more_is(gui):
    fill(gui)
    at_rest(gui)
    session, made = gui.session, gui.session.time.pull.version
    assert session.time.scheduler.seconds_until_needed() is None
    for _ in range(30):
        session.work()
        gui.frame()
    assert session.time.pull.version == made == COUNT


def test_a_drag_computes_no_more_keys_of_frames_than_there_is_time_for(gui, monkeypatch):
    """A key takes 3 ms, as for long shots of scenes on a busy machine."""
    fill(gui)
    jobs, clock = gui.session.time.pull.jobs, Clock()
    made, key_s = jobs._made, 0.003

    def slow(frame: int) -> FrameJob | None:
        clock.now_s += key_s
        return made(frame)

    monkeypatch.setattr(jobs, "_clock", clock)
    monkeypatch.setattr(jobs, "_made", slow)
    gui.session.editing.edit_lens(replace(gui.session.facts.lens, f_stop=4.0))
    before = clock.now_s
    gui.session.time.pull.poll()
    assert clock.now_s - before <= 0.004 + key_s < COUNT * key_s
    gui.until(lambda: len(gui.session.time.pull.keys) == COUNT, "the keys of all frames")
    fill(gui)


def test_playing_rendered_frames_renders_nothing_and_shows_each(gui, renderer):
    fill(gui)
    at_rest(gui)
    session, clock = gui.session, gui.session.time.timeline.playback._clock
    before = session.time.scheduler.picture_key
    gui.key(K.space)
    seen = []
    for _ in range(2 * COUNT):
        clock.now_s += 1 / 24
        assert session.time.player.is_due
        gui.frame()
        shown = session.facts.seen
        assert isinstance(shown, KeptFrame) and session.time.pull.is_alone
        light = download(session.time.pull.screen.uploaded(shown).texture)
        np.testing.assert_array_equal(light, own_picture(gui, renderer, session.facts.frame))
        seen.append(session.facts.frame)
    assert session.time.scheduler.picture_key == before
    assert sorted(seen) == sorted([*range(FIRST, LAST + 1)] * 2)


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


def test_while_it_plays_no_frame_is_rendered_ahead(gui):
    gui.key(K.space)
    assert not gui.session.time.pull.has_work


def test_a_moved_key_leaves_the_frames_that_it_does_not_touch(gui):
    session = gui.session
    shot = session.facts.shot
    for frame, metres in ((FIRST, 2.0), (FIRST + 3, 5.0), (LAST, 5.0)):
        shot = shot.with_key(frame, FOCUS, metres)
    session.editing.edit(shot)
    gui.rest()
    fill(gui)
    session.editing.edit(shot.with_key(FIRST, FOCUS, 2.5))
    gui.frame()  # the bar follows at once
    kept = [f for f in range(FIRST, LAST + 1) if shot.lens_at(f) == session.facts.shot.lens_at(f)]
    assert rendered(gui) == kept and 0 < len(kept) < COUNT
    session.editing.undo()
    gui.frame()
    assert rendered(gui) == list(range(FIRST, LAST + 1))


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


def test_after_what_the_user_did_frames_wait_a_moment(gui, monkeypatch):
    session, clock, worked = gui.session, Clock(), []
    gui.settled()
    gui.until(lambda: session.time.pull.has_work, "the files looked at")
    session.time.pull._clock = clock
    monkeypatch.setattr(session.time.pull, "_work", worked.append)
    session.time.pull.touched()
    wait_s = session.time.scheduler.seconds_until_needed()
    assert 0.0 < wait_s < 1.0
    for _ in range(50):
        session.work()
    assert worked == []
    clock.now_s += wait_s
    assert session.time.scheduler.seconds_until_needed() == 0.0
    session.work()
    assert len(worked) == 1


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


def test_an_overlay_is_drawn_from_the_plate_of_the_frame(gui):
    fill(gui)
    session, clock = gui.session, gui.session.time.timeline.playback._clock
    session.pictures.view.state = replace(session.facts.view, overlay=Overlay.DEPTH)
    gui.key(K.space)
    clock.now_s += 1 / 24
    gui.frame(2)
    assert not session.time.pull.is_alone and not isinstance(session.facts.seen, KeptFrame)
    gui.until(lambda: session.source.is_settled_at(session.facts.frame), "the plate")


def test_a_frame_written_again_is_rendered_again(gui, tmp_path):
    fill(gui)
    session = gui.session
    before = session.time.pull.jobs.of(FIRST + 2).key
    frame_file(tmp_path, FIRST + 2, note="another take")
    session.time.pull.jobs._look_at = 0.0
    # Not that the frame is missing for a moment: it may be rendered again before that is seen.
    gui.until(lambda: session.time.pull.jobs.of(FIRST + 2).key != before, "news of the file", 60.0)
    fill(gui)
    assert FIRST + 2 in session.time.pull.rendered


def test_a_damaged_frame_is_left_out_and_the_others_are_rendered(ctx, tmp_path):
    pattern = sequence_files(tmp_path)
    (tmp_path / f"shot.{FIRST + 2}.exr").write_bytes(b"no picture")
    with gui_of(ctx, pattern, defocus=QUICK) as gui:
        fill(gui, COUNT - 1)
        at_rest(gui)
        assert FIRST + 2 not in gui.session.time.pull.rendered
        assert rendered_words(gui.session.time) == f"{COUNT - 1} of {COUNT} frames rendered"


def test_a_still_with_a_pull_is_played_too(ctx, tmp_path):
    with gui_of(ctx, room_file(tmp_path / "room.exr"), defocus=QUICK) as gui:
        session = gui.session
        gui.frame(3)
        assert not session.time.pull.is_on and rendered_words(session.time) == ""
        session.editing.edit(pull(session.facts.shot, 2.0, 5.0, 3, 6))
        session.time.timeline.go(3)
        gui.frame()
        fill(gui, session.time.timeline.played.count)
        first, last = session.time.timeline.played.first, session.time.timeline.played.last
        assert session.time.pull.jobs.of(first).key != session.time.pull.jobs.of(last).key
        assert (
            session.time.pull.jobs.of(first).key == session.time.pull.jobs.of(first - 5).key
        )  # the same lens


def test_frames_of_a_moving_scene(ctx, tmp_path, renderer):
    with gui_of(ctx, write_scene(tmp_path / "scene.gltf"), defocus=QUICK) as gui:
        as_opened(gui)
        session = gui.session
        session.editing.edit(replace(session.facts.shot, in_out=FrameRange(2, 5)))
        gui.frame()
        fill(gui, 4)
        renderer.load_scene(session.source.scene)
        for frame in (2, 5):
            job = session.time.pull.jobs.of(frame)
            kept = session.time.pull.store.get(job.key)
            np.testing.assert_array_equal(kept.pixels, half_of(renderer.pixels(job.shot, frame)))


def test_frames_of_yesterday_are_read_from_the_disk(ctx, tmp_path):
    pattern, folder = sequence_files(tmp_path), tmp_path / "kept"
    with gui_of(ctx, pattern, defocus=QUICK, frames_folder=folder) as gui:
        fill(gui)
    with gui_of(ctx, pattern, defocus=QUICK, frames_folder=folder) as gui:
        gui.until(lambda: len(gui.session.time.pull.rendered) == COUNT, "the frames on disk")
        assert gui.session.time.pull.version == 0  # none was rendered
        gui.session.time.timeline.playback._clock = Clock()
        gui.key(K.space)
        gui.until(lambda: gui.session.time.pull.is_at_hand(FIRST + 3), "what comes next in memory")


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


def test_the_loop_lists_no_files_and_keeps_an_order_that_still_holds(gui, monkeypatch):
    """A shot may have thousands of frames, and their folder may lie in a slow network."""
    fill(gui)
    listing, files_at = set(), OpenedPlates.files_at

    def recorded(opened, frame, missing):
        listing.add(current_thread())
        return files_at(opened, frame, missing)

    monkeypatch.setattr(OpenedPlates, "files_at", recorded)
    gui.session.time.pull.jobs._look_at = 0.0
    gui.until(lambda: listing, "a look at the files", 60.0)
    order = gui.session.time.pull._order
    gui.frame(2)
    assert gui.session.time.pull._order is order and len(order) == COUNT
    assert current_thread() not in listing
