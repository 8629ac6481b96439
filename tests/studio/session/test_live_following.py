"""A focus that follows live in a session: measured on a thread, and again when plates change."""

import os
from dataclasses import replace

import numpy as np
import pytest

from heatlens.core.model.focus.coc import sharp_dioptres
from heatlens.core.model.focus.live_focus import Follow
from heatlens.core.model.marks.marks import DistanceMark, MatteMark
from heatlens.render.source.live_focus import measure_followed_marks
from support.evening import begin_session, run_until, run_until_settled
from support.mattes import matte_plate

DISTANCES_M = {frame: 3.0 + 0.25 * frame for frame in range(1, 8)}
CARD_M = 6.0


def write_walk(folder, later_m=0.0):
    for frame, distance_m in DISTANCES_M.items():
        matte_plate(folder / f"walk.{frame:04d}.exr", distance_m + later_m)


@pytest.fixture
def walk(tmp_path):
    write_walk(tmp_path)
    session = begin_session(tmp_path / "preferences", str(tmp_path / "walk.####.exr"))
    run_until_settled(session)
    marks = MatteMark("A", "cryptomatte:hero"), MatteMark("B", "cryptomatte:card")
    shot = session.editing.shot
    wide_open = replace(shot.lens, f_stop=0.7, focal_length_mm=75.0)  # so that little is ignored
    session.editing.do(replace(shot, lens=wide_open, marks=marks))
    yield session
    session.close()


def focus_at(session, frame):
    return session.editing.shot.lens_at(frame).focus_distance_m


def live_follow(session):
    return session.editing.shot.curves.live


def follow_mark(session, name="A"):
    marks = session.time.marks
    marks.live.follow(session.editing.shot.mark_named(name))
    run_until(
        session,
        lambda: live_follow(session) is not None and live_follow(session).measured,
        "the distances",
    )


def test_follow_moves_focus_with_mark_and_is_one_undo_step(walk):
    before = walk.editing.shot
    follow_mark(walk)
    for frame, distance_m in DISTANCES_M.items():
        assert focus_at(walk, frame) == pytest.approx(distance_m, rel=0.02)
    assert walk.editing.history.undo_words == "what the focus follows"
    walk.editing.undo()
    assert walk.editing.shot == before
    walk.editing.redo()
    run_until(walk, lambda: live_follow(walk).measured, "the distances after redo")


def test_export_measures_same_followed_focus_as_the_window(walk):
    follow_mark(walk)
    shot = walk.editing.shot
    unmeasured = replace(live_follow(walk), measured=(), measured_of="")
    alone = measure_followed_marks(replace(shot, curves=replace(shot.curves, live=unmeasured)))
    assert [alone.lens_at(frame) for frame in range(1, 8)] == [
        shot.lens_at(frame) for frame in range(1, 8)
    ]
    assert measure_followed_marks(shot) is shot  # nothing has to be read again


def test_followed_focus_is_measured_again_when_plates_change(walk, tmp_path):
    follow_mark(walk)
    write_walk(tmp_path, later_m=0.5)
    later = max(path.stat().st_mtime for path in tmp_path.glob("*.exr")) + 5
    for path in tmp_path.glob("*.exr"):
        os.utime(path, (later, later))
    run_until(
        walk, lambda: focus_at(walk, 7) == pytest.approx(DISTANCES_M[7] + 0.5, rel=0.02), "it"
    )
    assert len(walk.editing.history.past) == 2  # the marks and the following: no further step


def test_followed_focus_is_measured_again_when_the_mark_changes(walk):
    follow_mark(walk)
    mark = walk.editing.shot.mark_named("A")
    walk.time.marks.change(mark, replace(mark, name="C", matte="cryptomatte:card"))
    assert live_follow(walk).marks == ("C",)
    run_until(walk, lambda: focus_at(walk, 3) == pytest.approx(CARD_M), "the card")


def test_pull_moves_followed_focus_to_another_mark(walk):
    follow_mark(walk)
    walk.editing.frame = 3
    marks = walk.time.marks
    marks.pulls.target, marks.pulls.frames = "B", 2
    marks.pulls.make()
    run_until(
        walk, lambda: live_follow(walk).measured and focus_at(walk, 7) == pytest.approx(CARD_M), "B"
    )
    assert focus_at(walk, 3) == pytest.approx(DISTANCES_M[3], rel=0.02)
    between = focus_at(walk, 4)
    assert min(DISTANCES_M[4], CARD_M) < between < max(DISTANCES_M[4], CARD_M)


def test_followed_focus_refuses_edits_and_can_become_keys(walk):
    follow_mark(walk)
    shot_before, lens = walk.editing.shot, walk.editing.lens
    walk.editing.edit_lens(replace(lens, focus_distance_m=1.0))
    assert walk.editing.shot == shot_before and "follows A" in walk.messages.text
    walk.editing.edit_lens(replace(lens, f_stop=lens.f_stop * 2))
    assert live_follow(walk) is not None and walk.editing.lens.f_stop == lens.f_stop * 2
    walk.time.marks.delete(walk.editing.shot.mark_named("A"))
    assert walk.editing.shot.mark_named("A") is not None and "let it go" in walk.messages.text
    walk.time.keys.set_here()  # no key of the focus, and no fault
    assert live_follow(walk) is not None
    walk.time.marks.live.make_keys()
    assert live_follow(walk) is None and len(walk.editing.shot.curves.focus_distance_m.keys) >= 2
    lens = walk.editing.shot.lens_at(7)  # stopped down, so that more is ignored
    assert abs(1 / focus_at(walk, 7) - 1 / DISTANCES_M[7]) <= 0.51 * sharp_dioptres(lens)


def test_changed_follow_settings_are_one_step_and_stay_on_new_plates(walk, tmp_path):
    follow_mark(walk)
    late = Follow(ignored_part=0, late_frames=2)
    for frames in (1, 2):
        walk.time.marks.live.change(replace(late, late_frames=frames))
    walk.editing.settle()
    assert focus_at(walk, 5) == pytest.approx(DISTANCES_M[3], rel=1e-6)
    assert len(walk.editing.history.past) == 3
    write_walk(tmp_path, later_m=1.0)
    run_until(
        walk, lambda: focus_at(walk, 5) == pytest.approx(DISTANCES_M[3] + 1), "the new plates"
    )
    assert live_follow(walk).follow == late


def test_stop_following_keeps_focus_of_the_current_frame(walk):
    follow_mark(walk)
    followed_m = walk.editing.lens.focus_distance_m
    walk.time.marks.live.stop_following()
    assert live_follow(walk) is None and not walk.editing.shot.key_frames
    assert focus_at(walk, 7) == followed_m


def test_following_missing_matte_is_reported_once(walk):
    walk.editing.do(replace(walk.editing.shot, marks=(MatteMark("Z", "cryptomatte:nobody"),)))
    walk.time.marks.live.follow(walk.editing.shot.mark_named("Z"))
    run_until(walk, lambda: "nobody" in walk.messages.text, "the reason")
    assert walk.time.marks.live.seconds_until_needed() is None
    assert not live_follow(walk).measured
    walk.editing.do(replace(walk.editing.shot, marks=(DistanceMark("Z", 4.0),)))
    run_until(walk, lambda: focus_at(walk, 2) == pytest.approx(4.0), "a mark that can be measured")
    assert np.isfinite(walk.time.marks.live.seconds_until_needed())
