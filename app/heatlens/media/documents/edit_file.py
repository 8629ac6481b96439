"""Read the cut of an editor, by OpenTimelineIO: .otio, EDL, XML of Final Cut, AAF.

Each clip of the picture becomes a shot with the frames of its media that the cut shows. A note of
the shot reports what a reel cannot hold, such as a dissolve.
"""

import math
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from types import ModuleType
from typing import Any, cast

from heatlens.core.base.errors import HeatlensError, InputError
from heatlens.core.base.extras import import_extra
from heatlens.core.base.outside_text import one_line
from heatlens.core.base.paths import read_file_bytes, unreadable_error
from heatlens.core.model.curves.frames import FRAMES_PER_SECOND, FrameRange, exact_rate
from heatlens.core.model.option import Values
from heatlens.core.model.shot.grade import Grade
from heatlens.core.model.shot.reel import (
    EditOptions,
    Reel,
    ReelShot,
    Retime,
    check_cut_length,
    shot_name,
    with_unique_names,
)
from heatlens.core.model.timecode import timecode_at
from heatlens.core.model.units import parse_distance_m
from heatlens.media.documents.edit_media import MediaFinder, resolve_frames
from heatlens.media.documents.edit_times import ShownSpan, shown_spans
from heatlens.media.documents.edit_types import Item, Timeline
from heatlens.media.documents.edl_text import prepare_edl
from heatlens.media.files.apart import call_in_process
from heatlens.media.files.limits import allow_for, is_bounded

_ADAPTERS = {".edl": "cmx_3600", ".xml": "fcp_xml", ".aaf": "AAF"}
_PACKAGES = {".edl": "otio_cmx3600_adapter", ".xml": "otio_fcp_adapter", ".aaf": "otio_aaf_adapter"}
_AAF_SIGNATURE = bytes.fromhex("d0cf11e0a1b11ae1")  # of all compound files


def otio() -> ModuleType:
    """Return the module opentimelineio. Raises InputError that says what to install."""
    return import_extra("opentimelineio")


def read_edit(path: Path, options: EditOptions) -> Reel:
    """Return the reel of an edit. Raises InputError if it cannot be read, or shows no picture.

    The edit is read in a process of its own with limits of time and memory, unless this process has
    such limits already. A damaged file can crash OpenTimelineIO, or keep it busy for ever.
    """
    if is_bounded():
        return _read_reel_bounded((path, options))
    return call_in_process(_read_reel_bounded, (path, options), str(path))


def _read_reel_bounded(arguments: tuple[Path, EditOptions]) -> Reel:
    """Read the reel of an edit, (path, options), in a process with limits of time and memory."""
    path, options = arguments
    allow_for(path)
    timeline = read_timeline(path, options.rate)
    with _raise_input_error(f"{path} holds something impossible"):
        return reel_of_timeline(path, timeline, options)


@contextmanager
def _raise_input_error(sentence: str) -> Iterator[None]:
    """Convert whatever OpenTimelineIO raises in the block to an InputError that starts `sentence`.

    Its adapters and schemas raise errors of any type, such as AttributeError and IndexError.
    """
    try:
        yield
    except (HeatlensError, MemoryError):
        raise
    except Exception as error:
        raise InputError(f"{sentence}: {one_line(error)}.") from error


