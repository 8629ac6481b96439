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
from urllib.parse import unquote, urlsplit

from heatlens.core.base.errors import InputError
from heatlens.core.model.curves.frames import FrameRange, exact_rate
from heatlens.core.model.shot.reel import Retime
from heatlens.core.model.timecode import timecode_at
from heatlens.media.documents.edit_times import Seen, seconds
from heatlens.media.files.picture_formats import movie_named, suffixes_read
from heatlens.media.plate.parts.header_read import first_timecode, is_marked_blurred
from heatlens.media.sequence.names import NameForm, form_of, sequences_among
from heatlens.media.sequence.sequence import Sequence, find_sequence

_DEPTH_MOST = 6  # folders below one of --media; deeper ones are not searched
_DIGITS = re.compile(r"%0?([0-9]{1,2})d|\[([0-9]+)-[0-9]+\]")  # %04d, and [1001-1100] of an EDL


@dataclass(frozen=True)
class Media:
    """What a clip shows.

    source    a source as shots name it; "" if it is missing
    sequence  its frames; None for a scene, a shot, and if it is missing
    start_s   the time of `first` in the clock of the edit; None if the edit does not say
    first     the number of the frame at `start_s`
    told      the name in the edit
    rate      frames per second of the numbers of frames; None for those of the clip
    step      frames from one that exists to the next
    note      what else the folders hold by this name; "" if nothing does
    """

    source: str
    sequence: Sequence | None
    first: int
    start_s: Fraction | None
    told: str
    rate: float | None = None
    step: int = 1
    note: str = ""

    def frame_at(self, time: float, rate: float) -> tuple[int, str]:
        """Return the number of the frame at a time of the clip in its frames, and a note or "".

        This is for media without a start. The time is a frame number if there is such a frame,
        else a timecode of the headers, else counted from the first frame.
        """
        if self.sequence is None or round(time) in self.sequence.frames:
            return round(time), ""
        began = first_timecode(self.sequence)
        if began is not None and began[1].fits(rate):
            return began[0] + round(time) - began[1].count(rate), ""
        return self.sequence.first, (
            f"the edit begins at {timecode_at(time, rate)}, but no header of the media tells a "
            "timecode: their first frame is taken"
        )


def played(
    part: Seen, frames: range, media: Media, rate: float
) -> tuple[FrameRange, Retime | None, str]:
    """Return which frames of its media a cut shows, how it plays them, and a note or "".

    `frames` are those of the cut, at `rate` a second, that show the part.
    """
    assert part.clip is not None  # a gap plays nothing
    time = part.clip.trimmed_range().start_time
    begin_s, first, doubt = media.start_s, media.first, ""
    if begin_s is None:
        begin_s = seconds(time)
        first, doubt = media.frame_at(float(time.value), float(time.rate))
    own, cut = exact_rate(media.rate or float(time.rate)), exact_rate(rate)
    start = first + (part.clock.at(frames.start / cut) - begin_s) * own
    speed = part.clock.speed * own / cut
    retime = Retime(float(start), float(speed), len(frames), media.step)
    shown = retime.shown(first)
    made = FrameRange(min(shown), max(shown))
    if shown == tuple(made):
        return made, None, doubt
    return FrameRange(made.first, _last_made(retime, made, media)), retime, doubt


