"""The lens follows the ring, and the hand in the window wins until the ring is turned again."""

from dataclasses import replace

import pytest

from heatlens.core.model.lens.lens import Lens, MeasuredFrom
from heatlens.core.model.shot.shot import Shot
from heatlens.media.live.ring.channel_map import Ring
from heatlens.media.live.ring.sources import Heard, LensSample
from heatlens.studio.session.live.ring_hand import RingHand
from heatlens.studio.session.shot.editing import Editing


class FakeReceiver:
    """What a receiver would have heard."""

    def __init__(self) -> None:
        self.now = Heard(None, (), 0.0, 0.0, 0)

    def heard(self, source: str | None = None) -> Heard:
        return self.now

    def seconds_until_due(self) -> None:
        return None

    def hears(self, age_s: float = 0.0, **values: float) -> None:
        before = self.now.sample or LensSample()
        sample = replace(before, source="A", **values)
        self.now = Heard(sample, ("A",), 50.0, age_s, self.now.version + 1)


@pytest.fixture
def said() -> list[str]:
    return []


@pytest.fixture
def editing(said) -> Editing:
    return Editing(Shot(Lens(50.0, 2.8, 2.0, 36.0)), said.append)


@pytest.fixture
def receiver() -> FakeReceiver:
    return FakeReceiver()


@pytest.fixture
def hand(receiver, editing, said) -> RingHand:
    return RingHand(receiver, editing, said.append)


def test_what_the_ring_tells_is_the_lens_and_the_rest_stays(hand, receiver, editing):
    receiver.hears(focus_distance_m=1.4)
    hand.poll()
    assert editing.lens == Lens(50.0, 2.8, 1.4, 36.0)
    receiver.hears(f_stop=1.4, focal_length_mm=85.0)
    hand.poll()
    assert editing.lens == Lens(85.0, 1.4, 1.4, 36.0)


def test_a_value_set_by_hand_stays_until_the_ring_is_turned(hand, receiver, editing):
    receiver.hears(focus_distance_m=1.4)
    hand.poll()
    editing.edit_lens(replace(editing.lens, focus_distance_m=5.0))
    receiver.hears(f_stop=4.0)  # the ring sends its focus again, as it was
    hand.poll()
    assert editing.lens.focus_distance_m == 5.0
    receiver.hears(focus_distance_m=1.5)
    hand.poll()
    assert editing.lens.focus_distance_m == 1.5


def test_a_turn_is_one_step_of_undo(hand, receiver, editing):
    before = editing.shot
    for distance_m in (1.9, 1.8, 1.7):
        receiver.hears(focus_distance_m=distance_m)
        hand.poll()
    editing.settle()
    editing.undo()
    assert editing.shot == before


def test_silence_is_said_once_and_the_lens_stays(hand, receiver, editing, said):
    receiver.hears(focus_distance_m=1.4)
    hand.poll()
    for _ in range(3):
        receiver.hears(age_s=1.5)
        hand.poll()
    assert [sentence for sentence in said if "silent" in sentence] == said
    assert len(said) == 1
    assert editing.lens.focus_distance_m == 1.4
    assert hand.seconds_until_needed() is None


def test_an_impossible_lens_is_said_and_not_taken(hand, receiver, editing, said):
    before = editing.lens
    receiver.hears(focus_distance_m=0.01)
    hand.poll()
    assert editing.lens == before
    assert "cannot be used" in said[-1]


def test_a_ring_that_is_not_followed_changes_nothing(hand, receiver, editing):
    hand.is_followed = False
    before = editing.shot
    receiver.hears(focus_distance_m=1.4)
    hand.poll()
    assert editing.shot == before


def test_a_channel_is_learnt_and_turns_the_lens(hand, receiver, editing, said):
    receiver.hears(channels={"/1/fader1": 0.2})
    hand.learn(Ring.IRIS)
    before = editing.lens
    for turned in (0.2, 0.6, 1.0):
        receiver.hears(channels={"/1/fader1": turned})
        hand.poll()
    assert editing.lens == before  # it waits while the control is learnt
    hand.end_learning()
    assert "turns the iris" in said[-1]
    receiver.hears(channels={"/1/fader1": 1.0})
    hand.poll()
    assert editing.lens.f_stop == 22.0
    hand.map(Ring.IRIS, None)
    receiver.hears(channels={"/1/fader1": 0.2})
    hand.poll()
    assert editing.lens.f_stop == 22.0


def test_where_nothing_was_turned_it_is_said(hand, receiver, said):
    hand.learn(Ring.FOCUS)
    hand.end_learning()
    assert "none was learnt" in said[-1] and hand.maps == ()


def test_the_time_to_the_picture_is_from_the_first_turn_to_the_picture_of_the_last(
    receiver, editing, said
):
    now = [10.0]
    hand = RingHand(receiver, editing, said.append, clock=lambda: now[0])
    before = editing.lens
    assert hand.to_picture_s is None
    receiver.hears(focus_distance_m=1.4, age_s=0.003)
    hand.poll()
    now[0] = 10.02
    hand.seen(before)  # the picture of the lens before is still there
    receiver.hears(focus_distance_m=1.5)
    hand.poll()
    now[0] = 10.037
    hand.seen(editing.lens)
    assert hand.to_picture_s == pytest.approx(0.040)
    hand.seen(editing.lens)  # the same picture counts once
    assert hand.to_picture_s == pytest.approx(0.040)


def test_without_a_ring_there_is_nothing_to_wait_for(editing, said):
    hand = RingHand(None, editing, said.append)
    hand.poll()
    assert hand.heard is None and hand.seconds_until_needed() is None


def test_the_thread_that_hears_the_ring_wakes_the_window_for_a_turn(receiver, editing, said):
    woken: list[int] = []
    hand = RingHand(receiver, editing, said.append, wake=lambda: woken.append(1))
    receiver.hears(focus_distance_m=1.4)
    receiver.on_news()
    assert woken == [1] and hand.news.is_due
    hand.poll()
    assert not hand.news.is_due
    receiver.hears(focus_distance_m=1.4)  # the same again, as a camera sends it all the time
    receiver.on_news()
    assert woken == [1]


def test_a_ring_is_turning_for_a_moment_after_each_turn(receiver, editing, said):
    now = [10.0]
    hand = RingHand(receiver, editing, said.append, clock=lambda: now[0])
    assert not hand.is_turning
    receiver.hears(focus_distance_m=1.4)
    hand.poll()
    now[0] += 0.1
    hand.poll()
    assert hand.is_turning
    now[0] += 1.0
    hand.poll()
    assert not hand.is_turning


@pytest.mark.parametrize("told", [{}, {"pupil_offset_mm": 120.0}])
def test_a_ring_measured_from_the_film_plane_is_nearer_to_the_pupil(hand, receiver, editing, told):
    offset = {"measured_from": MeasuredFrom.FILM, "pupil_offset_mm": 120.0}
    editing.edit_lens(replace(editing.lens, **offset))
    receiver.hears(focus_distance_m=2.0, **told)
    hand.poll()
    assert editing.lens.focus_distance_m == pytest.approx(1.88)
