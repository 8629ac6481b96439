"""Read the cut of an editor, by OpenTimelineIO: .otio, EDL, XML of Final Cut, AAF.

Each clip of the picture becomes a shot with the frames of its media that the cut shows. What a reel
cannot hold, such as a dissolve, is said in a note of the shot.
"""

import math
import os
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType
from typing import Any, cast

from heatlens.core.base.errors import HeatlensError, InputError
from heatlens.core.base.extras import import_extra
from heatlens.core.base.outside_text import one_line
from heatlens.core.base.paths import file_bytes, unreadable
from heatlens.core.model.curves.frames import FRAMES_PER_SECOND, FrameRange, exact_rate
from heatlens.core.model.option import Values
from heatlens.core.model.shot.grade import Grade
from heatlens.core.model.shot.reel import (
    Reel,
    ReelShot,
    Retime,
    check_cut_length,
    named_apart,
    shot_name,
)
from heatlens.core.model.timecode import timecode_at
from heatlens.core.model.units import parse_distance_m
from heatlens.media.documents.edit_media import MediaFinder, played
from heatlens.media.documents.edit_times import Seen, seen_in
from heatlens.media.documents.edit_types import Item, Timeline
from heatlens.media.documents.edl_text import prepared
from heatlens.media.files.apart import called_apart
from heatlens.media.files.limits import allow_for, is_bounded

EDIT_SUFFIXES = (".otio", ".otioz", ".edl", ".aaf", ".xml")
_ADAPTERS = {".edl": "cmx_3600", ".xml": "fcp_xml", ".aaf": "AAF"}
_PACKAGES = {".edl": "otio_cmx3600_adapter", ".xml": "otio_fcp_adapter", ".aaf": "otio_aaf_adapter"}
_AAF = bytes.fromhex("d0cf11e0a1b11ae1")  # of all compound files


@dataclass(frozen=True)
class EditOptions:
    """How to read an edit.

    folders  where to look for media that are not where the edit says, or that it names only
    rate     frames per second of an EDL, which does not tell them; None for 24
    """

    folders: tuple[Path, ...] = ()
    rate: float | None = None


def otio() -> ModuleType:
    """Return the module opentimelineio. Raises InputError that says what to install."""
    return import_extra("opentimelineio")


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
    with _refused(f"{path} holds something impossible"):
        return reel_of_timeline(path, timeline, options)


@contextmanager
def _refused(sentence: str) -> Iterator[None]:
    """Raise InputError that begins with `sentence` for whatever OpenTimelineIO raises.

    Its adapters and its schemas pass on whatever lies below them: a missing attribute, an index.
    """
    try:
        yield
    except (HeatlensError, MemoryError):
        raise
    except Exception as error:
        raise InputError(f"{sentence}: {one_line(error)}.") from error


def reel_of_timeline(path: Path, timeline: Timeline, options: EditOptions) -> Reel:
    """Return the reel of a timeline of the file `path`, with its nested tracks laid out."""
    seen = seen_in(timeline.tracks)
    finder = MediaFinder(path, options.folders)
    clips = [part.clip for part in seen if part.clip is not None]
    if not clips:
        raise InputError(f"{path} has no clip in its picture tracks.")
    rate = float(clips[0].duration().rate)
    check_cut_length(float(seen[-1].end_s * exact_rate(rate)), str(path))
    shots, gaps = list[ReelShot](), dict[int, int]()
    for part in seen:
        frames = _frames_of(part, rate)
        if frames and part.clip is None:
            gaps[len(shots)] = gaps.get(len(shots), 0) + len(frames)
        elif frames:
            shots.append(_shot(part, frames, finder, rate))
    start = timeline.global_start_time
    return Reel(
        name=shot_name(timeline.name or path.stem),
        shots=named_apart(tuple(shots)),
        frames_per_second=rate,
        start_timecode=None if start is None else str(timecode_at(start.value, rate)),
        gaps=tuple(gaps.items()),
    )


def _frames_of(part: Seen, rate: float) -> range:
    """Return the frames of the cut, from 0, that show a part."""
    exact = exact_rate(rate)
    return range(math.ceil(part.first_s * exact), math.ceil(part.end_s * exact))


def read_timeline(path: Path, rate: float | None = None) -> Timeline:
    """Return the timeline of a file. Raises InputError if it cannot be read, or holds none."""
    if not path.is_file():
        raise unreadable(path)
    read, timeline = _read(path, rate), cast(type[Timeline], otio().schema.Timeline)
    if isinstance(read, timeline):
        return read
    several = read if isinstance(read, otio().schema.SerializableCollection) else ()
    chosen = next((one for one in several if isinstance(one, timeline)), None)
    if chosen is None:
        raise InputError(f"{path} holds no timeline.")
    return chosen


