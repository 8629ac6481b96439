"""Samples of a ring recorded during playback are put on the frames of their timecode."""

import pytest

from heatlens.core.model.curves.frames import FrameRange
from heatlens.core.model.shot.lens_parameter import LensParameter
from heatlens.core.model.timecode import Timecode
from heatlens.media.live.ring.sources import LensSample, RingSources
from heatlens.studio.session.live.ring_follower import RingFollower
from heatlens.studio.session.live.ring_recording import RingRecording, place_by_timecode
from support.evening import FIRST, LAST
from support.takes import pull_focus_m, reset_recording

FOCUS, IRIS = LensParameter.FOCUS_DISTANCE, LensParameter.F_STOP
RATE = 24.0
PLAYED_FRAMES = FrameRange(1001, 1100)


def timecode_at(count: int) -> Timecode:
    """Return the timecode of `count` frames from midnight at 24 frames a second."""
    return Timecode(count // 86400, count // 1440 % 60, count // 24 % 60, count % 24)


def frames_of(counts, shown_frames, of_shot=None, played=PLAYED_FRAMES):
    """Return frames of samples with timecodes `counts` that came during `shown_frames`."""
    times = [None if count is None else timecode_at(count) for count in counts]
    samples = [(s, LensSample("A", timecode=t)) for s, t in zip(shown_frames, times, strict=True)]
    return [frame for frame, _ in place_by_timecode(samples, played, RATE, of_shot)]


def test_place_by_timecode_uses_the_timecode_of_the_shot():
    of_shot = (1001, Timecode(hours=10, minutes=0, seconds=0, frames=0))
    ten = 10 * 3600 * 24
    assert frames_of([ten, ten + 1, ten + 7], [1050] * 3, of_shot) == [1001, 1002, 1008]
    assert frames_of([ten - 3, ten + 2], [1050] * 2, of_shot) == [1003]  # the lead is left out


def test_place_by_timecode_reads_counts_from_midnight_as_frame_numbers():
    assert frames_of([1010, 1012, 1200], [1050] * 3) == [1010, 1012]


def test_place_by_timecode_starts_foreign_timecode_at_the_shown_frame():
    assert frames_of([500_000, 500_001, 500_004], [1010, 1010, 1011]) == [1010, 1011, 1014]


def test_place_by_timecode_keeps_shown_frames_without_timecode():
    assert frames_of([None, 5], [1010, 1013]) == [1010, 1013]


class Ring:
    """Stand-in for a receiver: `send` gives it a sample at the timecode of a frame."""

    def __init__(self) -> None:
        self.sources = RingSources(lambda: 0.0)
        self.source_state, self.since = self.sources.source_state, self.sources.samples_since

    def listen(self, on_news: object) -> None:
        """Do nothing: the tests poll the ring."""

    def send(self, frame: int, **values: float) -> None:
        self.sources.add_sample(LensSample("A", timecode=timecode_at(frame), **values))


@pytest.fixture
def session(shared_session):
    """Return a session that follows a fake ring."""
    reset_recording(shared_session, FOCUS, IRIS, f_stop=2.8)
    ring = RingFollower(Ring(), shared_session.editing, shared_session.messages.notify)
    shared_session.lens.ring = ring
    shared_session.time.recording._ring = RingRecording(
        ring, shared_session.source, shared_session.editing
    )
    return shared_session


def perform(session, late: int, **more) -> None:
    """Play while the ring sends two samples a frame, which the window sees `late` frames late."""
    ring = session.lens.ring.receiver
    session.time.recording.arm()
    session.time.timeline.play(1)
    session.time.recording.poll()
    for frame in range(FIRST, LAST + 1):
        ring.send(frame, focus_distance_m=pull_focus_m(frame - 0.5))
        ring.send(
            frame, focus_distance_m=pull_focus_m(frame), **{k: f(frame) for k, f in more.items()}
        )
        session.time.timeline.move_playhead(min(frame + late, LAST))
        session.lens.ring.poll()
        session.time.recording.poll()
    session.time.timeline.playback.stop()
    session.time.recording.poll()


@pytest.mark.parametrize("late", [0, 2])
def test_recorded_ring_replays_on_the_frames_of_its_timecode(session, late):
    before = session.facts.shot
    perform(session, late)
    keys = session.facts.shot.curves.focus_distance_m.keys
    assert 2 <= len(keys) <= 4
    for frame in range(FIRST, LAST + 1):
        off = 1 / session.facts.shot.lens_at(frame).focus_distance_m - 1 / pull_focus_m(frame)
        assert abs(off) <= session.time.recording.tolerance_dioptres * (1 + 1e-6)
    session.editing.undo()
    assert session.facts.shot.curves == before.curves


def test_recorded_iris_turn_becomes_f_stop_keys(session):
    perform(session, 0, f_stop=lambda frame: 2.8 + 0.1 * (frame - FIRST))
    for frame in range(FIRST, LAST + 1):
        assert session.facts.shot.lens_at(frame).f_stop == pytest.approx(
            2.8 + 0.1 * (frame - FIRST), rel=0.011
        )
    assert len(session.facts.shot.curves.f_stop.keys) <= 4
    assert not session.facts.shot.curves.focal_length_mm.keys


def test_ring_that_is_not_followed_is_not_recorded(session):
    session.lens.ring.is_followed = False
    before = session.facts.shot
    perform(session, 0)
    assert session.facts.shot == before


def test_recording_of_several_rings_is_one_undo_step(session):
    before = session.facts.shot
    perform(
        session,
        0,
        f_stop=lambda frame: 2.8 + 0.1 * (frame - FIRST),
        focal_length_mm=lambda frame: 50.0 + frame - FIRST,
    )
    after = session.facts.shot
    assert after.curves.f_stop.keys and after.curves.focal_length_mm.keys
    session.time.recording.set_tolerance(
        2 * session.time.recording.tolerance_dioptres
    )  # still the same step
    session.editing.undo()
    assert session.facts.shot == before
    session.editing.redo()
    assert session.facts.shot.curves.f_stop.keys == after.curves.f_stop.keys
