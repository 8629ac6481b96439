"""The output of `heatlens info` for several frames: a sequence, a folder, or a list of files."""

import os
from collections.abc import Sequence as Items
from itertools import count
from pathlib import Path

from heatlens.commands.output.progress_line import progress_line
from heatlens.commands.sources.source_commands import Facts, Line
from heatlens.frame_cache.sequence_facts import sequence_facts
from heatlens.model.plate_options import PlateOptions
from heatlens.model.units import format_distance
from heatlens.sequence.names import NameForm, form_of, parse_pattern
from heatlens.sequence.sequence import Sequence, find_sequence


def found_among(texts: Items[str]) -> list[str | Sequence]:
    """Return a file or a sequence for the names; listed frames of one shot become one sequence.

    Patterns and folders are sequences. Listed files belong together if their names have the same
    form. Raises InputError for a pattern without files.
    """
    groups: dict[tuple[Path, NameForm], list[int]] = {}
    found: list[str | Sequence | tuple[Path, NameForm]] = []
    for text in texts:
        path = Path(os.path.expanduser(text))
        is_pattern = not path.exists() and parse_pattern(path.name) is not None
        form, frame = form_of(path.name)
        if path.is_dir() or is_pattern:
            found.append(find_sequence(text))
        elif frame is None or len(texts) == 1 or not path.exists():
            found.append(text)
        else:
            key = (path.parent, form)
            if key not in groups:
                found.append(key)
            groups.setdefault(key, []).append(frame)
    return [_settled(item, groups) if isinstance(item, tuple) else item for item in found]


def _settled(
    key: tuple[Path, NameForm], groups: dict[tuple[Path, NameForm], list[int]]
) -> str | Sequence:
    """Return the name of a single file, or the sequence of the listed frames."""
    folder, form = key
    frames = tuple(sorted(groups[key]))
    if len(frames) == 1:
        return str(folder / form.name_at(frames[0]))
    every = tuple(range(frames[0], frames[-1] + 1))
    return Sequence(folder, form, every, frames)


def sequence_info(sequence: Sequence, options: PlateOptions) -> tuple[Facts, list[Line]]:
    """Return the facts of a sequence, and lines of text; show the progress on a terminal."""
    number = count(1)
    with progress_line() as show:
        facts = sequence_facts(
            sequence,
            options,
            lambda frame: show(f"frame {frame}, {next(number)} of {len(sequence.present)}"),
        )
    return facts, _lines(facts)


def lacks_frames(facts: Facts) -> bool:
    """Return True for a sequence of which frames are missing or damaged."""
    return bool(facts.get("missing") or facts.get("damaged"))


def _lines(facts: Facts) -> list[Line]:
    lines = [
        ("sequence", facts["path"]),
        ("frames", f"{facts['frames']} ({facts['frame_count']})"),
        ("missing", facts["missing"] or "none"),
        *_with_frames("size", facts["sizes"]),
        *_with_frames("depth", facts["depth"]),
    ]
    if facts["near_m"] is not None:
        near, far = format_distance(facts["near_m"]), format_distance(facts["far_m"])
        span = f"{near} (frame {facts['near_frame']}) to {far} (frame {facts['far_frame']})"
        lines.append(("  range", span))
    lines += [("behind", f"{name} {words}") for name, words in facts["behind"].items()]
    lines += _with_frames("note", facts["notes"])
    lines += [(f"frame {frame}", sentence) for frame, sentence in facts["damaged"].items()]
    return lines


def _with_frames(label: str, found: dict[str, str]) -> list[Line]:
    """Return one line if all frames agree, else a line for each value with its frames."""
    if len(found) == 1 and label != "note":
        return [(label, name) for name in found]
    return [(label, f"{name} ({_frames_words(frames)})") for name, frames in found.items()]


def _frames_words(frames: str) -> str:
    """Return "frame 2" or "frames 1-2,5"."""
    return f"frame {frames}" if frames.isdecimal() else f"frames {frames}"
