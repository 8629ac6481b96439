"""Match the rows of a shoot's table with the frames of a shot that have the same timecode."""

from collections.abc import Sequence
from dataclasses import replace

from heatlens.core.model.curves.frames import FrameRange
from heatlens.core.model.timecode import Timecode
from heatlens.media.camera.samples import CameraSamples, fields_of

Placed = tuple[int, Timecode]  # a frame of a shot and its timecode


def at_timecode(
    camera: CameraSamples, of_shot: Placed | None, rate: float, frames: FrameRange | None
) -> CameraSamples:
    """Return the camera of a table with each row at the frame that has its timecode.

    `of_shot` is any frame of the shot with its timecode, `rate` the frames per second of both. Rows
    outside `frames`, the frames of the shot, are left out; None leaves out none. One note says what
    was matched. A camera without timecodes, or a shot without one, is returned as it is; if nothing
    matches, the rows keep the table's frames, and a note says so.
    """
    if camera.timecodes is None or of_shot is None:
        return camera
    placed = _frames_of(camera.timecodes, of_shot, rate)
    if placed is None:
        return _noted(
            camera, "The table's timecodes do not fit the rate of the shot, so they place no row."
        )
    kept = _kept(placed, frames)
    if not kept:
        return _noted(camera, _nothing_matched(camera.timecodes, of_shot))
    return _noted(_rows(camera, kept, placed), _matched(camera.timecodes, kept, placed, frames))


def _frames_of(
    timecodes: Sequence[Timecode], of_shot: Placed, rate: float
) -> tuple[int, ...] | None:
    """Return the frame of each row; None if a timecode does not fit this rate."""
    frame, start = of_shot
    alike = [replace(timecode, drop=start.drop) for timecode in timecodes]  # rarely in the table
    if not all(timecode.fits(rate) for timecode in (*alike, start)):
        return None
    begin = start.count(rate)
    return tuple(frame + timecode.count(rate) - begin for timecode in alike)


def _kept(placed: Sequence[int], frames: FrameRange | None) -> tuple[int, ...]:
    """Return the indices of the rows to use: in order, one for each frame, and inside the shot."""
    kept: list[int] = []
    for index, frame in enumerate(placed):
        is_inside = frames is None or frame in frames
        if is_inside and (not kept or frame > placed[kept[-1]]):
            kept.append(index)
    return tuple(kept)


def _rows(camera: CameraSamples, kept: Sequence[int], placed: Sequence[int]) -> CameraSamples:
    tracks: dict[str, object] = {
        name: tuple(track[index] for index in kept) for name, track in camera.lens_tracks.items()
    }
    assert camera.timecodes is not None
    timecodes = tuple(camera.timecodes[index] for index in kept)
    frames = tuple(placed[index] for index in kept)
    return replace(camera, frames=frames, timecodes=timecodes, **fields_of(tracks))


def _matched(
    timecodes: Sequence[Timecode],
    kept: Sequence[int],
    placed: Sequence[int],
    frames: FrameRange | None,
) -> str:
    """Return a sentence on the rows that were matched, and those outside the shot."""
    first, last = kept[0], kept[-1]
    where = f"{timecodes[first]} is frame {placed[first]}, {timecodes[last]} frame {placed[last]}"
    words = f"{len(kept)} of {len(timecodes)} rows matched by timecode: {where}"
    outside = len(timecodes) - len(kept)
    missing = 0 if frames is None else frames.count - len(kept)
    if outside:
        words += f"; {outside} rows are outside the shot and were left out"
    if missing:
        words += f"; {missing} frames of the shot have no row, and their lens is interpolated"
    return f"{words}."


def _nothing_matched(timecodes: Sequence[Timecode], of_shot: Placed) -> str:
    frame, start = of_shot
    return (
        f"No row of the table has a timecode of the shot: the rows go from {timecodes[0]} to "
        f"{timecodes[-1]}, and frame {frame} is {start}. They keep the table's own frame numbers."
    )


def _noted(camera: CameraSamples, note: str) -> CameraSamples:
    return replace(camera, notes=(*camera.notes, note))
