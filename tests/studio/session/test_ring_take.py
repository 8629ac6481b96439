"""What a ring does while the shot plays is on the frames of its timecode, and replays there."""

import pytest

from heatlens.core.model.curves.frames import FrameRange
from heatlens.core.model.shot.lens_parameter import LensParameter
from heatlens.core.model.timecode import Timecode
from heatlens.media.live.ring.sources import LensSample, RingSources
from heatlens.studio.session.live.ring_hand import RingHand
from heatlens.studio.session.live.ring_take import RingTake, by_timecode
from support.evening import FIRST, LAST
from support.takes import opened_walls, pulled_m, ready

FOCUS, IRIS = LensParameter.FOCUS_DISTANCE, LensParameter.F_STOP
RATE = 24.0
PLAYED = FrameRange(1001, 1100)


def at(count: int) -> Timecode:
    """Return the timecode of so many frames from midnight."""
    return Timecode(count // 86400, count // 1440 % 60, count // 24 % 60, count % 24)


def frames_of(counts, seen, of_shot=None, played=PLAYED):
    times = [None if count is None else at(count) for count in counts]
    told = [(s, LensSample("A", timecode=t)) for s, t in zip(seen, times, strict=True)]
    return [frame for frame, _ in by_timecode(told, played, RATE, of_shot)]


def test_the_timecode_of_the_shot_decides():
    of_shot = (1001, Timecode(10, 0, 0, 0))
    ten = 10 * 3600 * 24
    assert frames_of([ten, ten + 1, ten + 7], [1050] * 3, of_shot) == [1001, 1002, 1008]
    assert frames_of([ten - 3, ten + 2], [1050] * 2, of_shot) == [1003]  # the lead is left out


def test_a_count_from_midnight_is_that_of_the_frames():
    assert frames_of([1010, 1012, 1200], [1050] * 3) == [1010, 1012]


def test_a_foreign_timecode_begins_at_the_frame_that_was_seen():
    assert frames_of([500_000, 500_001, 500_004], [1010, 1010, 1011]) == [1010, 1011, 1014]


def test_without_timecode_the_frames_that_were_seen_count():
    assert frames_of([None, 5], [1010, 1013]) == [1010, 1013]


class Ring:
    """A receiver that has heard what a test sends."""

    def __init__(self) -> None:
        self.sources = RingSources(lambda: 0.0)
        self.heard, self.since = self.sources.heard, self.sources.since

    def send(self, frame: int, **values: float) -> None:
        self.sources.keep(LensSample("A", timecode=at(frame), **values))


@pytest.fixture(scope="module")
def opened(tmp_path_factory):
    with opened_walls(tmp_path_factory.mktemp("walls")) as session:
        yield session


@pytest.fixture
def session(opened):
    """Return the window's session, which follows a ring."""
    ready(opened, FOCUS, IRIS, f_stop=2.8)
    ring = RingHand(Ring(), opened.editing, opened.messages.say)
    opened.lens.ring = ring
    opened.time.recording._ring = RingTake(ring, opened.source, opened.editing)
    return opened


def perform(session, late: int, **more) -> None:
    """Play while the ring sends two samples a frame, which the window sees `late` frames late."""
    ring = session.lens.ring.receiver
    session.time.recording.arm()
    session.time.timeline.play(1)
    session.time.recording.poll()
    for frame in range(FIRST, LAST + 1):
        ring.send(frame, focus_distance_m=pulled_m(frame - 0.5))
        ring.send(frame, focus_distance_m=pulled_m(frame), **{k: f(frame) for k, f in more.items()})
        session.time.timeline.put(min(frame + late, LAST))
        session.lens.ring.poll()
        session.time.recording.poll()
    session.time.timeline.playback.stop()
    session.time.recording.poll()


@pytest.mark.parametrize("late", [0, 2])
def test_a_recorded_take_replays_to_the_frame(session, late):
    before = session.facts.shot
    perform(session, late)
    keys = session.facts.shot.curves.focus_distance_m.keys
    assert 2 <= len(keys) <= 4
    for frame in range(FIRST, LAST + 1):
        off = 1 / session.facts.shot.lens_at(frame).focus_distance_m - 1 / pulled_m(frame)
        assert abs(off) <= session.time.recording.tolerance_dioptres * (1 + 1e-6)
    session.editing.undo()
    assert session.facts.shot.curves == before.curves


def test_the_iris_becomes_keys_where_it_was_turned(session):
    perform(session, 0, f_stop=lambda frame: 2.8 + 0.1 * (frame - FIRST))
    for frame in range(FIRST, LAST + 1):
        assert session.facts.shot.lens_at(frame).f_stop == pytest.approx(
            2.8 + 0.1 * (frame - FIRST), rel=0.011
        )
    assert len(session.facts.shot.curves.f_stop.keys) <= 4
    assert not session.facts.shot.curves.focal_length_mm.keys


def test_a_ring_that_was_let_go_is_not_recorded(session):
    session.lens.ring.is_followed = False
    before = session.facts.shot
    perform(session, 0)
    assert session.facts.shot == before


def test_a_take_is_one_step_of_undo_whatever_was_turned(session):
    before = session.facts.shot
    perform(
        session,
        0,
        f_stop=lambda frame: 2.8 + 0.1 * (frame - FIRST),
        focal_length_mm=lambda frame: 50.0 + frame - FIRST,
    )
    after = session.facts.shot
    assert after.curves.f_stop.keys and after.curves.focal_length_mm.keys
    session.time.recording.tolerate(
        2 * session.time.recording.tolerance_dioptres
    )  # still the same step
    session.editing.undo()
    assert session.facts.shot == before
    session.editing.redo()
    assert session.facts.shot.curves.f_stop.keys == after.curves.f_stop.keys
