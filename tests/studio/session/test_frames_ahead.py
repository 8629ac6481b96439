"""Which sources have frames rendered ahead, where they come from, and what a change may cost."""

from threading import current_thread

import numpy as np
import pytest

from heatlens.core.model.curves.frames import FrameRange
from heatlens.core.model.shot.pull import pull
from heatlens.core.model.view.view_geometry import Viewport
from heatlens.render.rendered_frames.kept_pictures import half_of
from heatlens.render.source.opened_plates import OpenedPlates
from heatlens.studio.session.session import Session
from heatlens.studio.session.shot.start import Start
from support.evening import settled, turn, until
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
        settled(made[-1])
        made[-1].pictures.view.viewport = Viewport((0.0, 0.0), (float(WIDTH), float(HEIGHT)))
        return made[-1]

    yield begun
    for session in made:
        session.close()


@pytest.fixture
def session(begin, tmp_path):
    return begin(sequence_files(tmp_path, FIRST, LAST))


def filled(session, count=COUNT):
    until(session, lambda: len(session.time.pull.progress.rendered) == count, f"{count} frames")
    session.time.pull.store.wait()
    turn(session)


def test_a_still_has_frames_ahead_once_it_has_a_pull(begin, tmp_path):
    session = begin(room_file(tmp_path / "room.exr"))
    assert not session.time.pull.is_on
    session.editing.do(pull(session.editing.shot, 2.0, 5.0, 3, 6))
    session.time.timeline.go(3)
    turn(session)
    played, job = session.time.timeline.played, session.time.pull.jobs.of
    filled(session, played.count)
    assert job(played.first).key != job(played.last).key
    assert job(played.first).key == job(played.first - 5).key  # the same lens


def test_frames_of_a_moving_scene(begin, tmp_path, renderer):
    shot = scene_shot(tmp_path / "s.heatlens.json", 48, 27, in_out=FrameRange(2, 5))
    session = begin(shot)
    filled(session, 4)
    kept = {frame: session.time.pull.jobs.of(frame) for frame in (2, 5)}
    renderer.load_scene(session.source.scene)
    for frame, job in kept.items():
        pixels = session.time.pull.store.memory.get(job.key).pixels
        np.testing.assert_array_equal(pixels, half_of(renderer.pixels(job.shot, frame)))


def test_frames_of_yesterday_are_read_from_the_disk(begin, tmp_path):
    pattern, folder = sequence_files(tmp_path, FIRST, LAST), tmp_path / "kept"
    first = begin(pattern, frames_folder=folder)
    filled(first)
    first.close()
    session = begin(pattern, frames_folder=folder)
    until(session, lambda: len(session.time.pull.progress.rendered) == COUNT, "the frames on disk")
    assert session.time.pull.frames_made == 0  # none was rendered
    session.time.timeline.play(1)
    until(session, lambda: session.time.pull.is_at_hand(FIRST + 2), "what comes next in memory")


def test_a_drag_computes_no_more_keys_of_frames_than_there_is_time_for(session, monkeypatch):
    """A key takes 3 ms, as for long shots of scenes on a busy machine."""
    filled(session)
    jobs, now, key_s = session.time.pull.jobs, [100.0], 0.003
    made = jobs._made

    def slow(frame):
        now[0] += key_s
        return made(frame)

    monkeypatch.setattr(jobs, "_clock", lambda: now[0])
    monkeypatch.setattr(jobs, "_made", slow)
    session.lens.commands.step_f_stop(3)
    session.time.pull.poll()
    assert now[0] - 100.0 <= 0.004 + key_s < COUNT * key_s
    until(session, lambda: len(session.time.pull.progress.keys) == COUNT, "the keys of all frames")
    filled(session)
    jobs._jobs.clear()
    before = now[0]
    assert not jobs.make(range(FIRST, LAST + 1), 2.5 * key_s)
    assert now[0] - before == pytest.approx(3 * key_s)


def test_the_loop_lists_no_files_and_keeps_an_order_that_still_holds(session, monkeypatch):
    """A shot may have thousands of frames, and their folder may lie in a slow network."""
    filled(session)
    listing, files_at = set(), OpenedPlates.files_at

    def recorded(opened, frame, missing):
        listing.add(current_thread())
        return files_at(opened, frame, missing)

    monkeypatch.setattr(OpenedPlates, "files_at", recorded)
    session.time.pull.jobs._look_at = 0.0
    until(session, lambda: bool(listing), "a look at the files")
    order = session.time.pull._order.frames
    turn(session)
    assert session.time.pull._order.frames is order and len(order) == COUNT
    assert current_thread() not in listing
