"""Record the samples of a ring and place them on the frames of their timecode.

The window may draw late, but a camera sends the timecode with each sample. All samples are
therefore recorded and placed on their frames when the recording ends.
"""

from collections.abc import Mapping, Sequence
from dataclasses import fields, replace

from heatlens.core.model.curves.frames import FrameRange
from heatlens.core.model.shot.lens_parameter import LensParameter
from heatlens.core.model.timecode import Timecode
from heatlens.media.live.ring.sources import LensSample
from heatlens.studio.session.live.ring_follower import RingFollower
from heatlens.studio.session.opened.open_source import OpenSource
from heatlens.studio.session.shot.editing import Editing

Track = Mapping[int, float]  # value by frame
FrameSample = tuple[int, LensSample]  # a sample, and the frame at the playhead when it came
_SAMPLE_FIELDS = {field.name for field in fields(LensSample)}
_RECORDED_PARAMETERS = tuple(
    parameter for parameter in LensParameter if parameter in _SAMPLE_FIELDS
)


class RingRecording:
    """Records the samples of the followed ring since `begin`."""

    def __init__(self, ring: RingFollower, source: OpenSource, editing: Editing) -> None:
        self._ring, self._source, self._editing = ring, source, editing
        self._version = 0
        self._samples: list[FrameSample] = []

    def begin(self) -> None:
        """Forget all samples; only later ones count."""
        ring_state = self._ring.heard
        self._version, self._samples = 0 if ring_state is None else ring_state.version, []

    def poll(self) -> None:
        """Record the samples that came since the last call; call this once a frame."""
        new_samples = self._ring.samples_since(self._version)
        self._samples += [(self._editing.frame, sample) for _, sample in new_samples]
        self._version = max((version for version, _ in new_samples), default=self._version)

    def tracks(self, played: FrameRange) -> dict[LensParameter, Track]:
        """Return the values that moved, at each frame of `played` that has a sample."""
        if not self._ring.is_stream:
            return {}  # a controller sends no timecode: its focus was recorded at the playhead
        rate = self._editing.shot.frames_per_second
        shot_timecode = self._source.timecode_at(self._editing.shot, self._editing.frame)
        placed_samples = place_by_timecode(self._samples, played, rate, shot_timecode)
        tracks = {
            parameter: _track_of(placed_samples, parameter) for parameter in _RECORDED_PARAMETERS
        }
        return {name: track for name, track in tracks.items() if len(set(track.values())) > 1}


def place_by_timecode(
    received: Sequence[FrameSample],
    played: FrameRange,
    rate: float,
    shot_timecode: tuple[int, Timecode] | None = None,
) -> list[FrameSample]:
    """Return the samples that fall on frames of `played`, each with the frame of its timecode.

    `shot_timecode` is a frame of the shot and its timecode. If the timecode of the samples is
    outside the shot, it is read as a count of frames from midnight, as `heatlens camera --send`
    sends it. If that is outside too, the first sample is placed on the frame that was shown when it
    came, and the others relative to it. Samples without timecode are placed on the frames that were
    shown.
    """
    counts = [_frames_since_midnight(sample, rate, shot_timecode) for _, sample in received]
    known_counts = [count for count in counts if count is not None]
    if not known_counts or len(known_counts) < len(counts):
        placed_samples = list(received)
    else:
        first_frame = _first_sample_frame(
            known_counts[0], received[0][0], played, rate, shot_timecode
        )
        placed_samples = [
            (first_frame + count - known_counts[0], sample)
            for count, (_, sample) in zip(known_counts, received, strict=True)
        ]
    return [(frame, sample) for frame, sample in placed_samples if frame in played]


def _frames_since_midnight(
    sample: LensSample, rate: float, shot_timecode: tuple[int, Timecode] | None
) -> int | None:
    """Return the frames since midnight; drop frame is used if the shot uses it."""
    if sample.timecode is None:
        return None
    drop = sample.timecode.drop if shot_timecode is None else shot_timecode[1].drop
    timecode = replace(sample.timecode, drop=drop)
    return timecode.count(rate) if timecode.fits(rate) else None


def _first_sample_frame(
    first_count: int,
    shown_frame: int,
    played: FrameRange,
    rate: float,
    shot_timecode: tuple[int, Timecode] | None,
) -> int:
    """Return the frame of the first sample, which is `first_count` frames after midnight."""
    candidates = [first_count]
    if shot_timecode is not None:
        candidates.insert(0, shot_timecode[0] + first_count - shot_timecode[1].count(rate))
    possible_frames = range(
        played.first - round(rate), played.last + 1
    )  # samples may start 1 s early
    return next((frame for frame in candidates if frame in possible_frames), shown_frame)


def _track_of(placed_samples: Sequence[FrameSample], parameter: LensParameter) -> Track:
    """Return a parameter by frame; the last one of several samples at a frame counts."""
    values = ((frame, getattr(sample, parameter)) for frame, sample in placed_samples)
    return {frame: value for frame, value in values if value is not None}
