"""Record a focus pull while the shot plays, and reduce it to a few keys when it stops.

Once armed, it waits for the shot to play, counts 3, 2, 1, and then records the user's focus at each
frame from the first movement on; keys before that stay. At the end the samples become keys within a
tolerance, which can be changed until something else changes the shot. All of this is one undo step.
If a lens ring is followed, its samples are placed by their timecode, and its iris and focal length
become keys too.
"""

import math
import time
from collections.abc import Mapping
from dataclasses import dataclass

from heatlens.core.base.messages import Problem, Worker, report_errors
from heatlens.core.model.curves.key_reduction import Samples
from heatlens.core.model.focus.coc import sharp_dioptres
from heatlens.core.model.keys.key_rows import RowChoice
from heatlens.core.model.shot.history import History
from heatlens.core.model.shot.lens_parameter import LensParameter
from heatlens.core.model.shot.pull import (
    TOLERANCE_LEAST,
    TOLERANCE_MOST,
    RecordingState,
    apply_recorded_focus,
    apply_recorded_parameter,
)
from heatlens.core.model.shot.shot import Shot
from heatlens.studio.session.live.ring_recording import RingRecording, Track
from heatlens.studio.session.shared import Commands, Shared
from heatlens.studio.session.shot.editing import Performance
from heatlens.studio.session.time.timeline import Timeline

BEATS = 3  # seconds of the count-in
_SHARP_SHARE = 0.5  # first tolerance, as a share of the depth of field on one side: invisible


@dataclass(frozen=True)
class RecordedPull:
    """What was recorded, the shot whose keys it replaces, and the shot before and after."""

    samples: Samples
    other_tracks: Mapping[LensParameter, Track]  # iris and focal length, if the ring moved them
    base_shot: Shot
    history_before: History
    new_shot: Shot
    key_count: int


