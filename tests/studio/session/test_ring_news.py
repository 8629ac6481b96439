"""A ring that is turned wakes the window at once; one that rests hardly ever does."""

from hypothesis import given
from hypothesis import strategies as st

from heatlens.core.model.timecode import Timecode
from heatlens.media.live.ring.sources import LensSample
from heatlens.studio.session.live.ring_hand import RingNews


class Window:
    """Counts how often it is woken, and looks when it is told to."""

    def __init__(self) -> None:
        self.now_s = 0.0
        self.woken = 0
        self.news = RingNews(self._wake, lambda: self.now_s)

    def _wake(self) -> None:
        self.woken += 1

    def hears(self, focus_m: float, frame: int = 0) -> None:
        self.news.hear(LensSample("A", focus_distance_m=focus_m, timecode=Timecode(0, 0, 0, frame)))


def test_a_turn_wakes_the_window_at_once_and_only_once_until_it_looks():
    window = Window()
    for focus_m in (1.0, 1.1, 1.2):
        window.hears(focus_m)
    assert (window.woken, window.news.is_due) == (1, True)
    window.news.take()
    assert not window.news.is_due
    window.hears(1.3)
    assert (window.woken, window.news.is_due) == (2, True)


def test_a_thousand_packets_a_second_of_a_ring_that_rests_are_four_frames():
    window = Window()
    for packet in range(1000):
        window.now_s = packet / 1000
        window.hears(2.0, packet % 24)  # the timecode goes on, the lens does not
        window.news.take()
    assert window.woken == 4


@given(st.lists(st.sampled_from((1.0, 2.0, 3.0)), min_size=1, max_size=30))
def test_no_turn_is_missed(turns):
    """After the window has looked, it is due again exactly where the lens is another."""
    window, known = Window(), None
    for focus_m in turns:
        window.hears(focus_m)
        assert window.news.is_due == (focus_m != known)
        window.news.take()
        known = focus_m
