"""Sequences without files and a reader that can be paused, for tests of reading ahead."""

import threading
import time
import weakref
from pathlib import Path

import numpy as np

from heatlens.core.base.errors import InputError
from heatlens.media.sequence.names import NameForm
from heatlens.media.sequence.sequence import Sequence
from support.patience import PATIENCE_S
from support.plates import plate_of

PLATE_BYTES = 20  # bytes of a plate of one pixel
FORM = NameForm(prefix="a.", padding=4, suffix=".exr")


class ReadyEvent:
    """An `on_ready` callback that a test can wait for."""

    def __init__(self):
        self._happened = threading.Condition()

    def __call__(self):
        with self._happened:
            self._happened.notify_all()

    def wait_until(self, predicate):
        """Wait until `predicate` is true; check it after each call, and every 0.05 s."""
        end = time.monotonic() + PATIENCE_S
        while not predicate():
            assert time.monotonic() < end, "nothing came"
            with self._happened:
                self._happened.wait(0.05)


class Reader:
    """A reader that makes the plate of a frame from its file name, and records its calls."""

    def __init__(self, damaged=(), pixels=lambda frame: 1):
        self.damaged, self.pixels = damaged, pixels
        self.begun: list[int] = []
        self.gate = threading.Event()
        self.gate.set()
        self.live = self.most_live = 0
        self._lock = threading.Lock()

    def __call__(self, path):
        frame = int(path.name.split(".")[1])
        with self._lock:
            self.begun.append(frame)
            self.live += 1
            self.most_live = max(self.live, self.most_live)
        assert self.gate.wait(PATIENCE_S)
        if frame in self.damaged:
            self._gone()
            raise InputError(f"{path} is damaged")
        depth_m = np.full((1, self.pixels(frame)), 1.0 + frame, np.float32)
        plate = plate_of(np.full((*depth_m.shape, 3), frame, np.float32), depth_m)
        weakref.finalize(plate, self._gone)
        return plate

    def _gone(self):
        with self._lock:
            self.live -= 1


def sequence_of(frames, present=None):
    present = tuple(frames) if present is None else tuple(sorted(present))
    return Sequence(Path("nowhere"), FORM, tuple(frames), present)


def frame_of(plate):
    return int(plate.color[0, 0, 0])


def frames_in_state(states, name):
    return [frame for frame, state in states.items() if state == name]


def wait_until_idle(cache, news):
    """Wait until no frame is being read; each read starts the next one if there is room."""
    news.wait_until(lambda: "reading" not in cache.states().values())
