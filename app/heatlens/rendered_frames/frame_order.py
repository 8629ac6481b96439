"""The order in which the frames of a shot are rendered and read ahead."""

from heatlens.model.frames import FrameRange


def frames_from(playhead: int, direction: int, played: FrameRange, most: int) -> tuple[int, ...]:
    """Return up to `most` of the played frames, from the playhead on in the direction of playback.

    Playback loops, so the first frame follows the last. A playhead outside the played range counts
    as its beginning.
    """
    step = 1 if direction >= 0 else -1
    begin = playhead if playhead in played else (played.first if step > 0 else played.last)
    at, count = begin - played.first, played.count
    return tuple(played.first + (at + i * step) % count for i in range(min(most, count)))


def runs_of(frames: frozenset[int]) -> tuple[FrameRange, ...]:
    """Return neighbouring frames as ranges, in order."""
    runs: list[FrameRange] = []
    for frame in sorted(frames):
        if runs and runs[-1].last == frame - 1:
            runs[-1] = FrameRange(runs[-1].first, frame)
        else:
            runs.append(FrameRange(frame, frame))
    return tuple(runs)
