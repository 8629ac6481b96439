"""Find the media of the clips of an edit on disk, and the frame of a plate for a time of a clip."""

import math
import os
import re
from collections.abc import Iterable, Iterator
from collections.abc import Sequence as Items
from dataclasses import dataclass, replace
from fractions import Fraction
from pathlib import Path
from typing import Any

from heatlens.core.base.errors import InputError
from heatlens.core.base.named_paths import path_in_folder, path_of_url
from heatlens.core.model.curves.frames import FrameRange, exact_rate
from heatlens.core.model.shot.reel import Retime
from heatlens.core.model.timecode import timecode_at
from heatlens.media.documents.edit_times import ShownSpan, seconds
from heatlens.media.files.picture_formats import parse_movie_name, suffixes_read
from heatlens.media.plate.parts.header_read import first_timecode, is_marked_blurred
from heatlens.media.sequence.names import NameForm, group_sequences, parse_frame_name
from heatlens.media.sequence.sequence import Sequence
from heatlens.media.sequence.sequence_search import find_sequence

_DEPTH_MOST = 6  # folders below one of --media; deeper ones are not searched
_DIGITS = re.compile(r"%0?([0-9]{1,2})d|\[([0-9]+)-[0-9]+\]")  # %04d, and [1001-1100] of an EDL


@dataclass(frozen=True)
class Media:
    """The media of a clip.

    source     the source as shots name it; "" if it is missing
    sequence   the frames; None for a scene, a shot, and if the source is missing
    start_s    time of frame `first` in seconds, in the clock of the edit; None if it is not stated
    first      the number of the frame at `start_s`
    edit_name  the name in the edit
    rate       frames per second by which the frames are numbered; None for the rate of the clip
    step       distance in frame numbers from one existing frame to the next
    note       which other media in the folders fit; "" if none do
    """

    source: str
    sequence: Sequence | None
    first: int
    start_s: Fraction | None
    edit_name: str
    rate: float | None = None
    step: int = 1
    note: str = ""

    def frame_at(self, time: float, rate: float) -> tuple[int, str]:
        """Return the number of the frame at `time`, and a note for the user or "".

        This is for media without a start. `time` is counted in frames at `rate`. It is a frame
        number if there is such a frame, else a timecode of the headers, else it is counted from the
        first frame.
        """
        if self.sequence is None or round(time) in self.sequence.frames:
            return round(time), ""
        first_header_timecode = first_timecode(self.sequence)
        if first_header_timecode is not None and first_header_timecode[1].fits(rate):
            return first_header_timecode[0] + round(time) - first_header_timecode[1].count(rate), ""
        return self.sequence.first, (
            f"the edit begins at {timecode_at(time, rate)}, but no header of the media tells a "
            "timecode: their first frame is taken"
        )


def resolve_frames(
    span: ShownSpan, frames: range, media: Media, rate: float
) -> tuple[FrameRange, Retime | None, str]:
    """Return the frames of its media that a cut shows, how it plays them, and a note or "".

    The retime is None where the frames are played once each in order.

    `frames` are those of the cut, at `rate` a second, within the span.
    """
    assert span.clip is not None  # a gap plays nothing
    time = span.clip.trimmed_range().start_time
    begin_s, first, start_note = media.start_s, media.first, ""
    if begin_s is None:
        begin_s = seconds(time)
        first, start_note = media.frame_at(float(time.value), float(time.rate))
    media_rate, cut_rate = exact_rate(media.rate or float(time.rate)), exact_rate(rate)
    start = first + (span.clock.at(frames.start / cut_rate) - begin_s) * media_rate
    speed = span.clock.speed * media_rate / cut_rate
    retime = Retime(start=float(start), speed=float(speed), count=len(frames), step=media.step)
    shown_frames = retime.source_frames(first)
    exported_frames = FrameRange(min(shown_frames), max(shown_frames))
    if shown_frames == tuple(exported_frames):
        return exported_frames, None, start_note
    return (
        FrameRange(exported_frames.first, _last_exported(retime, exported_frames, media)),
        retime,
        start_note,
    )