def _read(path: Path, rate: float | None) -> Any:
    """Return whatever a file holds for OpenTimelineIO. Raises InputError if that fails."""
    suffix = path.suffix.lower()
    if suffix == ".aaf" and file_bytes(path)[: len(_AAF)] != _AAF:  # its reader leaves it open
        raise InputError(f"{path} cannot be read as an edit: it is not an AAF file")
    adapters = otio().adapters
    if suffix in _ADAPTERS:
        import_extra(_PACKAGES[suffix])
    if suffix == ".edl":
        return _edl(path, rate or FRAMES_PER_SECOND)
    with _refused(f"{path} cannot be read as an edit"):
        return adapters.read_from_file(os.fspath(path), _ADAPTERS.get(suffix))


def _edl(path: Path, rate: float) -> Any:
    text = prepared(path, file_bytes(path).decode("utf-8-sig", "replace"), rate)
    with _refused(f"{path} cannot be read as an edit"):
        timeline = otio().adapters.read_from_string(text, _ADAPTERS[".edl"], rate=rate)
    return _begun_together(timeline)


def _begun_together(timeline: Any) -> Any:
    """Let the tracks of an EDL begin at the timecode of the first one.

    Its adapter tells where each was recorded as a range that begins at minus that time.
    """
    tracks, schema, time = list(timeline.tracks), otio().schema, otio().opentime
    zero = time.RationalTime(0, 1)
    begins = [zero - it.source_range.start_time if it.source_range else zero for it in tracks]
    for track, begin in zip(tracks, begins, strict=True):
        track.source_range = None
        if begin > min(begins):
            track.insert(0, schema.Gap(duration=begin - min(begins)))
    if timeline.global_start_time is None and tracks:
        timeline.global_start_time = min(begins)
    return timeline


def _shot(part: Seen, frames: range, finder: MediaFinder, rate: float) -> ReelShot:
    clip = part.clip
    assert clip is not None  # a gap is no shot
    media = finder.of(clip)
    made, retime, doubt = played(part, frames, media, rate)
    there = media.sequence is None or made.intersection(
        FrameRange(media.sequence.first, media.sequence.last)
    )
    grade, ungraded = _grade(clip.metadata.get("cdl"))
    notes = (
        _speed_note(part, retime),
        doubt if media.source else f"its media are missing: {media.told}",
        media.note,
        "" if there else f"none of its frames {made} exists: {media.told}",
        _rate_note(clip, rate),
        ungraded,
        *_dissolves(clip),
    )
    marks, others = _markers(clip)
    kept = (*filter(None, notes), *others)
    return ReelShot(shot_name(clip.name or "shot"), media.source, made, kept, marks, grade, retime)


def _grade(cdl: Any) -> tuple[Grade | None, str]:
    """Return the grade of the metadata of a clip, and a note if it cannot be read."""
    if cdl is None:
        return None, ""
    try:
        channels = dict(cdl.get("asc_sop") or {})
        values: Values = {name: tuple(map(float, it)) for name, it in channels.items()}
        return Grade(**values, saturation=float(cdl.get("asc_sat", 1.0))), ""
    except (ArithmeticError, AttributeError, TypeError, ValueError, InputError):
        return None, "its grade (ASC CDL) cannot be read, and is not shown"


def _speed_note(part: Seen, retime: Retime | None) -> str:
    """Return what the cut does to the speed of a clip, and what that means for files; "" if not."""
    if retime is None or part.clock.speed == 1:
        return ""
    if retime.speed == 0:
        return f"the cut holds this frame for {retime.count} frames"
    return (
        f"the cut plays it at {float(part.clock.speed):.4g} times the speed; as files its frames "
        "are made once each, the movie of the cut and --edit-out keep the speed"
    )


def _rate_note(clip: Item, rate: float) -> str:
    own = float(clip.duration().rate)
    return "" if own == rate else f"it runs at {own:g} frames a second, the cut at {rate:g}"


def _dissolves(clip: Item) -> Iterator[str]:
    """Yield a note for each transition beside a clip."""
    schema, track = otio().schema, clip.parent()
    if not isinstance(track, schema.Track):
        return
    before, after = track.neighbors_of(clip)
    if isinstance(before, schema.Transition):
        yield _dissolve_words(before.out_offset.value + before.in_offset.value, "before it")
    if isinstance(after, schema.Transition):
        yield _dissolve_words(after.out_offset.value + after.in_offset.value, "after it")


def _dissolve_words(frames: float, where: str) -> str:
    return f"a transition of {frames:g} frames {where} needs --handles {math.ceil(frames / 2)}"


def _markers(clip: Item) -> tuple[tuple[str, ...], tuple[str, ...]]:
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
