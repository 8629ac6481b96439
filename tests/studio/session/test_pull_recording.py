"""A recorded focus pull: sampled at each frame, reduced to few keys, one step of undo."""

from itertools import pairwise
from types import SimpleNamespace

import pytest

from heatlens.core.model.focus.coc import sharp_dioptres
from heatlens.core.model.shot.lens_parameter import LensParameter
from heatlens.core.model.shot.pull import RecordingState
from support.evening import FIRST, LAST
from support.takes import pull_focus_m, reset_recording

FOCUS = LensParameter.FOCUS_DISTANCE


@pytest.fixture
def session(shared_session):
    return reset_recording(shared_session, FOCUS)


def perform(session, frames=range(FIRST, LAST + 1), distance_m=pull_focus_m) -> None:
    """Arm, play, and move the focus while each frame is shown."""
    session.time.recording.arm()
    session.time.timeline.play(1)
    for frame in frames:
        session.time.timeline.move_playhead(frame)
        session.time.recording.poll()
        if distance_m is not None:
            session.lens.commands.focus(distance_m(frame))
        session.time.recording.poll()
    session.time.timeline.playback.stop()
    session.time.recording.poll()


def focus_keys(session):
    return session.facts.shot.curves.focus_distance_m.keys


def test_recorded_pull_becomes_few_keys_within_the_tolerance(session):
    before = session.facts.shot
    perform(session)
    assert session.time.recording.state is RecordingState.RECORDED
    assert 2 <= len(focus_keys(session)) == session.time.recording.key_count <= 4
    for frame in range(FIRST, LAST + 1):
        off = 1 / session.facts.shot.lens_at(frame).focus_distance_m - 1 / pull_focus_m(frame)
        assert abs(off) <= session.time.recording.tolerance_dioptres * (1 + 1e-6)
    session.editing.undo()
    assert session.facts.shot == before
    session.time.recording.poll()
    assert session.time.recording.state is RecordingState.OFF


def begin_recording(session) -> None:
    session.time.recording.arm()
    session.time.timeline.play(1)
    session.time.recording.poll()
    assert session.time.recording.state is RecordingState.RECORDING


def test_recording_shows_moved_focus_without_setting_keys(session):
    before = session.facts.shot
    begin_recording(session)
    session.lens.commands.focus(3.0)
    session.time.timeline.move_playhead(FIRST + 1)
    session.time.recording.poll()
    assert (
        session.facts.lens.focus_distance_m
        == session.editing.seen_shot.lens.focus_distance_m
        == 3.0
    )
    assert session.facts.shot == before and not session.time.frames_ahead.plays_cached_frames


def test_f_stop_stepped_while_recording_changes_shot_but_not_its_focus(session):
    before = session.facts.shot
    begin_recording(session)
    session.lens.commands.focus(3.0)
    session.lens.commands.step_f_stop(3)
    assert session.facts.shot.lens.f_stop > before.lens.f_stop
    assert session.facts.shot.lens.focus_distance_m == before.lens.focus_distance_m


def test_wider_tolerance_leaves_fewer_keys_in_the_same_undo_step(session):
    before = session.editing.history.end_gesture()

    def shaky_m(frame):
        return 1.0 / (0.3 + 0.02 * (frame % 3))

    perform(session, distance_m=shaky_m)
    counts = []
    for tolerance in (0.0005, 0.06):
        session.time.recording.set_tolerance(tolerance)
        counts.append(session.time.recording.key_count)
    assert counts[0] > counts[1]
    assert session.editing.history.past == (*before.past, before.current)


def test_default_tolerance_is_half_of_the_sharp_range(session):
    expected = sharp_dioptres(session.facts.lens) / 2
    assert session.time.recording.tolerance_dioptres == pytest.approx(expected, rel=0.05)


@pytest.mark.parametrize("when", ["armed", "recording", "recorded"])
def test_dropped_recording_leaves_history_unchanged(session, when):
    before = session.editing.history
    session.time.recording.arm()
    if when != "armed":
        perform_on = session.time.timeline
        perform_on.play(1)
        session.time.recording.poll()
        session.lens.commands.focus(2.5)
        session.time.recording.poll()
    if when == "recorded":
        session.time.timeline.playback.stop()
        session.time.recording.poll()
        assert session.time.recording.state is RecordingState.RECORDED
    session.time.recording.discard()
    assert session.editing.history == before
    assert session.time.recording.state is RecordingState.OFF
    assert session.time.timeline.playback.direction == 0


def test_recording_ends_at_the_last_frame_and_sets_no_key_after_it(session):
    perform(session, [LAST - 2, LAST - 1, LAST, FIRST])  # the last one is behind the end
    assert session.time.recording.state is RecordingState.RECORDED
    assert focus_keys(session)[-1].value == pytest.approx(pull_focus_m(LAST))
    session.editing.settle_if_resting(is_pressed=True)
    assert session.editing.performance is not None and session.wants_frames
    session.editing.performance.moved_at -= 1.0
    session.editing.settle_if_resting(is_pressed=False)
    assert session.editing.performance is None
    assert session.facts.frame == LAST and session.time.timeline.playback.direction == 0
    assert {key.frame for key in focus_keys(session)} <= {LAST - 2, LAST - 1, LAST}


def test_recorded_frames_keep_earlier_and_later_keys_unchanged(session):
    shot = session.facts.shot
    for frame, distance_m in ((FIRST, 2.0), (FIRST + 8, 5.0), (LAST, 9.0)):
        shot = shot.with_key(frame, FOCUS, distance_m)
    session.editing.begin(shot)
    frames = range(FIRST + 4, FIRST + 13)
    perform(session, frames, lambda frame: 3.0)
    assert [focus_keys(session)[0].value, focus_keys(session)[-1].value] == [2.0, 9.0]
    for frame in frames:
        off = 1 / session.facts.shot.lens_at(frame).focus_distance_m - 1 / 3.0
        assert abs(off) <= session.time.recording.tolerance_dioptres * (1 + 1e-6)


