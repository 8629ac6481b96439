"""What the ring did while a shot was recorded, on the frames of its timecode.

A window draws when it can; a camera tells of each sample to which frame it belongs. So all samples
of the ring are taken down, and are put on their frames when the recording ends.
"""

from collections.abc import Mapping, Sequence

from heatlens.model.frames import FrameRange
from heatlens.model.shot import LensParameter
from heatlens.model.timecode import Timecode
from heatlens.ring.lens_sample import LensSample
from heatlens.session.editing import Editing
from heatlens.session.open_source import OpenSource
from heatlens.session.ring_hand import RingHand

Track = Mapping[int, float]  # value by frame
Told = tuple[int, LensSample]  # the frame at the playhead when a sample came, and the sample
_RECORDED = (LensParameter.FOCUS_DISTANCE, LensParameter.F_STOP, LensParameter.FOCAL_LENGTH)


class RingTake:
    """Takes down the samples of the ring that is followed, from `begin` on."""

    def __init__(self, ring: RingHand, source: OpenSource, editing: Editing) -> None:
        self._ring = ring
        self._source = source
        self._editing = editing
        self._version = 0
        self._told: list[Told] = []

    def begin(self) -> None:
        """Forget what was taken down; only what comes from now on counts."""
        heard = self._ring.heard
        self._version, self._told = 0 if heard is None else heard.version, []

    def poll(self) -> None:
        """Take down what has come since; call this in each frame of the window."""
        news = self._ring.since(self._version)
        self._told += [(self._editing.frame, sample) for _, sample in news]
        self._version = max((version for version, _ in news), default=self._version)

    def tracks(self, played: FrameRange) -> dict[LensParameter, Track]:
        """Return what moved, at each frame of `played` for which a sample came."""
        if not self._ring.is_stream:
            return {}  # a controller tells only changes: the hand at the playhead is what it did
        placed = by_timecode(self._told, played, self._rate, self._timecode)
        tracks = {parameter: _track(placed, parameter) for parameter in _RECORDED}
        return {name: track for name, track in tracks.items() if len(set(track.values())) > 1}

    @property
    def _rate(self) -> float:
        return self._editing.shot.frames_per_second

    @property
    def _timecode(self) -> tuple[int, Timecode] | None:
        """The frame at the playhead and its timecode, where the shot or its plate tells one."""
        return self._source.timecode_at(self._editing.shot, self._editing.frame)


def by_timecode(
    told: Sequence[Told],
    played: FrameRange,
    rate: float,
    of_shot: tuple[int, Timecode] | None = None,
) -> list[Told]:
    """Return the samples with the frames that their timecode means, those in `played` alone.

    `of_shot` is a frame of the shot and its timecode. Where the timecode of the samples is not that
    of the shot, a count of frames from midnight is tried, as `heatlens camera --send` sends it.
    Where that is not in the shot either, the first sample belongs to the frame that was seen when
    it came, and the others lie as far from it as their timecode does. Samples without timecode
    belong to the frames that were seen.
    """
    counts = [_count(sample, rate, of_shot) for _, sample in told]
    known = [count for count in counts if count is not None]
    if not known or len(known) < len(counts):
        placed = list(told)
    else:
        begin = _begin(known[0], told[0][0], played, rate, of_shot)
        placed = [(begin + n - known[0], s) for n, (_, s) in zip(known, told, strict=True)]
    return [(frame, sample) for frame, sample in placed if frame in played]


def _count(sample: LensSample, rate: float, of_shot: tuple[int, Timecode] | None) -> int | None:
    """Return the frames since midnight; the samples drop numbers where the shot does."""
    if sample.timecode is None:
        return None
    timecode = Timecode(*sample.timecode, drop=of_shot is not None and of_shot[1].drop)
    return timecode.count(rate) if timecode.fits(rate) else None


def _begin(
    first: int, seen: int, played: FrameRange, rate: float, of_shot: tuple[int, Timecode] | None
) -> int:
    """Return the frame of the first sample, which counts `first` frames from midnight."""
    candidates = [first]
    if of_shot is not None:
        candidates.insert(0, of_shot[0] + first - of_shot[1].count(rate))
    reach = range(played.first - round(rate), played.last + 1)  # a second of lead is usual
    return next((frame for frame in candidates if frame in reach), seen)


def _track(placed: Sequence[Told], parameter: LensParameter) -> Track:
    """Return one value by frame; of several samples at a frame the last one counts."""
    values = ((frame, getattr(sample, parameter)) for frame, sample in placed)
    return {frame: value for frame, value in values if value is not None}
