"""Send the lens at the playhead as a camera would, to a game engine or another heatlens."""

import time
from collections.abc import Callable

from heatlens.camera.ring_samples import sample_of_shot
from heatlens.live.ring.lens_sample import LensSample
from heatlens.live.ring.sender import SOURCE, LensOutput, Sender
from heatlens.model.shot.shot import Shot
from heatlens.model.timecode import Timecode
from heatlens.session.loop.messages import Problem, Worker
from heatlens.session.shot.editing import Editing

_RESTING_S = 0.5  # interval between samples of a resting lens; after one second it counts as silent
_SOON_S = 0.001  # not 0, with which the loop would neither sleep nor draw


class RingOut(Worker):
    """Sends the lens when it changes, and at intervals while it rests."""

    def __init__(
        self,
        sender: Sender | None,
        editing: Editing,
        say: Callable[[str], None],
        timecode_at: Callable[[Shot, int], tuple[int, Timecode] | None],
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        """Send to `sender`; None sends nothing. For `timecode_at` see `OpenSource`."""
        self._output = LensOutput(sender, lambda sentence: say(Problem(sentence)))
        self._editing, self._timecode_at, self._clock = editing, timecode_at, clock
        self._sent: LensSample | None = None
        self._sent_s = 0.0

    def poll(self) -> None:
        """Send a changed lens; call this once a frame. Report a network error once."""
        if not self._output.is_on:
            return
        sample = self._sample()
        if sample == self._sent and self._clock() < self._sent_s + _RESTING_S:
            return
        self._sent, self._sent_s = sample, self._clock()
        self._output.send(sample)

    def seconds_until_needed(self) -> float | None:
        """Return the seconds until the resting lens is sent again; None if nothing is sent."""
        if not self._output.is_on:
            return None
        return max(_SOON_S, self._sent_s + _RESTING_S - self._clock())

    def _sample(self) -> LensSample:
        shot, frame = self._editing.seen_shot, self._editing.frame
        found = self._timecode_at(shot, frame)
        return sample_of_shot(SOURCE, shot, frame, None if found is None else found[1])
