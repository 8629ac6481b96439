"""Follow a lens ring, and send the lens as a ring does.

The lens changes as a camera or a controller sends it. The lens at the playhead is sent as a camera
would, to a game engine or another heatlens.
"""

import math
import time
from collections import deque
from collections.abc import Callable
from dataclasses import replace
from statistics import median

from heatlens.core.base.errors import LensError
from heatlens.core.base.messages import Problem, Worker
from heatlens.core.model.lens.lens import Lens, MeasuredFrom, from_pupil_m
from heatlens.core.model.option import Values, known_values
from heatlens.core.model.shot.shot import Shot
from heatlens.core.model.timecode import Timecode
from heatlens.media.camera.ring_samples import sample_of_shot
from heatlens.media.live.ring.channel_map import (
    ChannelMap,
    Learning,
    Ring,
    channels_of,
    map_channels,
)
from heatlens.media.live.ring.sender import SOURCE, LensOutput, Sender
from heatlens.media.live.ring.sources import LensSample, NumberedSample, RingInput, SourceState
from heatlens.studio.session.shot.editing import Editing
from heatlens.studio.settings.preferences import Preferences

_RESTING_S = 0.25  # interval between window frames while no value changes


class RingNews:
    """Wakes the window for changed values; `is_due` is True until the window has handled them."""

    def __init__(
        self, wake: Callable[[], None] = lambda: None, clock: Callable[[], float] = time.monotonic
    ) -> None:
        """Create it; `note_sample` calls `wake` to have the window drawn."""
        self.is_due = False
        self._wake = wake
        self._clock = clock
        self._last_lens: LensSample | None = None
        self._last_wake_s = -_RESTING_S

    # Cameras send up to a thousand samples a second. A resting ring must not keep the window
    # drawing, so equal samples wake it only now and then; the timecode, which always differs, is
    # left out of the comparison. `is_due` stays set until `clear` is called, so that a change which
    # comes while a whole picture is being rendered is not lost.
    def note_sample(self, sample: LensSample | None) -> None:
        """Wake the window for a new sample; for an equal one only now and then."""
        lens = None if sample is None else replace(sample, timecode=None)
        now_s = self._clock()
        if self.is_due or (lens == self._last_lens and now_s - self._last_wake_s < _RESTING_S):
            return
        self._last_lens, self._last_wake_s = lens, now_s
        self.is_due = True
        self._wake()

    def clear(self) -> None:
        """Note that the window handles samples now; call this before it reads them."""
        self.is_due = False


_LATENCIES = 50  # number of latest latencies for the median
_TURNING_S = 0.3  # the ring counts as being turned for this long after a change
_FOLLOWED_FIELDS = ("focus_distance_m", "f_stop", "t_stop", "focal_length_mm", "pupil_offset_mm")


