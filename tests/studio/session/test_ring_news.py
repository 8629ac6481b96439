"""A ring that is turned wakes the window at once; one that rests hardly ever does."""

from hypothesis import given
from hypothesis import strategies as st

from heatlens.core.model.timecode import Timecode
from heatlens.media.live.ring.sources import LensSample
from heatlens.studio.session.live.ring_follower import RingNews


class Window:
    """Stand-in for a window that counts how often `RingNews` wakes it."""

    def __init__(self) -> None:
        self.now_s = 0.0
        self.wake_count = 0
        self.news = RingNews(self._wake, lambda: self.now_s)

    def _wake(self) -> None:
        self.wake_count += 1

    def hears(self, focus_m: float, frame: int = 0) -> None:
        self.news.note_sample(
            LensSample("A", focus_distance_m=focus_m, timecode=Timecode(0, 0, 0, frame))
        )


def test_ring_turn_wakes_the_window_once_until_news_is_taken():
    window = Window()
    for focus_m in (1.0, 1.1, 1.2):
        window.hears(focus_m)
    assert (window.wake_count, window.news.is_due) == (1, True)
    window.news.clear()
    assert not window.news.is_due
    window.hears(1.3)
    assert (window.wake_count, window.news.is_due) == (2, True)


def test_thousand_packets_of_a_resting_ring_wake_the_window_four_times():
    window = Window()
    for packet in range(1000):
        window.now_s = packet / 1000
        window.hears(2.0, packet % 24)  # the timecode goes on, the lens does not
        window.news.clear()
    assert window.wake_count == 4


@given(st.lists(st.sampled_from((1.0, 2.0, 3.0)), min_size=1, max_size=30))
def test_ring_news_is_due_after_every_changed_focus(turns):
    """After `take`, news is due again exactly when the lens differs from the one taken."""
    window, taken_focus_m = Window(), None
    for focus_m in turns:
        window.hears(focus_m)
        assert window.news.is_due == (focus_m != taken_focus_m)
        window.news.clear()
        taken_focus_m = focus_m
