"""Test that the loop of the window learns of every wake."""

import threading

from heatlens.studio.ui.open_window import glfw, take_wake, wake_window


def test_wake_of_a_thread_is_not_lost_when_events_are_handled():
    """The loop handles events twice in a turn, and sleeps only before the first time."""
    take_wake()
    thread = threading.Thread(target=wake_window)
    thread.start()
    thread.join()
    glfw.poll_events()
    assert [take_wake(), take_wake()] == [True, False]
