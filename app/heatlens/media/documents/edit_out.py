"""Write the cut of a reel with its exported frames, for editors, by OpenTimelineIO."""

import os
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from heatlens.core.base.errors import InputError
from heatlens.core.model.curves.frames import FrameRange
from heatlens.core.model.shot.lens_parameter import LensParameter
from heatlens.core.model.shot.pull import bake_live_focus
from heatlens.core.model.shot.reel import Reel, Retime
from heatlens.core.model.shot.shot import Shot
from heatlens.core.model.units import format_distance
from heatlens.media.documents.edit_file import otio
from heatlens.media.files.atomic_file import replace_atomically
from heatlens.media.sequence.names import NameForm

EDIT_OUT_SUFFIX = ".otio"


@dataclass(frozen=True)
class ExportedShot:
    """The frames of a shot that were exported, in the files of `form` in `folder`.

    cut     the frames that the cut shows; the others are handles
    retime  how the cut plays them; None for each once, in order
    """

    shot: Shot
    folder: Path
    form: NameForm
    frames: FrameRange
    cut: FrameRange
    retime: Retime | None = None


def check_edit_out(path: Path) -> None:
    """Raise InputError unless the file is one of OpenTimelineIO."""
    if path.suffix.lower() != EDIT_OUT_SUFFIX:
        raise InputError(f"--edit-out {path}: the name must end in {EDIT_OUT_SUFFIX}.")


def write_edit(path: Path, reel: Reel, exported_shots: Mapping[str, ExportedShot]) -> None:
    """Write the cut completely or not at all; `exported_shots` holds each shot by its name."""
    schema, time = otio().schema, otio().opentime
    rate, gaps = reel.frames_per_second, dict(reel.gaps)
    timeline = schema.Timeline(reel.name)
    if reel.start_timecode:
        timeline.global_start_time = time.from_timecode(reel.start_timecode, rate)
    track = schema.Track("heatlens", kind=schema.TrackKind.Video)
    timeline.tracks.append(track)
    items = [_clip(shot.name, exported_shots[shot.name], rate) for shot in reel.shots]
    for number, item in enumerate([*items, None]):
        if number in gaps:
            track.append(schema.Gap(duration=time.RationalTime(gaps[number], rate)))
        if item is not None:
            track.append(item)
    with replace_atomically(path) as temporary_path:
        otio().adapters.write_to_file(timeline, os.fspath(temporary_path), "otio_json")


def _clip(name: str, exported_shot: ExportedShot, rate: float) -> Any:
    """Return the clip of an exported shot, with its speed and the markers of its focus."""
    schema = otio().schema
    media = schema.ImageSequenceReference(
        target_url_base=f"{exported_shot.folder.absolute().as_uri()}/",
        name_prefix=exported_shot.form.prefix,
        name_suffix=exported_shot.form.suffix,
        start_frame=exported_shot.frames.first,
        frame_step=exported_shot.retime.step if exported_shot.retime else 1,
        rate=rate,
        frame_zero_padding=exported_shot.form.padding,
        available_range=_time_range(exported_shot.frames, rate),
    )
    clip = schema.Clip(name, media, _time_range(exported_shot.cut, rate))
    if exported_shot.retime is not None:
        _set_speed(clip, exported_shot.retime, rate)
    clip.markers.extend(_focus_markers(exported_shot, rate))
    return clip


def _set_speed(clip: Any, retime: Retime, rate: float) -> None:
    """Set the times of a clip that the cut plays at another speed; backwards, from the end."""
    schema, time = otio().schema, otio().opentime
    first = retime.start + min(0.0, retime.speed * (retime.count - 1))
    clip.source_range = time.TimeRange(
        time.RationalTime(first, rate), time.RationalTime(retime.count, rate)
    )
    is_freeze = retime.speed == 0
    clip.effects.append(
        schema.FreezeFrame() if is_freeze else schema.LinearTimeWarp(time_scalar=retime.speed)
    )


def _focus_markers(exported_shot: ExportedShot, rate: float) -> Iterable[Any]:
    """Yield a marker for each key of the focus within the cut."""
    for key in bake_live_focus(exported_shot.shot).curves.of(LensParameter.FOCUS_DISTANCE).keys:
        if key.frame in exported_shot.cut:
            frame = FrameRange(round(key.frame), round(key.frame))
            yield otio().schema.Marker(
                f"focus {format_distance(key.value)}", marked_range=_time_range(frame, rate)
            )


def _time_range(frames: FrameRange, rate: float) -> Any:
    """Return the TimeRange of OpenTimelineIO for frames at this rate."""
    time = otio().opentime
    first, count = time.RationalTime(frames.first, rate), time.RationalTime(frames.count, rate)
    return time.TimeRange(first, count)
