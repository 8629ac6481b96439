"""A hand on a ring that is far away: the lens follows what a camera or a controller sends."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

from heatlens.errors import LensError
from heatlens.ring.lens_sample import LensSample
from heatlens.ring.receiver import LensReceiver
from heatlens.ring.sources import SILENT_AFTER_S, Heard, Numbered
from heatlens.session.editing import Editing
from heatlens.session.messages import Problem

_FOLLOWED = ("focus_distance_m", "f_stop", "t_stop", "focal_length_mm")


class RingHand:
    """Takes over what has changed in the lens that is listened to, as a hand would turn it.

    A value that is set in the window stays until the ring is turned again. When the ring falls
    silent the lens stays where it is, and that is said once.
    """

    def __init__(
        self, receiver: LensReceiver | None, editing: Editing, say: Callable[[str], None]
    ) -> None:
        """Follow `receiver`; None where nothing is listened to."""
        self.receiver = receiver
        self.is_followed = True
        self.source: str | None = None  # None: the one that is heard first
        self._editing = editing
        self._say = say
        self._known: dict[str, float] = {}
        self._was_silent = False

    @property
    def heard(self) -> Heard | None:
        """What the source tells now; None where nothing is listened to."""
        return None if self.receiver is None else self.receiver.heard(self.source)

    def since(self, version: int) -> tuple[Numbered, ...]:
        """Return the samples of the source after a version of `heard`; none where it is let go."""
        if self.receiver is None or not self.is_followed:
            return ()
        return self.receiver.since(version, self.source)

    def listen_to(self, source: str | None) -> None:
        """Follow another source; all of its values count as new."""
        self.source, self._known, self._was_silent = source, {}, False

    def poll(self) -> None:
        """Change the lens where the ring was turned; call this once a frame."""
        heard = self.heard
        if heard is None or heard.sample is None:
            return
        self._tell_silence(heard)
        told = _values(heard.sample)
        changed: dict[str, Any] = {k: v for k, v in told.items() if self._known.get(k) != v}
        self._known |= told
        if changed and self.is_followed and not heard.is_silent:
            self._turn(changed)

    def _turn(self, changed: dict[str, Any]) -> None:
        try:
            self._editing.edit_lens(replace(self._editing.lens, **changed))
        except LensError as error:
            self._say(Problem(f"The ring sent a lens that is not taken over: {error}"))

    def _tell_silence(self, heard: Heard) -> None:
        if heard.is_silent and not self._was_silent:
            self._say(Problem("The ring has fallen silent; the lens stays as it was sent last."))
        self._was_silent = heard.is_silent

    def seconds_until_needed(self) -> float | None:
        """Return how long the loop may sleep before the ring counts as silent; None: for ever."""
        heard = self.heard
        if heard is None or heard.sample is None or heard.is_silent:
            return None
        return SILENT_AFTER_S - heard.age_s + 0.01


def _values(sample: LensSample) -> dict[str, float]:
    found = {name: getattr(sample, name) for name in _FOLLOWED}
    return {name: value for name, value in found.items() if value is not None}