def _last_exported(retime: Retime, exported_frames: FrameRange, media: Media) -> int:
    """Return the last frame to export: the last one within the time that the cut shows.

    Frames that the media do not have are left out.
    """
    last_shown_time = retime.start + max(0.0, retime.speed * (retime.count - 1))
    last_frame = math.ceil(round(last_shown_time + abs(retime.speed), 6)) - 1
    if media.sequence is not None:
        last_frame = min(last_frame, media.sequence.last)
    return max(
        exported_frames.last,
        exported_frames.first + (last_frame - exported_frames.first) // retime.step * retime.step,
    )


class MediaFinder:
    """Finds media by what an edit calls them: where it says, else in the given folders.

    Where several fit, pinhole pictures come before those that heatlens has blurred: a former export
    of the same edit may lie in these folders too.
    """

    def __init__(self, edit: Path, folders: Items[Path]) -> None:
        """Take the file of the edit and the folders to search; they are listed when needed."""
        self._folder = edit.absolute().parent
        self._folders = folders
        self._sources_by_key: dict[str, dict[str, str]] | None = None

    def find_media(self, clip: Any) -> Media:
        """Return the media of a clip of OpenTimelineIO."""
        reference = _reference_of(clip)
        if reference is None:
            return self._find_by_path_or_name("", clip.name, first=None, start_s=None)
        available = reference.available_range
        start_s = None if available is None else seconds(available.start_time)
        if hasattr(reference, "frame_zero_padding"):
            target = _sequence_pattern(reference)
            first = int(reference.start_frame)
            image_rate, step = float(reference.rate), int(reference.frame_step)
            media = self._find_by_path_or_name(target, clip.name, first, start_s)
            begin_s = first / exact_rate(image_rate) if start_s is None else start_s
            return replace(media, start_s=begin_s, rate=image_rate, step=max(1, step))
        rate = None if available is None else float(available.start_time.rate)
        target = getattr(reference, "target_url", None) or ""
        return replace(
            self._find_by_path_or_name(target, clip.name or reference.name, None, start_s),
            rate=rate,
        )

    def _find_by_path_or_name(
        self, target: str, name: str, first: int | None, start_s: Fraction | None
    ) -> Media:
        """Return the media at a URL or path, or else of this name in the folders."""
        path = _absolute_path(target, self._folder) if target else ""
        for candidates in (
            [path] if path else [],
            self._find_by_name(path),
            self._find_by_name(name),
        ):
            existing = [source for source in candidates if _exists(source)]
            if existing:
                source = next(
                    (candidate for candidate in existing if not is_blurred_source(candidate)),
                    existing[0],
                )
                alternatives = [alternative for alternative in existing if alternative != source]
                return self._media_of_source(source, alternatives, target or name, first, start_s)
        return Media("", None, first or 0, start_s, target or name)

    def _media_of_source(
        self,
        source: str,
        alternatives: Items[str],
        target: str,
        first: int | None,
        start_s: Fraction | None,
    ) -> Media:
        """Return the media at `source`; `alternatives` are other sources that fit as well."""
        note, sequence = _alternatives_note(source, alternatives), _sequence_at(source)
        if sequence is None:
            return Media(source, None, first or 0, start_s, target, note=note)
        first_frame = sequence.first if first is None else first
        plates = None if sequence.is_single else sequence
        return Media(
            _source_name(source, sequence), plates, first_frame, start_s, target, note=note
        )

    def _find_by_name(self, name: str | None) -> Items[str]:
        """Return the media in the folders that are called `name`, by any of its usual forms."""
        if not name or not self._folders:
            return []
        if self._sources_by_key is None:
            self._sources_by_key = {}
            for key, source in _all_media(self._folders):
                self._sources_by_key.setdefault(key, {})[os.path.abspath(source)] = source
        sources = next(
            (self._sources_by_key[key] for key in _name_keys(name) if key in self._sources_by_key),
            {},
        )
        return list(reversed(sources.values()))