def reel_of_timeline(path: Path, timeline: Timeline, options: EditOptions) -> Reel:
    """Return the reel of a timeline of the file `path`, with its nested tracks laid out."""
    spans = shown_spans(timeline.tracks)
    finder = MediaFinder(path, options.folders)
    clips = [span.clip for span in spans if span.clip is not None]
    if not clips:
        raise InputError(
            f"{path} has no clip in its picture tracks: export the edit with its pictures."
        )
    rate = float(clips[0].duration().rate)
    check_cut_length(float(spans[-1].end_s * exact_rate(rate)), str(path))
    shots, gaps = list[ReelShot](), dict[int, int]()
    for span in spans:
        frames = _frames_of(span, rate)
        if frames and span.clip is None:
            gaps[len(shots)] = gaps.get(len(shots), 0) + len(frames)
        elif frames:
            shots.append(_reel_shot(span, frames, finder, rate))
    start = timeline.global_start_time
    return Reel(
        name=shot_name(timeline.name or path.stem),
        shots=with_unique_names(tuple(shots)),
        frames_per_second=rate,
        start_timecode=None if start is None else str(timecode_at(start.value, rate)),
        gaps=tuple(gaps.items()),
    )


def _frames_of(span: ShownSpan, rate: float) -> range:
    """Return the frames of the cut, counted from 0, within a span."""
    frames_per_s = exact_rate(rate)
    return range(math.ceil(span.first_s * frames_per_s), math.ceil(span.end_s * frames_per_s))


def read_timeline(path: Path, rate: float | None = None) -> Timeline:
    """Return the timeline of a file. Raises InputError if it cannot be read, or holds none."""
    if not path.is_file():
        raise unreadable_error(path)
    otio_object = _read_otio(path, rate)
    timeline_type = cast(type[Timeline], otio().schema.Timeline)
    if isinstance(otio_object, timeline_type):
        return otio_object
    candidates = (
        otio_object if isinstance(otio_object, otio().schema.SerializableCollection) else ()
    )
    found_timeline = next((it for it in candidates if isinstance(it, timeline_type)), None)
    if found_timeline is None:
        raise InputError(f"{path} holds no timeline.")
    return found_timeline


def _read_otio(path: Path, rate: float | None) -> Any:
    """Return whatever a file holds for OpenTimelineIO. Raises InputError if that fails."""
    suffix = path.suffix.lower()
    if (
        suffix == ".aaf" and read_file_bytes(path)[: len(_AAF_SIGNATURE)] != _AAF_SIGNATURE
    ):  # its reader leaves it open
        raise InputError(f"{path} cannot be read as an edit: it is not an AAF file")
    adapters = otio().adapters
    if suffix in _ADAPTERS:
        import_extra(_PACKAGES[suffix])
    if suffix == ".edl":
        return _read_edl(path, rate or FRAMES_PER_SECOND)
    with _raise_input_error(f"{path} cannot be read as an edit"):
        return adapters.read_from_file(os.fspath(path), _ADAPTERS.get(suffix))


def _read_edl(path: Path, rate: float) -> Any:
    """Return the timeline of an EDL at this rate. Raises InputError."""
    text = prepare_edl(path, read_file_bytes(path).decode("utf-8-sig", "replace"), rate)
    with _raise_input_error(f"{path} cannot be read as an edit"):
        timeline = otio().adapters.read_from_string(text, _ADAPTERS[".edl"], rate=rate)
    return _align_tracks(timeline)


def _align_tracks(timeline: Any) -> Any:
    """Return the timeline of an EDL with all tracks beginning at the earliest timecode.

    The adapter stores the record time of a track as a range that starts at minus that time. Later
    tracks get a gap in front.
    """
    tracks, schema, time = list(timeline.tracks), otio().schema, otio().opentime
    zero = time.RationalTime(0, 1)
    start_times = [
        zero - track.source_range.start_time if track.source_range else zero for track in tracks
    ]
    for track, start_time in zip(tracks, start_times, strict=True):
        # Only the order of the tracks and the gaps in them place the clips from here on.
        track.source_range = None
        if start_time > min(start_times):
            track.insert(0, schema.Gap(duration=start_time - min(start_times)))
    if timeline.global_start_time is None and tracks:
        timeline.global_start_time = min(start_times)
    return timeline