class PullRecording(Commands, Worker):
    """Arms and records a focus pull, and turns it into keys."""

    def __init__(
        self, shared: Shared, timeline: Timeline, rows: RowChoice, ring: RingRecording
    ) -> None:
        super().__init__(shared)
        self._clock = time.perf_counter
        self.beats = BEATS
        self._count_in_start: float | None = None  # time of the clock at which the count-in began
        self._timeline, self._rows, self._ring = timeline, rows, ring
        self._is_armed = False
        self._samples: dict[float, float] = {}  # focus distance in m by frame
        self._last_frame: int | None = None  # the latest frame that was played while recording
        self._direction = 1
        self._history_at_start = self._editing.history  # the undo history at the start
        self._recorded_pull: RecordedPull | None = None
        self._chosen_tolerance: float | None = None

    # State

    @property
    def state(self) -> RecordingState:
        """The present stage of the recording."""
        performance = self._editing.performance
        if self._count_in_start is not None:
            return RecordingState.COUNTING
        if performance is not None and not performance.is_over:
            return RecordingState.RECORDING
        if self._is_armed:
            return RecordingState.ARMED
        return RecordingState.OFF if self._recorded_pull is None else RecordingState.RECORDED

    @property
    def beats_left(self) -> int:
        """The number to show of the count-in: 3, 2, 1; 0 while it does not run."""
        return math.ceil(self._counting_s)

    @property
    def _counting_s(self) -> float:
        """The seconds until the count-in ends."""
        start = self._count_in_start
        return 0.0 if start is None else max(self.beats - (self._clock() - start), 0.0)

    def seconds_until_needed(self) -> float | None:
        """Return the seconds until the next number of the count-in; None if none is counted."""
        remaining_s = self._counting_s
        return (
            None
            if self._count_in_start is None
            else remaining_s - max(math.ceil(remaining_s) - 1, 0)
        )

    @property
    def why_not(self) -> str:
        """A sentence why nothing can be recorded now; "" if it can."""
        is_single_frame = self._timeline.played.count < 2
        return (
            "A pull is recorded while frames play, but there is only one frame."
            if is_single_frame
            else ""
        )

    @property
    def samples(self) -> Samples:
        """The samples of the current or latest recording: (frame, distance in m), by frame."""
        if self._recorded_pull is not None:
            return self._recorded_pull.samples
        return sorted(self._samples.items())

    @property
    def key_count(self) -> int:
        """The number of focus keys that the samples were reduced to."""
        return 0 if self._recorded_pull is None else self._recorded_pull.key_count

    @property
    def tolerance_dioptres(self) -> float:
        """The largest error of the keys at a sample.

        Unless the user chose it, half of the depth of field on one side of the focus.
        """
        if self._chosen_tolerance is not None:
            return self._chosen_tolerance
        invisible_error = _SHARP_SHARE * sharp_dioptres(self._editing.lens)
        return float(f"{min(max(invisible_error, TOLERANCE_LEAST), TOLERANCE_MOST):.2g}")

    # Commands

    def arm(self) -> None:
        """Arm the recording, which starts when the shot plays, and show the focus; or disarm it."""
        if self.state.is_waiting:
            self.discard()
            return
        if self.why_not:
            self._notify(Problem(self.why_not))
            return
        self._recorded_pull, self._is_armed = None, True
        self._rows.select(LensParameter.FOCUS_DISTANCE)
        self._rows.shows_curve = True

    def discard(self) -> None:
        """Discard the recording, restore the shot and stop playback."""
        if self.state is RecordingState.RECORDING:
            self._timeline.playback.stop()
        if self._recorded_pull is not None and self._editing.shot == self._recorded_pull.new_shot:
            self._editing.history = self._recorded_pull.history_before
        self.finish()

    def finish(self) -> None:
        """End the recording and forget its samples; the keys stay as they are."""
        self._is_armed, self._recorded_pull, self._samples = False, None, {}
        self._editing.performance = self._count_in_start = None

    def set_tolerance(self, tolerance_dioptres: float) -> None:
        """Compute the keys again with this tolerance in dioptres."""
        self._chosen_tolerance = min(max(tolerance_dioptres, TOLERANCE_LEAST), TOLERANCE_MOST)
        if self._recorded_pull is not None:
            pull = self._recorded_pull
            self._set_keys(pull.history_before, pull.base_shot, pull.samples, pull.other_tracks)

    # Called by the session

    def poll(self) -> None:
        """Record the focus at the playhead; call this once a frame, after the playhead moved."""
        is_playing = self._timeline.playback.direction != 0
        if self._is_armed and is_playing:
            self._begin_count_in()
        if self.state is RecordingState.COUNTING:
            is_playing = self._continue_count_in(is_playing)
        if self.state is RecordingState.RECORDING:
            self._record_sample(is_playing)
        elif self._recorded_pull is not None and self._editing.shot != self._recorded_pull.new_shot:
            self.finish()  # something else has changed the shot

    def _begin_count_in(self) -> None:
        """Remember the state before the recording, stop playback and begin the count-in."""
        self._is_armed, self._samples, self._last_frame = False, {}, None
        self._direction = self._timeline.playback.direction
        self._editing.settle()
        self._history_at_start = self._editing.history
        self._editing.performance = Performance()
        self._count_in_start = self._clock()
        if self.beats:
            self._timeline.playback.stop()

    def _continue_count_in(self, is_playing: bool) -> bool:
        """Play at the end of the count-in or when the user plays; return True if frames play."""
        if not is_playing and self._counting_s == 0.0:
            self._timeline.play(self._direction)
        is_playing = self._timeline.playback.direction != 0
        if is_playing:
            self._count_in_start = None
            self._ring.begin()
        return is_playing

    def _record_sample(self, is_playing: bool) -> None:
        """Record a sample once the focus was moved; end if playback stops or wraps around."""
        frame, playback = self._editing.frame, self._timeline.playback
        self._ring.poll()
        last_frame, self._last_frame = self._last_frame, frame
        has_turned = playback.direction not in (0, self._direction)
        if last_frame is not None and (has_turned or (frame - last_frame) * self._direction < 0):
            playback.stop()
            self._timeline.move_playhead(last_frame)
            self._end_recording()
            return
        self._add_sample(frame)
        if not is_playing:
            self._end_recording()

    def _add_sample(self, frame: int) -> None:
        """Add the focus at a frame, if the hand has taken hold.

        Until then only the last two frames are kept, and those only without an earlier key: a
        pull by hand begins where the focus was.
        """
        performance = self._editing.performance
        if performance is None or performance.focus_distance_m is None:
            keys = self._editing.shot.curves.focus_distance_m.keys
            earlier = [sample for sample in self._samples.items() if sample[0] != frame]
            has_key_before = any(key.frame < frame for key in keys)
            self._samples = {} if has_key_before else dict(earlier[-1:])
            if has_key_before:
                return
        self._samples[frame] = self._editing.lens.focus_distance_m

    def _end_recording(self) -> None:
        """End the performance; set the keys, or notify the user that the focus was not moved."""
        performance = self._editing.performance
        moved_m = None if performance is None else performance.focus_distance_m
        if performance is not None:  # the gesture may last a moment longer, but must set no keys
            self._editing.performance = Performance(
                None, is_over=True, moved_at=performance.moved_at
            )
        tracks = dict(self._ring.tracks(self._timeline.played))
        focus = tracks.pop(LensParameter.FOCUS_DISTANCE, None)
        if moved_m is None and not tracks:
            self._samples = {}
            self._notify("The focus was not moved, so nothing was recorded.")
            return
        samples = self._samples if focus is None else focus
        self._set_keys(self._history_at_start, self._editing.shot, sorted(samples.items()), tracks)

    def _set_keys(
        self,
        history_before: History,
        base_shot: Shot,
        samples: Samples,
        other_tracks: Mapping[LensParameter, Track],
    ) -> None:
        """Set the keys of a recording in `base_shot`, as one undo step after `history_before`.

        The step includes the iris and the focal length, which the ring changed live like the focus.
        """
        with report_errors(self._notify):
            new_shot = apply_recorded_focus(
                base_shot, samples, self.tolerance_dioptres, by_hand=True
            )
            for parameter, track in other_tracks.items():
                new_shot = apply_recorded_parameter(new_shot, parameter, track)
            first, last = samples[0][0], samples[-1][0]
            keys = new_shot.curves.focus_distance_m.keys
            count = sum(1 for key in keys if first <= key.frame <= last)
            self._recorded_pull = RecordedPull(
                samples, other_tracks, base_shot, history_before, new_shot, count
            )
            self._editing.history = history_before.with_current(new_shot).end_gesture()
