"""Match the rows of a shoot's table with the frames of a shot that have the same timecode."""

from collections.abc import Sequence
from dataclasses import replace

from heatlens.core.model.curves.frames import FrameRange
from heatlens.core.model.timecode import Timecode
from heatlens.media.camera.samples import CameraSamples, fields_of

FrameTimecode = tuple[int, Timecode]  # a frame of a shot and its timecode


def match_by_timecode(
    camera: CameraSamples,
    shot_timecode: FrameTimecode | None,
    rate: float,
    frames: FrameRange | None,
) -> CameraSamples:
    """Return the camera of a table with each row at the frame that has its timecode.

    `shot_timecode` is any frame of the shot with its timecode, `rate` the frames per second of
    both. Rows outside `frames`, the frames of the shot, are left out; None leaves out none. A note
    counts the matches. A camera without timecodes, or a shot without one, is returned as it is; if
    nothing matches, the rows keep the table's frames, and a note says so.
    """
    if camera.timecodes is None or shot_timecode is None:
        return camera
    row_frames = _frames_of(camera.timecodes, shot_timecode, rate)
    if row_frames is None:
        return _add_note(
            camera, "The table's timecodes do not fit the rate of the shot, so they place no row."
        )
    usable_rows = _usable_rows(row_frames, frames)
    if not usable_rows:
        return _add_note(camera, _no_match_note(camera.timecodes, shot_timecode))
    return _add_note(
        _select_rows(camera, usable_rows, row_frames),
        _match_note(camera.timecodes, usable_rows, row_frames, frames),
    )


def _frames_of(
    timecodes: Sequence[Timecode], shot_timecode: FrameTimecode, rate: float
) -> tuple[int, ...] | None:
    """Return the frame of each row; None if a timecode does not fit this rate."""
    frame, start = shot_timecode
    # Tables rarely mark drop-frame counting, so all timecodes count like that of the shot.
    same_counting = [replace(timecode, drop=start.drop) for timecode in timecodes]
    if not all(timecode.fits(rate) for timecode in (*same_counting, start)):
        return None
    start_count = start.count(rate)
    return tuple(frame + timecode.count(rate) - start_count for timecode in same_counting)


def _usable_rows(row_frames: Sequence[int], frames: FrameRange | None) -> tuple[int, ...]:
    """Return the indices of the rows to use: in order, one for each frame, and inside the shot."""
    usable_rows: list[int] = []
    for index, frame in enumerate(row_frames):
        is_inside = frames is None or frame in frames
        if is_inside and (not usable_rows or frame > row_frames[usable_rows[-1]]):
            usable_rows.append(index)
    return tuple(usable_rows)


def _select_rows(
    camera: CameraSamples, row_indices: Sequence[int], row_frames: Sequence[int]
) -> CameraSamples:
    """Return the camera with the rows of these indices alone, at their frames in the shot."""
    tracks: dict[str, object] = {
        name: tuple(track[index] for index in row_indices)
        for name, track in camera.lens_tracks.items()
    }
    assert camera.timecodes is not None
    timecodes = tuple(camera.timecodes[index] for index in row_indices)
    frames = tuple(row_frames[index] for index in row_indices)
    return replace(camera, frames=frames, timecodes=timecodes, **fields_of(tracks))


def _match_note(
    timecodes: Sequence[Timecode],
    usable_rows: Sequence[int],
    row_frames: Sequence[int],
    frames: FrameRange | None,
) -> str:
    """Return a sentence on the rows that were matched, and those outside the shot."""
    first, last = usable_rows[0], usable_rows[-1]
    example = (
        f"{timecodes[first]} is frame {row_frames[first]}, {timecodes[last]} frame "
        f"{row_frames[last]}"
    )
    words = f"{len(usable_rows)} of {len(timecodes)} rows matched by timecode: {example}"
    outside = len(timecodes) - len(usable_rows)
    missing = 0 if frames is None else frames.count - len(usable_rows)
    if outside:
        words += f"; {outside} rows are outside the shot and were left out"
    if missing:
        words += f"; {missing} frames of the shot have no row, and their lens is interpolated"
    return f"{words}."


def _no_match_note(timecodes: Sequence[Timecode], shot_timecode: FrameTimecode) -> str:
    """Return a sentence on a table of which no row has a timecode of the shot."""
    frame, start = shot_timecode
    return (
        f"No row of the table has a timecode of the shot: the rows go from {timecodes[0]} to "
        f"{timecodes[-1]}, and frame {frame} is {start}. They keep the table's own frame numbers."
    )


def _add_note(camera: CameraSamples, note: str) -> CameraSamples:
    return replace(camera, notes=(*camera.notes, note))
