"""Read a reel or an edit for the session, with the focus at the ends of its shots."""

from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

from heatlens.core.base.errors import HeatlensError
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.core.model.shot.reel import CutFocus, EditOptions, Reel, ReelShot
from heatlens.core.model.shot.shot import Shot
from heatlens.media.documents.reel_file import read_reel
from heatlens.media.documents.shot_file import is_shot_file, read_shot
from heatlens.studio.session.files.shot_stills import FirstPicture
from heatlens.studio.session.time.playback import CutTimes


@dataclass(frozen=True)
class LoadedReel:
    """A reel, its file, and the focus of its shots by their names; path None for a new reel."""

    path: Path | None
    reel: Reel
    focus: dict[str, CutFocus]


def load_reel(path: Path, folders: tuple[Path, ...] = ()) -> LoadedReel:
    """Read a reel or an edit, with the focus at both ends of each shot."""
    reel = read_reel(path, EditOptions(folders))
    return LoadedReel(path, reel, {shot.name: focus_in_file(shot) for shot in reel.shots})


def first_picture_of(shot: ReelShot, options: PlateOptions) -> FirstPicture:
    """Return source, plate options and first frame of a shot; source "" if its file is damaged."""
    if not is_shot_file(shot.source):
        return shot.source, options, None if shot.frames is None else shot.frames.first
    try:
        file_shot = read_shot(shot.source)
    except HeatlensError:  # reported when the shot is opened
        return "", options, None
    frames = shot.frames or file_shot.played_frames
    return file_shot.source or "", file_shot.plate_options, None if frames is None else frames.first


def focus_in_file(shot: ReelShot) -> CutFocus:
    """Return the focus of a shot with a file; plates have none before they are opened."""
    if not is_shot_file(shot.source):
        return CutFocus()
    try:
        return focus_of(read_shot(shot.source), shot)
    except HeatlensError:  # reported when the shot is opened
        return CutFocus()


def focus_of(shot: Shot, reel_shot: ReelShot) -> CutFocus:
    """Return the focus at the first and the last frame of the cut."""
    frames = reel_shot.frames or shot.played_frames
    first, last = (0, 0) if frames is None else (frames.first, frames.last)
    return CutFocus(shot.lens_at(first).focus_distance_m, shot.lens_at(last).focus_distance_m)


@lru_cache(maxsize=1)  # it is asked for in each frame of the window
def cut_times(reel: Reel, number: int) -> CutTimes | None:
    """Return how a reel retimes a shot; None if it shows each frame once."""
    shot = reel.shots[number]
    return None if shot.retime is None else CutTimes(shot.source_frames, reel.frames_per_second)
