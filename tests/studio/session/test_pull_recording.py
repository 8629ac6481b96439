"""A pull that is performed: taken down at each frame, kept as few keys, one step of undo."""

from types import SimpleNamespace

import pytest

from heatlens.core.model.focus.coc import sharp_dioptres
from heatlens.core.model.shot.lens_parameter import LensParameter
from heatlens.studio.session.live.pull_recording import RecordingState
from support.evening import FIRST, LAST
from support.takes import opened_walls, pulled_m, ready

FOCUS = LensParameter.FOCUS_DISTANCE


@pytest.fixture(scope="module")
def opened(tmp_path_factory):
    with opened_walls(tmp_path_factory.mktemp("walls")) as session:
        yield session


@pytest.fixture
def session(opened):
    return ready(opened, FOCUS)


def perform(session, frames=range(FIRST, LAST + 1), distance_m=pulled_m) -> None:
    """Arm, play, and move the focus while each frame is shown."""
    session.time.recording.arm()
    session.time.timeline.play(1)
    for frame in frames:
        session.time.timeline.put(frame)
        session.time.recording.poll()
        if distance_m is not None:
            session.lens.commands.focus(distance_m(frame))
        session.time.recording.poll()
    session.time.timeline.playback.stop()
    session.time.recording.poll()


def focus_keys(session):
    return session.facts.shot.curves.focus_distance_m.keys


def test_what_was_performed_is_few_keys_within_the_tolerance(session):
    before = session.facts.shot
    perform(session)
    assert session.time.recording.state is RecordingState.RECORDED
    assert 2 <= len(focus_keys(session)) == session.time.recording.key_count <= 4
    for frame in range(FIRST, LAST + 1):
        off = 1 / session.facts.shot.lens_at(frame).focus_distance_m - 1 / pulled_m(frame)
        assert abs(off) <= session.time.recording.tolerance_dioptres * (1 + 1e-6)
    session.editing.undo()
    assert session.facts.shot == before
    session.time.recording.poll()
    assert session.time.recording.state is RecordingState.OFF


def test_while_it_is_performed_the_picture_follows_the_hand_and_no_key_is_set(session):
    before = session.facts.shot
    session.time.recording.arm()
    session.time.timeline.play(1)
    session.time.recording.poll()
    assert session.time.recording.state is RecordingState.RECORDING
    session.lens.commands.focus(3.0)
    session.time.timeline.put(FIRST + 1)
    session.time.recording.poll()
    assert (
        session.facts.lens.focus_distance_m
        == session.editing.seen_shot.lens.focus_distance_m
        == 3.0
    )
    assert session.facts.shot == before and not session.time.pull.is_alone
    session.lens.commands.step_f_stop(3)
    assert session.facts.shot.lens.f_stop > before.lens.f_stop
    assert session.facts.shot.lens.focus_distance_m == before.lens.focus_distance_m


def test_a_wider_tolerance_leaves_fewer_keys_and_is_the_same_step(session):
    before = session.editing.history.at_rest()

    def shaky_m(frame):
        return 1.0 / (0.3 + 0.02 * (frame % 3))

    perform(session, distance_m=shaky_m)
    counts = []
    for tolerance in (0.0005, 0.06):
        session.time.recording.tolerate(tolerance)
        counts.append(session.time.recording.key_count)
    assert counts[0] > counts[1]
    assert session.editing.history.past == (*before.past, before.now)


def test_at_first_the_tolerance_is_half_of_what_is_sharp(session):
    expected = sharp_dioptres(session.facts.lens) / 2
    assert session.time.recording.tolerance_dioptres == pytest.approx(expected, rel=0.05)


@pytest.mark.parametrize("when", ["armed", "recording", "recorded"])
def test_dropped_it_never_was(session, when):
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
    session.time.recording.drop()
    assert session.editing.history == before
    assert session.time.recording.state is RecordingState.OFF
    assert session.time.timeline.playback.direction == 0


def test_the_recording_ends_where_the_shot_begins_again_and_the_hand_sets_no_key_behind(session):
    perform(session, [LAST - 2, LAST - 1, LAST, FIRST])  # the last one is behind the end
    assert session.time.recording.state is RecordingState.RECORDED
    assert focus_keys(session)[-1].value == pytest.approx(pulled_m(LAST))
    session.editing.rest(is_held=True)
    assert session.editing.performance is not None and session.wants_frames
    session.editing.performance.moved_at -= 1.0
    session.editing.rest(is_held=False)
    assert session.editing.performance is None
    assert session.facts.frame == LAST and session.time.timeline.playback.direction == 0
    assert {key.frame for key in focus_keys(session)} <= {LAST - 2, LAST - 1, LAST}


def test_keys_before_and_after_stay_and_do_not_bend_what_was_recorded(session):
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


def test_a_hand_that_does_nothing_changes_nothing(session):
    before = session.editing.history
    perform(session, distance_m=None)
    assert session.editing.history == before and "not moved" in session.messages.text
    assert session.time.recording.state is RecordingState.OFF


def test_frames_before_and_after_the_hand_moves_make_no_keys_and_the_ends_ease(session):
    first, last = FIRST + 5, LAST - 4

    def moved_m(frame):
        part = min(max((frame - first) / (last - first), 0.0), 1.0)
        return 1.0 / (0.25 + 0.25 * part)

    perform(session, distance_m=moved_m)
    keys = focus_keys(session)
    assert first <= keys[0].frame <= first + 1 and last - 1 <= keys[-1].frame <= last
    assert keys[0].ease_out.handle(1.0)[1] == keys[-1].ease_in.handle(1.0)[1] == 0.0
    assert len(keys) <= 5
    for frame in range(FIRST, LAST + 1):
        off = 1 / session.facts.shot.lens_at(frame).focus_distance_m - 1 / moved_m(frame)
        assert abs(off) <= session.time.recording.tolerance_dioptres * (1 + 1e-6)


def test_what_stands_still_is_held_where_keys_come_before_and_after(session):
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


def test_three_beats_are_counted_before_the_shot_plays(counted):
    session, clock = counted
    recording, seen = session.time.recording, []
    before = session.editing.history
    while recording.state is RecordingState.COUNTING:
        assert not session.time.timeline.playback.direction and session.facts.frame == FIRST
        seen.append(recording.beats_left)
        session.lens.commands.focus(3.0)  # the hand takes hold: no key, no change of the shot
        wait_s = recording.seconds_until_needed()
        assert 0 < wait_s <= 1.0
        clock.now += wait_s + 1e-6
        recording.poll()
    assert seen == [3, 2, 1] and session.editing.history == before
    assert recording.state is RecordingState.RECORDING and recording.beats_left == 0
    assert session.time.timeline.playback.direction == 1
    assert recording.samples == [(FIRST, 3.0)]


def test_playing_again_ends_the_count_and_arming_again_drops_it(counted):
    session, clock = counted
    clock.now += 0.5
    session.time.timeline.play(1)
    session.time.recording.poll()
    assert session.time.recording.state is RecordingState.RECORDING
    session.time.recording.drop()
    session.time.recording.arm()
    session.time.timeline.play(1)
    session.time.recording.poll()
    assert session.time.recording.state is RecordingState.COUNTING
    session.time.recording.arm()
    assert session.time.recording.state is RecordingState.OFF
    clock.now += 10.0
    session.time.recording.poll()
    assert session.time.timeline.playback.direction == 0


def test_another_change_of_the_shot_ends_the_choice_of_the_tolerance(session):
    perform(session)
    session.lens.commands.step_f_stop(3)
    session.time.recording.poll()
    assert session.time.recording.state is RecordingState.OFF and focus_keys(session)
