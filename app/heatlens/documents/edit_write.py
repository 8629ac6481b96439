"""Write the cut of a reel with its exported frames, for editors: OpenTimelineIO."""

import os
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from heatlens.base.errors import InputError
from heatlens.documents.edit_read import otio
from heatlens.files.atomic_file import replacing
from heatlens.model.curves.frames import FrameRange
from heatlens.model.shot.pull import baked
from heatlens.model.shot.reel import Reel
from heatlens.model.shot.shot import LensParameter, Shot
from heatlens.model.units import format_distance
from heatlens.sequence.names import NameForm

EDIT_OUT_SUFFIX = ".otio"


@dataclass(frozen=True)
class Exported:
    """The frames of a shot that were exported, in the files of `form` in `folder`.

    cut  those that the cut shows, the others being handles
    """

    shot: Shot
    folder: Path
    form: NameForm
    frames: FrameRange
    cut: FrameRange


def check_edit_out(path: Path) -> None:
    """Raise InputError unless the file is one of OpenTimelineIO."""
    if path.suffix.lower() != EDIT_OUT_SUFFIX:
        raise InputError(f"--edit-out {path}: the name must end in {EDIT_OUT_SUFFIX}.")


def write_edit(path: Path, reel: Reel, exported: Mapping[str, Exported]) -> None:
    """Write the cut completely or not at all; `exported` has a name of each shot."""
    schema, time = otio().schema, otio().opentime
    rate, gaps = reel.frames_per_second, dict(reel.gaps)
    timeline = schema.Timeline(reel.name)
    if reel.start_timecode:
        timeline.global_start_time = time.from_timecode(reel.start_timecode, rate)
    track = schema.Track("heatlens", kind=schema.TrackKind.Video)
    timeline.tracks.append(track)
    for number, shot in enumerate(reel.shots):
        if number in gaps:
            track.append(schema.Gap(duration=time.RationalTime(gaps[number], rate)))
        track.append(_clip(shot.name, exported[shot.name], rate))
    with replacing(path) as beside:
        otio().adapters.write_to_file(timeline, os.fspath(beside), "otio_json")


def _clip(name: str, made: Exported, rate: float) -> Any:
    schema = otio().schema
    media = schema.ImageSequenceReference(
        target_url_base=f"{made.folder.absolute().as_uri()}/",
        name_prefix=made.form.prefix,
        name_suffix=made.form.suffix,
        start_frame=made.frames.first,
        frame_step=1,
        rate=rate,
        frame_zero_padding=made.form.padding,
        available_range=_range(made.frames, rate),
    )
    clip = schema.Clip(name, media, _range(made.cut, rate))
    clip.markers.extend(_pulls(made, rate))
    return clip


def _pulls(made: Exported, rate: float) -> Iterable[Any]:
    """Yield a marker for each key of the focus within the cut."""
    for key in baked(made.shot).curves.of(LensParameter.FOCUS_DISTANCE).keys:
        if key.frame in made.cut:
            frame = FrameRange(round(key.frame), round(key.frame))
            yield otio().schema.Marker(
                f"focus {format_distance(key.value)}", marked_range=_range(frame, rate)
            )


def _range(frames: FrameRange, rate: float) -> Any:
    time = otio().opentime
    first, count = time.RationalTime(frames.first, rate), time.RationalTime(frames.count, rate)
    return time.TimeRange(first, count)
