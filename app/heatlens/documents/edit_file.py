"""Read and write the cut of an editor, by OpenTimelineIO: .otio, EDL, XML of Final Cut, AAF.

Each clip of the picture becomes a shot with the frames of its media that the cut shows. What a reel
cannot hold, such as a change of speed, is said in a note of the shot. The cut of a reel is written
with its exported frames, for editors.
"""

import math
import os
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from heatlens.base.errors import InputError
from heatlens.base.extras import import_extra
from heatlens.base.outside_text import one_line
from heatlens.base.paths import file_bytes, unreadable
from heatlens.documents.edit_media import MediaFinder
from heatlens.files.apart import called_apart
from heatlens.files.atomic_file import replacing
from heatlens.files.limits import allow_for, is_bounded
from heatlens.model.curves.frames import FRAMES_PER_SECOND, FrameRange
from heatlens.model.option import Values
from heatlens.model.shot.grade import Grade
from heatlens.model.shot.pull import baked
from heatlens.model.shot.reel import Reel, ReelShot, named_apart, shot_name
from heatlens.model.shot.shot import LensParameter, Shot
from heatlens.model.timecode import timecode_at
from heatlens.model.units import format_distance, parse_distance_m
from heatlens.sequence.names import NameForm

EDIT_SUFFIXES = (".otio", ".otioz", ".edl", ".aaf", ".xml")
_ADAPTERS = {".edl": "cmx_3600", ".xml": "fcp_xml", ".aaf": "AAF"}
_AAF = bytes.fromhex("d0cf11e0a1b11ae1")  # of all compound files


@dataclass(frozen=True)
class EditOptions:
    """How to read an edit.

    folders  where to look for media that are not where the edit says, or that it names only
    rate     frames per second of an EDL, which does not tell them; None for 24
    """

    folders: tuple[Path, ...] = ()
    rate: float | None = None


def otio() -> Any:
    """Return the module opentimelineio. Raises InputError that says what to install."""
    return import_extra("opentimelineio", "Reading and writing edits", "edit")


def read_edit(path: Path, options: EditOptions) -> Reel:
    """Return the reel of an edit. Raises InputError if it cannot be read, or shows no picture.

    A damaged file can crash OpenTimelineIO, or keep it busy for ever.
    """
    if is_bounded():
        return _bounded_reel((path, options))
    return called_apart(_bounded_reel, (path, options), str(path))


def _bounded_reel(asked: tuple[Path, EditOptions]) -> Reel:
    path, options = asked
    allow_for(path)
    timeline = read_timeline(path, options.rate)
    try:
        return _reel_of(path, timeline, options)
    except (ArithmeticError, ValueError, TypeError) as error:
        raise InputError(f"{path} holds something impossible: {one_line(error)}.") from error


def _reel_of(path: Path, timeline: Any, options: EditOptions) -> Reel:
    track = otio().algorithms.flatten_stack(timeline.video_tracks())
    items = list(track)
    finder = MediaFinder(path, options.folders)
    clips = [item for item in items if isinstance(item, otio().schema.Clip)]
    if not clips:
        raise InputError(f"{path} has no clip in its picture tracks.")
    rate = float(clips[0].duration().rate)
    start = timeline.global_start_time
    return Reel(
        name=shot_name(timeline.name or path.stem),
        shots=named_apart(tuple(_shot(item, track, finder, rate) for item in _shown(items))),
        frames_per_second=rate,
        start_timecode=None if start is None else str(timecode_at(start.value, rate)),
        gaps=tuple(_gaps(items)),
    )


def read_timeline(path: Path, rate: float | None = None) -> Any:
    """Return the timeline of a file. Raises InputError if it cannot be read, or holds none."""
    if not path.is_file():
        raise unreadable(path)
    read, timeline = _read(path, rate), otio().schema.Timeline
    if isinstance(read, timeline):
        return read
    several = read if isinstance(read, otio().schema.SerializableCollection) else ()
    found = next((one for one in several if isinstance(one, timeline)), None)
    if found is None:
        raise InputError(f"{path} holds no timeline.")
    return found


def _read(path: Path, rate: float | None) -> Any:
    """Return whatever a file holds for OpenTimelineIO. Raises InputError if that fails."""
    suffix = path.suffix.lower()
    if suffix == ".aaf" and file_bytes(path)[: len(_AAF)] != _AAF:  # its reader leaves it open
        raise InputError(f"{path} cannot be read as an edit: it is not an AAF file")
    values = {"rate": rate or FRAMES_PER_SECOND} if suffix == ".edl" else {}
    adapters = otio().adapters
    try:
        return adapters.read_from_file(os.fspath(path), _ADAPTERS.get(suffix), **values)
    except Exception as error:  # adapters pass on whatever their parsers raise
        raise InputError(f"{path} cannot be read as an edit: {one_line(error)}") from error