def test_recording_without_a_movement_changes_nothing(session):
    before = session.editing.history
    perform(session, distance_m=None)
    assert session.editing.history == before and "not moved" in session.messages.text
    assert session.time.recording.state is RecordingState.OFF


def test_recording_begins_when_the_hand_takes_hold_and_keeps_keys_before(session):
    """The focus goes from the last key before the hand to where the hand begins, without a jump."""
    shot = session.facts.shot
    for frame, distance_m in ((FIRST, 2.0), (FIRST + 6, 8.0), (LAST, 2.0)):
        shot = shot.with_key(frame, FOCUS, distance_m)
    session.editing.begin(shot)
    recording, timeline, start = session.time.recording, session.time.timeline, FIRST + 10
    recording.arm()
    timeline.play(1)
    for frame in range(FIRST, LAST + 1):
        timeline.move_playhead(frame)
        recording.poll()
        if frame >= start:
            session.lens.commands.focus(3.0 + 0.1 * (frame - start))
        recording.poll()
    assert recording.samples[0] == (start, 3.0)
    timeline.playback.stop()
    recording.poll()
    keys = focus_keys(session)
    assert [(key.frame, key.value) for key in keys[:2]] == [(FIRST, 2.0), (FIRST + 6, 8.0)]
    dioptres = [1 / session.facts.shot.lens_at(n).focus_distance_m for n in range(FIRST, LAST + 1)]
    assert max(abs(b - a) for a, b in pairwise(dioptres)) < 0.15


def test_recording_sets_keys_only_where_focus_moves_and_eases_ends(session):
    first, last = FIRST + 5, LAST - 4

    def moved_m(frame):
        fraction = min(max((frame - first) / (last - first), 0.0), 1.0)
        return 1.0 / (0.25 + 0.25 * fraction)

    perform(session, distance_m=moved_m)
    keys = focus_keys(session)
    assert first <= keys[0].frame <= first + 1 and last - 1 <= keys[-1].frame <= last
    assert keys[0].ease_out.handle(1.0)[1] == keys[-1].ease_in.handle(1.0)[1] == 0.0
    assert len(keys) <= 5
    for frame in range(FIRST, LAST + 1):
        off = 1 / session.facts.shot.lens_at(frame).focus_distance_m - 1 / moved_m(frame)
        assert abs(off) <= session.time.recording.tolerance_dioptres * (1 + 1e-6)


def test_recording_holds_constant_focus_between_other_keys(session):
    shot = session.facts.shot
    for frame, distance_m in ((FIRST, 2.0), (LAST, 9.0)):
        shot = shot.with_key(frame, FOCUS, distance_m)
    session.editing.begin(shot)
    frames = range(FIRST + 2, LAST - 1)

    def moved_m(frame):
        return 3.0 if frame < FIRST + 8 else 5.0

    perform(session, frames, moved_m)
    for frame in frames:
        off = 1 / session.facts.shot.lens_at(frame).focus_distance_m - 1 / moved_m(frame)
        assert abs(off) <= session.time.recording.tolerance_dioptres * (1 + 1e-6)
    assert [focus_keys(session)[0].value, focus_keys(session)[-1].value] == [2.0, 9.0]


@pytest.fixture
def counted(session, monkeypatch):
    """Return the session, armed with a count-in, and its clock."""
    clock = SimpleNamespace(now=100.0)
    monkeypatch.setattr(session.time.recording, "_clock", lambda: clock.now)
    session.time.recording.beats = 3
    session.time.recording.arm()
    session.time.timeline.play(1)
    session.time.recording.poll()
    return session, clock


def test_count_in_of_three_beats_precedes_recording(counted):
    session, clock = counted
    recording, beats_shown = session.time.recording, []
    before = session.editing.history
    while recording.state is RecordingState.COUNTING:
        assert not session.time.timeline.playback.direction and session.facts.frame == FIRST
        beats_shown.append(recording.beats_left)
        session.lens.commands.focus(3.0)  # the hand takes hold: no key, no change of the shot
        wait_s = recording.seconds_until_needed()
        assert 0 < wait_s <= 1.0
        clock.now += wait_s + 1e-6
        recording.poll()
    assert beats_shown == [3, 2, 1] and session.editing.history == before
    assert recording.state is RecordingState.RECORDING and recording.beats_left == 0
    assert session.time.timeline.playback.direction == 1
    assert recording.samples == [(FIRST, 3.0)]


def test_play_ends_the_count_in_and_arm_cancels_it(counted):
    session, clock = counted
    clock.now += 0.5
    session.time.timeline.play(1)
    session.time.recording.poll()
    assert session.time.recording.state is RecordingState.RECORDING
    session.time.recording.discard()
    session.time.recording.arm()
    session.time.timeline.play(1)
    session.time.recording.poll()
    assert session.time.recording.state is RecordingState.COUNTING
    session.time.recording.arm()
    assert session.time.recording.state is RecordingState.OFF
    clock.now += 10.0
    session.time.recording.poll()
    assert session.time.timeline.playback.direction == 0


def test_another_edit_ends_the_choice_of_the_tolerance(session):
    perform(session)
    session.lens.commands.step_f_stop(3)
    session.time.recording.poll()
    assert session.time.recording.state is RecordingState.OFF and focus_keys(session)