class RingFollower(Worker):
    """Applies changes of the received lens to the shot, as if the user had made them.

    A value set in the window stays until the ring is turned again. When samples stop coming, the
    lens stays as it is, and that is reported once.
    """

    def __init__(
        self,
        receiver: RingInput | None,
        editing: Editing,
        notify: Callable[[str], None],
        preferences: Preferences | None = None,
        clock: Callable[[], float] = time.monotonic,
        wake: Callable[[], None] = lambda: None,
    ) -> None:
        """Follow `receiver`, or nothing if None. Channel maps are kept in `preferences`.

        `wake` is called on the receiver's thread to have the window drawn.
        """
        self.news = RingNews(wake)
        self._clock = clock
        self._last_turn_s = -math.inf  # time at which the ring last changed the lens
        self._change_time_s: float | None = None  # time of a change not shown yet
        self._latencies_s: deque[float] = deque(maxlen=_LATENCIES)
        self.receiver = receiver
        self.is_followed = True
        self.source: str | None = None  # name of the followed source; None for the first one
        self.learning: Learning | None = None  # while a map is learnt
        self._preferences = preferences or Preferences()
        self._editing = editing
        self._notify = notify
        self._last_values: dict[str, float] = {}
        self._was_silent = False
        if receiver is not None:
            receiver.listen(self._note_news)

    def _note_news(self) -> None:
        """Wake the window if the latest sample differs; called on the receiver's thread."""
        ring_state = self.heard
        self.news.note_sample(None if ring_state is None else ring_state.sample)

    @property
    def is_turning(self) -> bool:
        """True while the ring is being turned."""
        return self._clock() - self._last_turn_s < _TURNING_S

    @property
    def heard(self) -> SourceState | None:
        """The latest state of the source; None if there is no receiver."""
        return None if self.receiver is None else self.receiver.source_state(self.source)

    @property
    def is_stream(self) -> bool:
        """True if samples come all the time, as a camera sends them."""
        ring_state = self.heard
        return ring_state is not None and ring_state.silent_after_s < math.inf

    def samples_since(self, version: int) -> tuple[NumberedSample, ...]:
        """Return the samples after a version of `heard`; none if the ring is not followed."""
        if self.receiver is None or not self.is_followed:
            return ()
        news = self.receiver.sources.samples_since(version, self.source)
        return tuple((number, self._from_pupil(sample)) for number, sample in news)

    # A camera measures the focus from its film plane, and the lens of the shot from its entrance
    # pupil unless its setting says otherwise. The pupil offset of the sample is more exact than
    # that of the shot, so it is used if there is one.
    def _from_pupil(self, sample: LensSample) -> LensSample:
        """Return the sample with its focus distance converted to one from the entrance pupil."""
        lens, focus_m = self._editing.lens, sample.focus_distance_m
        if focus_m is None or lens.measured_from is MeasuredFrom.PUPIL:
            return sample
        offset_mm = sample.pupil_offset_mm
        if offset_mm is None:
            return replace(sample, focus_distance_m=from_pupil_m(lens, focus_m))
        return replace(sample, focus_distance_m=focus_m - 1e-3 * offset_mm)

    def _mapped_values(self, sample: LensSample) -> dict[str, float]:
        """Return the values of mapped channels; the focus is converted to one from the pupil."""
        values = map_channels(sample, self.maps)
        if "focus_distance_m" in values:
            focus_m = values["focus_distance_m"]
            values["focus_distance_m"] = from_pupil_m(self._editing.lens, focus_m)
        return values

    def listen_to(self, source: str | None) -> None:
        """Follow another source; all its values count as changed."""
        self.source, self._last_values, self._was_silent = source, {}, False

    @property
    def maps(self) -> tuple[ChannelMap, ...]:
        """The channel maps of the rings."""
        return self._preferences.values.ring_maps

    def set_map(self, ring: Ring, entry: ChannelMap | None) -> None:
        """Map a channel to a ring and remember it; None removes the map."""
        other_maps = (ring_map for ring_map in self.maps if ring_map.ring is not ring)
        new_maps = tuple(other_maps) if entry is None else (*other_maps, entry)
        self._preferences.change(ring_maps=new_maps)

    def learn(self, ring: Ring) -> None:
        """Begin to learn which channel turns a ring; the lens does not follow meanwhile."""
        self.learning = Learning(ring)
        self._notify(f"Turn the control for the {ring.words} from one end to the other.")

    def end_learning(self) -> None:
        """End learning and keep the map; report if no channel was turned."""
        learning, self.learning = self.learning, None
        if learning is None:
            return
        entry = learning.learned_map()
        if entry is None:
            self._notify(Problem("No control was turned, so none was learnt."))
            return
        self.set_map(learning.ring, entry)
        self._notify(f"{entry.channel} turns the {learning.ring.words}.")

    def poll(self) -> None:
        """Change the lens if the ring was turned; call this once a frame."""
        self.news.clear()
        ring_state = self.heard
        if ring_state is None or ring_state.sample is None:
            return
        self._report_silence(ring_state)
        if self.learning is not None:
            self.learning.observe(channels_of(ring_state.sample))
            return
        values = known_values(self._from_pupil(ring_state.sample), _FOLLOWED_FIELDS)
        values |= self._mapped_values(ring_state.sample)
        changed_values: dict[str, object] = {
            name: value for name, value in values.items() if self._last_values.get(name) != value
        }
        self._last_values |= values
        if changed_values and self.is_followed and not ring_state.is_silent:
            self._last_turn_s = self._clock()
            if self._change_time_s is None:
                self._change_time_s = self._last_turn_s - ring_state.age_s
            self._change_lens(changed_values)

    # The latency ends when the picture of this very lens is on the screen. Up to the end of
    # rendering only, it would leave out the wait for the next frame of the window, which the user
    # notices as well.
    def note_shown_lens(self, lens: Lens | None) -> None:
        """Note the lens of the picture that is on the screen from now on."""
        if self._change_time_s is not None and lens is not None and lens == self._editing.lens:
            self._latencies_s.append(self._clock() - self._change_time_s)
            self._change_time_s = None

    @property
    def median_latency_s(self) -> float | None:
        """The median latency from a turn of the ring to its picture; None before the first."""
        return median(self._latencies_s) if self._latencies_s else None

    def _change_lens(self, changed_values: Values) -> None:
        """Change the lens at the playhead to values from the ring; report impossible ones."""
        try:
            self._editing.edit_lens(replace(self._editing.lens, **changed_values))
        except LensError as error:
            self._notify(Problem(f"The ring sent a lens that cannot be used: {error}"))

    def _report_silence(self, ring_state: SourceState) -> None:
        """Report once that the ring has become silent."""
        if ring_state.is_silent and not self._was_silent:
            self._notify(Problem("The ring is silent; the lens keeps the values sent last."))
        self._was_silent = ring_state.is_silent

    def seconds_until_needed(self) -> float | None:
        """Return the seconds until the ring counts as silent; None if that cannot happen."""
        due_s = None if self.receiver is None else self.receiver.seconds_until_due()
        ring_state = None if due_s is not None else self.heard
        if ring_state is None or ring_state.sample is None or ring_state.is_silent:
            return due_s
        wait_s = ring_state.silent_after_s - ring_state.age_s + 0.01
        return wait_s if wait_s < math.inf else None


