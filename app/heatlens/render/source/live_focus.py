"""Measure the marks that the focus follows, and measure again if the files have changed."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from heatlens.core.base.errors import InputError
from heatlens.core.model.focus.live_focus import LiveFocus, MeasuredMark
from heatlens.core.model.marks.mark import Mark
from heatlens.core.model.shot.shot import Shot
from heatlens.media.files.json_record import digest, to_json
from heatlens.render.source.named import source_of
from heatlens.render.source.source import Source

_STILL_FRAME = 1  # of a single picture, which is shown at every frame


def measure_followed_marks(
    shot: Shot, report_progress: Callable[[str], None] = lambda _: None
) -> Shot:
    """Return the shot with the distances in meters of the marks that its focus follows.

    A shot whose focus follows no marks is returned as it is.

    Distances are measured only if those in the shot are not of the current files. Each step calls
    `report_progress`. Raises InputError if the source is missing, or a mark cannot be measured in
    it or is hidden at every frame.
    """
    live = shot.curves.live
    if live is None:
        return shot
    if shot.missing_marks:
        raise InputError(f"The focus follows mark {shot.missing_marks[0]}, which the shot lacks.")
    source = source_of(shot)
    marks = [mark for mark in shot.marks if mark.name in live.marks]
    source_state = _source_digest(source, shot, marks)
    if live.measured and live.measured_of == source_state:
        return shot
    unfollowed_shot = replace(shot, curves=replace(shot.curves, live=None))
    by_mark = {
        mark.name: source.distances_m(unfollowed_shot, mark, report_progress) for mark in marks
    }
    first = min(next(iter(by_mark.values())))
    tracks = tuple(
        MeasuredMark(name, tuple(far_m for _, far_m in sorted(distances_m.items())))
        for name, distances_m in by_mark.items()
    )
    live = LiveFocus(live.pursuits, live.follow, first, tracks, source_state)
    return replace(shot, curves=replace(shot.curves, live=live))


def _source_digest(source: Source, shot: Shot, marks: list[Mark]) -> str:
    """Return a digest of all that decides the distances of `marks`.

    The names of folders are left out, so that files may be moved.
    """
    frames = shot.frames or source.frames
    files = {}
    for frame in frames or (_STILL_FRAME,):
        origin = source.origin(shot, frame, "hold")
        files[frame] = [[file.path.name, to_json(file.stamp)] for file in origin.files]
    plate_options = shot.plate_options.with_files_beside(lambda text: Path(text).name)
    relevant_options = replace(plate_options, never_blur=None, only_blur=None, strict=False)
    facts = {
        "marks": [to_json(mark) for mark in marks],
        "frames": to_json(frames),
        "files": files,
        "options": to_json(relevant_options),
        "framing": to_json(shot.framing),
    }
    return digest(facts)
