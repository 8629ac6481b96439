"""Measure what a focus that follows is on, again wherever the files have changed."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from heatlens.core.base.errors import InputError
from heatlens.core.model.focus.live_focus import LiveFocus, MeasuredMark
from heatlens.core.model.marks.mark import Mark
from heatlens.core.model.shot.shot import Shot
from heatlens.media.files.json_record import digest, plain
from heatlens.render.source.named import source_of
from heatlens.render.source.source import Source

_STILL_FRAME = 1  # of a single picture, which is shown at every frame


def measured(shot: Shot, tell: Callable[[str], None] = lambda _: None) -> Shot:
    """Return the shot with its marks measured where they are followed, if that is not known.

    `tell` hears of the progress. Raises InputError if the source is missing, or a mark cannot be
    measured in it or is hidden at every frame.
    """
    live = shot.curves.live
    if live is None:
        return shot
    if shot.lost_marks:
        raise InputError(f"The focus follows mark {shot.lost_marks[0]}, which the shot lacks.")
    source = source_of(shot)
    marks = [mark for mark in shot.marks if mark.name in live.marks]
    state = _state(source, shot, marks)
    if live.measured and live.measured_of == state:
        return shot
    still = replace(shot, curves=replace(shot.curves, live=None))
    by_mark = {mark.name: source.distances_m(still, mark, tell) for mark in marks}
    first = min(next(iter(by_mark.values())))
    tracks = tuple(
        MeasuredMark(name, tuple(far_m for _, far_m in sorted(distances_m.items())))
        for name, distances_m in by_mark.items()
    )
    live = LiveFocus(live.pursuits, live.follow, first, tracks, state)
    return replace(shot, curves=replace(shot.curves, live=live))


def _state(source: Source, shot: Shot, marks: list[Mark]) -> str:
    """Return a digest of all that decides the distances; folders may have another name."""
    frames = shot.frames or source.frames
    files = {}
    for frame in frames or (_STILL_FRAME,):
        origin = source.origin(shot, frame, "hold")
        files[frame] = [[it.path.name, plain(it.stamp)] for it in origin.files]
    named = shot.plate_options.with_files_beside(lambda text: Path(text).name)
    own = replace(named, never_blur=None, only_blur=None, strict=False)
    facts = {
        "marks": [plain(mark) for mark in marks],
        "frames": plain(frames),
        "files": files,
        "options": plain(own),
        "framing": plain(shot.framing),
    }
    return digest(facts)
