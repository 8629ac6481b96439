"""Which sources have frames rendered ahead, where they come from, and what a change may cost."""

from threading import current_thread
from types import SimpleNamespace

import numpy as np
import pytest

from heatlens.core.model.curves.frames import FrameRange
from heatlens.core.model.shot.pull import pull
from heatlens.core.model.view.view_geometry import Viewport
from heatlens.render.rendered_frames.cached_pictures import to_half
from heatlens.render.source.opened_plates import OpenedPlates
from heatlens.studio.board.session import Session
from heatlens.studio.settings.start import Start
from support.evening import run_loop_once, run_until, run_until_settled, wait_for_all_frames
from support.sequences import FIRST, sequence_files
from support.session_files import HEIGHT, QUICK, WIDTH, room_file, scene_shot

LAST = FIRST + 3
COUNT = LAST - FIRST + 1


@pytest.fixture
def begin(ctx, renderer, tmp_path):
    """Return a function that opens a source, and close what was opened."""
    made = []

    def begun(source, **settings):
        made.append(Session(renderer, Start(str(source), defocus=QUICK), **settings))
        made[-1].begin()
        run_until_settled(made[-1])
        made[-1].pictures.view.viewport = Viewport((0.0, 0.0), (float(WIDTH), float(HEIGHT)))
        return made[-1]

    yield begun
    for session in made:
        session.close()


@pytest.fixture
def session(begin, tmp_path):
    return begin(sequence_files(tmp_path, FIRST, LAST))


def test_still_has_frames_ahead_once_it_has_a_pull(begin, tmp_path):
    session = begin(room_file(tmp_path / "room.exr"))
    assert not session.time.frames_ahead.is_on
    session.editing.do(pull(session.editing.shot, 2.0, 5.0, 3, 6))
    session.time.timeline.go_to(3)
    run_loop_once(session)
    played, job = session.time.timeline.played, session.time.frames_ahead.jobs.job_of
    wait_for_all_frames(session, played.count)
    assert job(played.first).key != job(played.last).key
    assert job(played.first).key == job(played.first - 5).key  # the same lens


def test_frames_ahead_of_moving_scene_equal_direct_renders(begin, tmp_path, renderer):
    shot = scene_shot(tmp_path / "s.heatlens.json", 48, 27, in_out=FrameRange(2, 5))
    session = begin(shot)
    wait_for_all_frames(session, 4)
    job_of_frame = {frame: session.time.frames_ahead.jobs.job_of(frame) for frame in (2, 5)}
    renderer.load_scene(session.source.scene)
    for frame, job in job_of_frame.items():
        pixels = session.time.frames_ahead.store.memory.get(job.key).pixels
        np.testing.assert_array_equal(pixels, to_half(renderer.pixels(job.shot, frame)))


def test_frames_ahead_of_previous_session_are_read_from_disk(begin, tmp_path):
    pattern, folder = sequence_files(tmp_path, FIRST, LAST), tmp_path / "kept"
    first = begin(pattern, frames_folder=folder)
    wait_for_all_frames(first, COUNT)
    first.close()
    session = begin(pattern, frames_folder=folder)
    run_until(
        session,
        lambda: len(session.time.frames_ahead.progress.rendered_frames) == COUNT,
        "the frames on disk",
    )
    assert session.time.frames_ahead.frames_made == 0  # none was rendered
    session.time.timeline.play(1)
    run_until(
        session,
        lambda: session.time.frames_ahead.is_in_memory(FIRST + 2),
        "what comes next in memory",
    )


def test_drag_computes_only_as_many_frame_keys_as_time_allows(session, monkeypatch):
    """A key takes 3 ms, as for long shots of scenes on a busy machine."""
    wait_for_all_frames(session, COUNT)
    jobs, clock_s, key_s = session.time.frames_ahead.jobs, [100.0], 0.003
    make_job = jobs._make_job

    def make_job_slowly(frame):
        clock_s[0] += key_s
        return make_job(frame)

    monkeypatch.setattr(jobs, "_clock", lambda: clock_s[0])
    monkeypatch.setattr(jobs, "_make_job", make_job_slowly)
    session.lens.commands.step_f_stop(3)
    session.time.frames_ahead.poll()
    assert clock_s[0] - 100.0 <= 0.004 + key_s < COUNT * key_s
    run_until(
        session,
        lambda: len(session.time.frames_ahead.progress.keys) == COUNT,
        "the keys of all frames",
    )
    wait_for_all_frames(session, COUNT)
    jobs._jobs.clear()
    before = clock_s[0]
    assert not jobs.make(range(FIRST, LAST + 1), 2.5 * key_s)
    assert clock_s[0] - before == pytest.approx(3 * key_s)


def test_session_loop_lists_no_files_and_keeps_its_frame_order(session, monkeypatch):
    """A shot may have thousands of frames, and their folder may lie in a slow network."""
    wait_for_all_frames(session, COUNT)
    listing_threads, files_at = set(), OpenedPlates.files_at

    def record_thread(opened, frame, missing):
        listing_threads.add(current_thread())
        return files_at(opened, frame, missing)

    monkeypatch.setattr(OpenedPlates, "files_at", record_thread)
    session.time.frames_ahead.jobs._next_check_s = 0.0
    run_until(session, lambda: bool(listing_threads), "a look at the files")
    order = session.time.frames_ahead._order.frames
    run_loop_once(session)
    assert session.time.frames_ahead._order.frames is order and len(order) == COUNT
    assert current_thread() not in listing_threads


def test_another_source_frees_the_memory_of_frames_ahead(session, monkeypatch):
    unloaded = []
    with monkeypatch.context() as patch:
        filler = SimpleNamespace(unload=lambda: unloaded.append("filler"))
        patch.setattr(session.time.frames_ahead, "_filler", filler)
        session.time.frames_ahead.restart()
    assert unloaded == ["filler"]