def _reel_shot(span: ShownSpan, frames: range, finder: MediaFinder, rate: float) -> ReelShot:
    """Return the shot of a clip that the cut shows at `frames`, with notes for the user."""
    clip = span.clip
    assert clip is not None  # a gap is no shot
    media = finder.find_media(clip)
    exported_frames, retime, start_note = resolve_frames(span, frames, media, rate)
    has_frames = media.sequence is None or exported_frames.intersection(
        FrameRange(media.sequence.first, media.sequence.last)
    )
    grade, grade_note = _clip_grade(clip.metadata.get("cdl"))
    notes = (
        _speed_note(span, retime),
        start_note if media.source else f"its media are missing: {media.edit_name}",
        media.note,
        "" if has_frames else f"none of its frames {exported_frames} exists: {media.edit_name}",
        _rate_note(clip, rate),
        grade_note,
        *_transition_notes(clip),
    )
    marks, marker_notes = _split_markers(clip)
    all_notes = (*filter(None, notes), *marker_notes)
    return ReelShot(
        name=shot_name(clip.name or "shot"),
        source=media.source,
        frames=exported_frames,
        notes=all_notes,
        marks=marks,
        grade=grade,
        retime=retime,
    )


def _clip_grade(cdl: Any) -> tuple[Grade | None, str]:
    """Return the grade of the metadata of a clip, and a note if it cannot be read."""
    if cdl is None:
        return None, ""
    try:
        channels = dict(cdl.get("asc_sop") or {})
        values: Values = {name: tuple(map(float, it)) for name, it in channels.items()}
        return Grade(**values, saturation=float(cdl.get("asc_sat", 1.0))), ""
    except (ArithmeticError, AttributeError, TypeError, ValueError, InputError):
        return None, "its grade (ASC CDL) cannot be read, and is not shown"


def _speed_note(span: ShownSpan, retime: Retime | None) -> str:
    """Return a note on a clip whose speed the cut changes, and on its files; "" at usual speed."""
    if retime is None or span.clock.speed == 1:
        return ""
    if retime.speed == 0:
        return f"the cut holds this frame for {retime.count} frames"
    return (
        f"the cut plays it at {float(span.clock.speed):.4g} times the speed; as files its frames "
        "are made once each, the movie of the cut and --edit-out keep the speed"
    )


def _rate_note(clip: Item, rate: float) -> str:
    """Return a note on a clip with another frame rate than the cut; "" for the same rate."""
    clip_rate = float(clip.duration().rate)
    if clip_rate == rate:
        return ""
    return f"it runs at {clip_rate:g} frames a second, the cut at {rate:g}"


def _transition_notes(clip: Item) -> Iterator[str]:
    """Yield a note for each transition beside a clip."""
    schema, track = otio().schema, clip.parent()
    if not isinstance(track, schema.Track):
        return
    transition_before, transition_after = track.neighbors_of(clip)
    if isinstance(transition_before, schema.Transition):
        yield _transition_note(transition_before, "before it")
    if isinstance(transition_after, schema.Transition):
        yield _transition_note(transition_after, "after it")


def _transition_note(transition: Any, position: str) -> str:
    """Return the note with the --handles that the frames of a transition need."""
    frames = transition.out_offset.value + transition.in_offset.value
    return f"a transition of {frames:g} frames {position} needs --handles {math.ceil(frames / 2)}"


def _split_markers(clip: Item) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Return the focus marks among the markers, such as "A=2.4m", and the others as notes."""
    marks, notes = [], []
    for marker in clip.markers:
        text = " ".join(filter(None, (marker.name, marker.comment))).strip()
        name, sign, distance_text = (text_part.strip() for text_part in text.partition("="))
        if sign and name and _is_distance(distance_text):
            marks.append(f"{name}={distance_text}")
        elif text:
            notes.append(f"marker: {text}")
    return tuple(marks), tuple(notes)


def _is_distance(text: str) -> bool:
    """Return whether a text is a distance above 0."""
    try:
        return parse_distance_m(text) > 0
    except InputError:
        return False