_REPEAT_S = 0.5  # interval between samples of a resting lens; after one second it counts as silent
_MIN_SLEEP_S = 0.001  # not 0, with which the loop would neither sleep nor draw


class RingOut(Worker):
    """Sends the lens when it changes, and at intervals while it rests."""

    def __init__(
        self,
        sender: Sender | None,
        editing: Editing,
        notify: Callable[[str], None],
        timecode_at: Callable[[Shot, int], tuple[int, Timecode] | None],
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        """Send to `sender`; None sends nothing. For `timecode_at` see `OpenSource`."""
        self._output = LensOutput(sender, lambda sentence: notify(Problem(sentence)))
        self._editing, self._timecode_at, self._clock = editing, timecode_at, clock
        self._last_sample: LensSample | None = None
        self._last_sent_s = 0.0

    def poll(self) -> None:
        """Send a changed lens, an equal one now and then; call this once a frame."""
        if not self._output.is_on:
            return
        sample = self._current_sample()
        if sample == self._last_sample and self._clock() < self._last_sent_s + _REPEAT_S:
            return
        self._last_sample, self._last_sent_s = sample, self._clock()
        self._output.send(sample)

    def seconds_until_needed(self) -> float | None:
        """Return the seconds until the resting lens is sent again; None if nothing is sent."""
        if not self._output.is_on:
            return None
        return max(_MIN_SLEEP_S, self._last_sent_s + _REPEAT_S - self._clock())

    def _current_sample(self) -> LensSample:
        """Return the lens of the shot at the playhead, with its timecode, as a sample."""
        shot, frame = self._editing.seen_shot, self._editing.frame
        timecode = self._timecode_at(shot, frame)
        return sample_of_shot(SOURCE, shot, frame, None if timecode is None else timecode[1])
