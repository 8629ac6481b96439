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
from heatlens.studio.session.live.ring_hand import RingHand
from heatlens.studio.session.opened.open_source import OpenSource
from heatlens.studio.session.shot.editing import Editing

Track = Mapping[int, float]  # value by frame
Received = tuple[int, LensSample]  # a sample, and the frame at the playhead when it came
_TOLD = {told.name for told in fields(LensSample)}
_RECORDED = tuple(it for it in LensParameter if it in _TOLD)


class RingTake:
    """Records the samples of the followed ring since `begin`."""

    def __init__(self, ring: RingHand, source: OpenSource, editing: Editing) -> None:
        self._ring, self._source, self._editing = ring, source, editing
        self._version = 0
        self._told: list[Received] = []

    def begin(self) -> None:
        """Forget all samples; only later ones count."""
        heard = self._ring.heard
        self._version, self._told = 0 if heard is None else heard.version, []

    def poll(self) -> None:
        """Record the samples that came since the last call; call this once a frame."""
        news = self._ring.since(self._version)
        self._told += [(self._editing.frame, sample) for _, sample in news]
        self._version = max((version for version, _ in news), default=self._version)

    def tracks(self, played: FrameRange) -> dict[LensParameter, Track]:
        """Return the values that moved, at each frame of `played` that has a sample."""
        if not self._ring.is_stream:
            return {}  # a controller sends no timecode: its focus was recorded at the playhead
        rate = self._editing.shot.frames_per_second
        of_shot = self._source.timecode_at(self._editing.shot, self._editing.frame)
        placed = by_timecode(self._told, played, rate, of_shot)
        tracks = {parameter: _track(placed, parameter) for parameter in _RECORDED}
        return {name: track for name, track in tracks.items() if len(set(track.values())) > 1}


def by_timecode(
    received: Sequence[Received],
    played: FrameRange,
    rate: float,
    of_shot: tuple[int, Timecode] | None = None,
) -> list[Received]:
    """Return the samples with the frames of their timecode, as far as these are in `played`.

    `of_shot` is a frame of the shot and its timecode. If the timecode of the samples is outside
    the shot, it is tried as a count of frames from midnight, as `heatlens camera --send` sends it.
    If that is outside too, the first sample is placed on the frame that was shown when it came,
    and the others relative to it. Samples without timecode are placed on the frames that were
    shown.
    """
    counts = [_count(sample, rate, of_shot) for _, sample in received]
    known = [count for count in counts if count is not None]
    if not known or len(known) < len(counts):
        placed = list(received)
    else:
        begin = _begin(known[0], received[0][0], played, rate, of_shot)
        placed = [(begin + n - known[0], s) for n, (_, s) in zip(known, received, strict=True)]
    return [(frame, sample) for frame, sample in placed if frame in played]


def _count(sample: LensSample, rate: float, of_shot: tuple[int, Timecode] | None) -> int | None:
    """Return the frames since midnight; drop frame is used if the shot uses it."""
    if sample.timecode is None:
        return None
    drop = sample.timecode.drop if of_shot is None else of_shot[1].drop
    timecode = replace(sample.timecode, drop=drop)
    return timecode.count(rate) if timecode.fits(rate) else None


def _begin(
    first: int, shown: int, played: FrameRange, rate: float, of_shot: tuple[int, Timecode] | None
) -> int:
    """Return the frame of the first sample, whose timecode is `first` frames after midnight."""
    candidates = [first]
    if of_shot is not None:
        candidates.insert(0, of_shot[0] + first - of_shot[1].count(rate))
    reach = range(played.first - round(rate), played.last + 1)  # it may start a second early
    return next((frame for frame in candidates if frame in reach), shown)


def _track(placed: Sequence[Received], parameter: LensParameter) -> Track:
    """Return a parameter by frame; the last one of several samples at a frame counts."""
    values = ((frame, getattr(sample, parameter)) for frame, sample in placed)
    return {frame: value for frame, value in values if value is not None}