def _exists(source: str) -> bool:
    """Return True if a source is a file, or a sequence with files."""
    return _sequence_at(source) is not None or os.path.isfile(source)


def is_blurred_source(source: str) -> bool:
    """Return whether the first picture of a source is one that heatlens has blurred."""
    sequence = _sequence_at(source) if source else None
    return sequence is not None and is_marked_blurred(sequence.path_at(sequence.present[0]))


def _alternatives_note(source: str, alternatives: Items[str]) -> str:
    """Return a note that names the media that are not taken; "" if there are none."""
    if not alternatives:
        return ""
    names = (
        f"{alternative} (already blurred)" * is_blurred_source(alternative) or alternative
        for alternative in alternatives
    )
    return f"{len(alternatives) + 1} media fit: {source} is taken, and not {', '.join(names)}"


def _reference_of(clip: Any) -> Any:
    """Return the reference to the media of a clip: the active one, else another; None if none."""
    other_references = clip.media_references()
    active = other_references.pop(clip.active_media_reference_key, None)
    references = (
        reference for reference in (active, *other_references.values()) if reference is not None
    )
    return next((reference for reference in references if not reference.is_missing_reference), None)


def _sequence_pattern(reference: Any) -> str:
    """Return the pattern of the files of an ImageSequenceReference, with # for digits."""
    base = reference.target_url_base or ""
    digits = "#" * max(1, int(reference.frame_zero_padding))
    prefix = base if not base or base.endswith("/") else f"{base}/"
    return f"{prefix}{reference.name_prefix}{digits}{reference.name_suffix}"


def _absolute_path(url: str, folder: Path) -> str:
    """Return the absolute path of a URL or path; relative ones begin at the folder of the edit."""
    pattern = _DIGITS.sub(lambda match: "#" * int(match[1] or len(match[2])), url)
    is_url = url.lower().startswith("file:")
    return path_in_folder(path_of_url(pattern) if is_url else pattern, folder)


def _sequence_at(source: str) -> Sequence | None:
    """Return the sequence of a source; None if there is none."""
    try:
        return find_sequence(source)
    except InputError:
        return None


def _source_name(source: str, sequence: Sequence) -> str:
    """Return how a shot names the files: a frame of a sequence stands for all of them."""
    return source if sequence.is_single or parse_movie_name(Path(source)) else sequence.pattern


def _name_keys(name: str) -> Iterator[str]:
    """Yield the keys of a name for the list of media, in lower case.

    They are the name itself, its pattern, and its stem or the prefix before the frame number.
    """
    last = Path(name).name.lower()
    yield last
    form, _ = parse_frame_name(last)
    yield form.text if form.padding else last
    yield form.prefix.rstrip("._-") if form.padding else Path(last).stem


def _all_media(folders: Iterable[Path]) -> Iterator[tuple[str, str]]:
    """Yield pairs of key and source for the media below the folders; later ones have priority."""
    for top_folder in folders:
        for folder, subfolders, names in os.walk(top_folder):
            depth = len(Path(folder).parts) - len(top_folder.parts)
            subfolders[:] = sorted(subfolders, reverse=True) if depth < _DEPTH_MOST else []
            numbered = [name for name in names if name.lower().endswith(suffixes_read())]
            for form in group_sequences(numbered):
                yield from _keys_of_sequence(os.path.join(folder, form.text), form)
            for name in sorted(set(names).difference(numbered)):
                yield Path(name).stem.lower(), os.path.join(folder, name)
                yield name.lower(), os.path.join(folder, name)


def _keys_of_sequence(pattern: str, form: NameForm) -> Iterator[tuple[str, str]]:
    """Yield the keys under which a sequence is listed, each with its pattern."""
    if form.padding:
        yield form.prefix.rstrip("._-").lower(), pattern
        yield f"{form.prefix}{'#' * form.padding}{form.suffix}".lower(), pattern
        yield Path(pattern).parent.name.lower(), pattern
