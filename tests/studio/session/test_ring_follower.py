"""The lens follows the ring; a value set in the window stays until the ring is turned again."""

from collections.abc import Callable
from dataclasses import replace

import pytest

from heatlens.core.model.lens.lens import Lens, MeasuredFrom
from heatlens.core.model.shot.shot import Shot
from heatlens.media.live.ring.channel_map import Ring
from heatlens.media.live.ring.sources import LensSample, SourceState
from heatlens.studio.session.live.ring_follower import RingFollower
from heatlens.studio.session.shot.editing import Editing


class FakeReceiver:
    """Stand-in for a receiver, whose samples the test sets."""

    def __init__(self) -> None:
        self.now = SourceState(sample=None, sources=(), rate_hz=0.0, age_s=0.0, version=0)
        self.on_news = lambda: None

    def listen(self, on_news: Callable[[], None]) -> None:
        self.on_news = on_news

    def source_state(self, source: str | None = None) -> SourceState:
        return self.now

    def seconds_until_due(self) -> None:
        return None

    def hears(self, age_s: float = 0.0, **values: float) -> None:
        before = self.now.sample or LensSample()
        sample = replace(before, source="A", **values)
        self.now = SourceState(sample, ("A",), 50.0, age_s, self.now.version + 1)


@pytest.fixture
def editing(messages) -> Editing:
    return Editing(Shot(Lens(50.0, 2.8, 2.0, 36.0)), messages.append)


@pytest.fixture
def receiver() -> FakeReceiver:
    return FakeReceiver()


@pytest.fixture
def hand(receiver, editing, messages) -> RingFollower:
    return RingFollower(receiver, editing, messages.append)


def test_ring_sets_the_lens_values_it_sends_and_no_others(hand, receiver, editing):
    receiver.hears(focus_distance_m=1.4)
    hand.poll()
    assert editing.lens == Lens(50.0, 2.8, 1.4, 36.0)
    receiver.hears(f_stop=1.4, focal_length_mm=85.0)
    hand.poll()
    assert editing.lens == Lens(85.0, 1.4, 1.4, 36.0)


def test_focus_set_in_the_window_stays_until_the_ring_is_turned(hand, receiver, editing):
    receiver.hears(focus_distance_m=1.4)
    hand.poll()
    editing.edit_lens(replace(editing.lens, focus_distance_m=5.0))
    receiver.hears(f_stop=4.0)  # the ring sends its focus again, as it was
    hand.poll()
    assert editing.lens.focus_distance_m == 5.0
    receiver.hears(focus_distance_m=1.5)
    hand.poll()
    assert editing.lens.focus_distance_m == 1.5


def test_turn_of_the_ring_is_one_undo_step(hand, receiver, editing):
    before = editing.shot
    for distance_m in (1.9, 1.8, 1.7):
        receiver.hears(focus_distance_m=distance_m)
        hand.poll()
    editing.settle()
    editing.undo()
    assert editing.shot == before


def test_silent_ring_is_reported_once_and_the_lens_stays(hand, receiver, editing, messages):
    receiver.hears(focus_distance_m=1.4)
    hand.poll()
    for _ in range(3):
        receiver.hears(age_s=1.5)
        hand.poll()
    assert [sentence for sentence in messages if "silent" in sentence] == messages
    assert len(messages) == 1
    assert editing.lens.focus_distance_m == 1.4
    assert hand.seconds_until_needed() is None


def test_impossible_lens_from_the_ring_is_reported_and_ignored(hand, receiver, editing, messages):
    before = editing.lens
    receiver.hears(focus_distance_m=0.01)
    hand.poll()
    assert editing.lens == before
    assert "cannot be used" in messages[-1]


def test_ring_that_is_not_followed_changes_nothing(hand, receiver, editing):
    hand.is_followed = False
    before = editing.shot
    receiver.hears(focus_distance_m=1.4)
    hand.poll()
    assert editing.shot == before


def test_learned_channel_turns_the_iris(hand, receiver, editing, messages):
    receiver.hears(channels={"/1/fader1": 0.2})
    hand.learn(Ring.IRIS)
    before = editing.lens
    for value in (0.2, 0.6, 1.0):
        receiver.hears(channels={"/1/fader1": value})
        hand.poll()
    assert editing.lens == before  # it waits while the control is learnt
    hand.end_learning()
    assert "turns the iris" in messages[-1]
    receiver.hears(channels={"/1/fader1": 1.0})
    hand.poll()
    assert editing.lens.f_stop == 22.0
    hand.set_map(Ring.IRIS, None)
    receiver.hears(channels={"/1/fader1": 0.2})
    hand.poll()
    assert editing.lens.f_stop == 22.0


def test_learning_without_a_turn_is_reported(hand, receiver, messages):
    hand.learn(Ring.FOCUS)
    hand.end_learning()
    assert "none was learnt" in messages[-1] and hand.maps == ()


def test_median_latency_runs_from_first_turn_to_picture_of_the_last(receiver, editing, messages):
    clock_s = [10.0]
    hand = RingFollower(receiver, editing, messages.append, clock=lambda: clock_s[0])
    before = editing.lens
    assert hand.median_latency_s is None
    receiver.hears(focus_distance_m=1.4, age_s=0.003)
    hand.poll()
    clock_s[0] = 10.02
    hand.note_shown_lens(before)  # the picture of the lens before is still there
    receiver.hears(focus_distance_m=1.5)
    hand.poll()
    clock_s[0] = 10.037
    hand.note_shown_lens(editing.lens)
    assert hand.median_latency_s == pytest.approx(0.040)
    hand.note_shown_lens(editing.lens)  # the same picture counts once
    assert hand.median_latency_s == pytest.approx(0.040)


def test_ring_follower_without_a_ring_waits_for_nothing(editing, messages):
    hand = RingFollower(receiver=None, editing=editing, notify=messages.append)
    hand.poll()
    assert hand.heard is None and hand.seconds_until_needed() is None


def test_ring_news_wakes_the_window_only_for_a_changed_lens(receiver, editing, messages):
    wake_calls: list[int] = []
    hand = RingFollower(receiver, editing, messages.append, wake=lambda: wake_calls.append(1))
    receiver.hears(focus_distance_m=1.4)
    receiver.on_news()
    assert wake_calls == [1] and hand.news.is_due
    hand.poll()
    assert not hand.news.is_due
    receiver.hears(focus_distance_m=1.4)  # the same again, as a camera sends it all the time
    receiver.on_news()
    assert wake_calls == [1]


def test_is_turning_lasts_a_moment_after_each_turn(receiver, editing, messages):
    clock_s = [10.0]
    hand = RingFollower(receiver, editing, messages.append, clock=lambda: clock_s[0])
    assert not hand.is_turning
    receiver.hears(focus_distance_m=1.4)
    hand.poll()
    clock_s[0] += 0.1
    hand.poll()
    assert hand.is_turning
    clock_s[0] += 1.0
    hand.poll()
    assert not hand.is_turning


@pytest.mark.parametrize("more_values", [{}, {"pupil_offset_mm": 120.0}])
def test_ring_distance_from_film_plane_is_converted_to_the_pupil(
    hand, receiver, editing, more_values
):
    offset = {"measured_from": MeasuredFrom.FILM, "pupil_offset_mm": 120.0}
    editing.edit_lens(replace(editing.lens, **offset))
    receiver.hears(focus_distance_m=2.0, **more_values)
    hand.poll()
    assert editing.lens.focus_distance_m == pytest.approx(1.88)