def _shown(items: list[Any]) -> Iterator[Any]:
    """Yield the clips, and what stands for several: a stack or a nested track."""
    schema = otio().schema
    yield from (it for it in items if not isinstance(it, schema.Gap | schema.Transition))


def _gaps(items: list[Any]) -> Iterator[tuple[int, int]]:
    """Yield the empty frames before clips, with the numbers of the clips."""
    schema, number, empty = otio().schema, 0, 0
    for item in items:
        if isinstance(item, schema.Gap):
            empty += round(item.duration().value)
        elif not isinstance(item, schema.Transition):
            if empty:
                yield number, empty
            number, empty = number + 1, 0


def _shot(item: Any, track: Any, finder: MediaFinder, rate: float) -> ReelShot:
    name = shot_name(item.name or "shot")
    if not isinstance(item, otio().schema.Clip):
        note = "several clips are nested here: flatten them in the editor"
        return ReelShot(name, "", notes=(note,))
    media, (start, count, changed) = finder.of(item), _times(item)
    first, doubt = media.frame_at(start, float(item.duration().rate))
    frames = FrameRange(first, first + count - 1)
    there = media.sequence is None or frames.intersection(
        FrameRange(media.sequence.first, media.sequence.last)
    )
    grade, ungraded = _grade(item.metadata.get("cdl"))
    notes = (
        changed,
        doubt if media.source else f"its media are missing: {media.told}",
        media.note,
        "" if there else f"none of its frames {frames} exists: {media.told}",
        _rate_note(item, rate),
        ungraded,
        *_dissolves(item, track),
    )
    marks, others = _markers(item)
    return ReelShot(name, media.source, frames, (*filter(None, notes), *others), marks, grade)


def _grade(told: Any) -> tuple[Grade | None, str]:
    """Return the grade of the metadata of a clip, and a note if it cannot be read."""
    if told is None:
        return None, ""
    try:
        channels = dict(told.get("asc_sop") or {})
        values: Values = {name: tuple(map(float, it)) for name, it in channels.items()}
        return Grade(**values, saturation=float(told.get("asc_sat", 1.0))), ""
    except (ArithmeticError, AttributeError, TypeError, ValueError, InputError):
        return None, "its grade (ASC CDL) cannot be read, and is not shown"


def _times(clip: Any) -> tuple[float, int, str]:
    """Return the first time of the media that a clip shows, its frames, and a note on its speed."""
    shown = clip.trimmed_range()
    start, count = float(shown.start_time.value), max(1, round(shown.duration.value))
    speed = math.prod(
        effect.time_scalar for effect in clip.effects if hasattr(effect, "time_scalar")
    )
    if speed == 1.0:
        return start, count, ""
    if speed == 0.0:
        return start, 1, f"the cut holds this frame for {count} frames"
    told = f"the cut plays it at {speed:.4g} times the speed; its frames are made once each"
    return start, max(1, math.ceil(count * abs(speed))), told


def _rate_note(clip: Any, rate: float) -> str:
    own = float(clip.duration().rate)
    return "" if own == rate else f"it runs at {own:g} frames a second, the cut at {rate:g}"


def _dissolves(clip: Any, track: Any) -> Iterator[str]:
    """Yield a note for each transition beside a clip."""
    before, after = track.neighbors_of(clip)
    schema = otio().schema
    if isinstance(before, schema.Transition):
        yield _dissolve_words(before.out_offset.value + before.in_offset.value, "before it")
    if isinstance(after, schema.Transition):
        yield _dissolve_words(after.out_offset.value + after.in_offset.value, "after it")


def _dissolve_words(frames: float, where: str) -> str:
    return f"a transition of {frames:g} frames {where} needs --handles {math.ceil(frames / 2)}"


def _markers(clip: Any) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Return the markers that are focus marks, such as "A=2.4m", and the others as notes."""
    marks, notes = [], []
    for marker in clip.markers:
        text = " ".join(filter(None, (marker.name, marker.comment))).strip()
        name, sign, place = (part.strip() for part in text.partition("="))
        if sign and name and _is_distance(place):
            marks.append(f"{name}={place}")
        elif text:
            notes.append(f"marker: {text}")
    return tuple(marks), tuple(notes)


def _is_distance(text: str) -> bool:
    try:
        return parse_distance_m(text) > 0
    except InputError:
        return False


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