def _last_made(retime: Retime, made: FrameRange, media: Media) -> int:
    """Return the last frame within the time of the last one shown, if the media have it."""
    latest = retime.start + max(0.0, retime.speed * (retime.count - 1))
    within = math.ceil(round(latest + abs(retime.speed), 6)) - 1
    if media.sequence is not None:
        within = min(within, media.sequence.last)
    return max(made.last, made.first + (within - made.first) // retime.step * retime.step)


class MediaFinder:
    """Finds media by what an edit calls them: where it says, else in the given folders.

    Where several fit, pinhole pictures come before those that heatlens has blurred: a former export
    of the same edit may lie in these folders too.
    """

    def __init__(self, edit: Path, folders: Items[Path]) -> None:
        """Take the file of the edit and the folders to search; they are listed when needed."""
        self._folder = edit.absolute().parent
        self._folders = folders
        self._known: dict[str, dict[str, str]] | None = None

    def of(self, clip: Any) -> Media:
        """Return the media of a clip of OpenTimelineIO."""
        reference = _reference_of(clip)
        if reference is None:
            return self._found("", clip.name, None, None)
        available = reference.available_range
        start_s = None if available is None else seconds(available.start_time)
        if hasattr(reference, "frame_zero_padding"):
            target = _pattern_of(reference)
            first = int(reference.start_frame)
            images, step = float(reference.rate), int(reference.frame_step)
            media = self._found(target, clip.name, first, start_s)
            begin_s = first / exact_rate(images) if start_s is None else start_s
            return replace(media, start_s=begin_s, rate=images, step=max(1, step))
        rate = None if available is None else float(available.start_time.rate)
        target = getattr(reference, "target_url", None) or ""
        return replace(self._found(target, clip.name or reference.name, None, start_s), rate=rate)

    def _found(self, target: str, name: str, first: int | None, start_s: Fraction | None) -> Media:
        """Return the media of a URL or path, or else of a name."""
        path = _path_of(target, self._folder) if target else ""
        for fitting in ([path] if path else [], self._by_name(path), self._by_name(name)):
            there = [source for source in fitting if _is_there(source)]
            if there:
                source = next((it for it in there if not is_blurred_source(it)), there[0])
                others = [other for other in there if other != source]
                return self._media(source, others, target or name, first, start_s)
        return Media("", None, first or 0, start_s, target or name)

    def _media(
        self,
        source: str,
        others: Items[str],
        target: str,
        first: int | None,
        start_s: Fraction | None,
    ) -> Media:
        note, sequence = _also_fit(source, others), _sequence_at(source)
        if sequence is None:
            return Media(source, None, first or 0, start_s, target, note=note)
        at = sequence.first if first is None else first
        plates = sequence if _is_numbered(sequence) else None
        return Media(_source_of(source, sequence), plates, at, start_s, target, note=note)

    def _by_name(self, name: str | None) -> Items[str]:
        """Return the media in the folders that are called `name`, by any of its usual forms."""
        if not name or not self._folders:
            return []
        if self._known is None:
            self._known = {}
            for key, source in _all_media(self._folders):
                self._known.setdefault(key, {})[os.path.abspath(source)] = source
        fitting = next((self._known[key] for key in _keys(name) if key in self._known), {})
        return list(reversed(fitting.values()))


def _is_there(source: str) -> bool:
    return _sequence_at(source) is not None or os.path.isfile(source)


def is_blurred_source(source: str) -> bool:
    """Return whether the first picture of a source is one that heatlens has blurred."""
    sequence = _sequence_at(source) if source else None
    return sequence is not None and is_marked_blurred(sequence.path_at(sequence.present[0]))


def _also_fit(source: str, others: Items[str]) -> str:
    """Return a note that names the media that are not taken; "" if there are none."""
    if not others:
        return ""
    names = (f"{other} (already blurred)" * is_blurred_source(other) or other for other in others)
    return f"{len(others) + 1} media fit: {source} is taken, and not {', '.join(names)}"


def _reference_of(clip: Any) -> Any:
    """Return the media of a clip: the active ones, else others that it tells; None if none."""
    others = clip.media_references()
    active = others.pop(clip.active_media_reference_key, None)
    named = (it for it in (active, *others.values()) if it is not None)
    return next((it for it in named if not it.is_missing_reference), None)


def _pattern_of(reference: Any) -> str:
    base = reference.target_url_base or ""
    digits = "#" * max(1, int(reference.frame_zero_padding))
    lead = base if not base or base.endswith("/") else f"{base}/"
    return f"{lead}{reference.name_prefix}{digits}{reference.name_suffix}"


def _path_of(url: str, folder: Path) -> str:
    """Return the absolute path of a URL or path; relative ones begin at the folder of the edit."""
    hashed = _DIGITS.sub(lambda match: "#" * int(match[1] or len(match[2])), url)
    is_url = url.lower().startswith("file:")
    path = unquote(urlsplit(hashed.replace("#", "%23")).path) if is_url else hashed
    return os.path.abspath(folder / path)


def _sequence_at(source: str) -> Sequence | None:
    try:
        return find_sequence(source)
    except InputError:
        return None


def _is_numbered(sequence: Sequence) -> bool:
    """Return whether these are frames, and not a scene, a shot or a still picture."""
    return not sequence.is_single


def _source_of(source: str, sequence: Sequence) -> str:
    """Return how a shot names the files: a frame of a sequence stands for all of them."""
    return source if sequence.is_single or movie_named(Path(source)) else sequence.pattern


def _keys(name: str) -> Iterator[str]:
    """Yield the forms under which media are listed: the name, its stem, and that without frames."""
    last = Path(name).name.lower()
    yield last
    form, _ = form_of(last)
    yield form.text if form.padding else last
    yield form.prefix.rstrip("._-") if form.padding else Path(last).stem


def _all_media(folders: Iterable[Path]) -> Iterator[tuple[str, str]]:
    """Yield the media below the folders with the forms of their names; later ones win."""
    for top in folders:
        for folder, below, names in os.walk(top):
            depth = len(Path(folder).parts) - len(top.parts)
            below[:] = sorted(below, reverse=True) if depth < _DEPTH_MOST else []
            numbered = [name for name in names if name.lower().endswith(suffixes_read())]
            for form in sequences_among(numbered):
                yield from _named(os.path.join(folder, form.text), form)
            for name in sorted(set(names).difference(numbered)):
                yield Path(name).stem.lower(), os.path.join(folder, name)
                yield name.lower(), os.path.join(folder, name)


def _named(pattern: str, form: NameForm) -> Iterator[tuple[str, str]]:
    if form.padding:
        yield form.prefix.rstrip("._-").lower(), pattern
        yield f"{form.prefix}{'#' * form.padding}{form.suffix}".lower(), pattern
        yield Path(pattern).parent.name.lower(), pattern
