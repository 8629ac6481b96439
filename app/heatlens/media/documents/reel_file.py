"""Read and write reels, name.heatreel.json: the names of shots in order, relative to the file."""

import json
from pathlib import Path

from heatlens.core.base.errors import InputError
from heatlens.core.model.curves.frames import parse_frame_range
from heatlens.core.model.shot.grade import Grade
from heatlens.core.model.shot.reel import EDIT_SUFFIXES, EditOptions, Reel, ReelShot, Retime
from heatlens.media.documents.shot_file import absolute_source, relative_source
from heatlens.media.files.atomic_file import write_atomically
from heatlens.media.files.json_record import JsonEntry, read_json, record_to_json

REEL_SUFFIX = ".heatreel.json"
REEL_SUFFIXES = (REEL_SUFFIX, *EDIT_SUFFIXES)
REEL_VERSION = 1
_VERSION = "heatlens_reel"
_DEFAULT_OPTIONS = EditOptions()
_LISTS = ("notes", "marks")
_REEL_FIELDS = ("frames_per_second", "start_timecode", "shots", "gap_after")
_SHOT_FIELDS = ("name", "source", "frames", "notes", "marks", "grade", "retime", "gap_before")


def is_reel(text: str) -> bool:
    """Return whether a file name is that of a reel or of an edit: OpenTimelineIO, EDL, AAF, XML."""
    return text.lower().endswith(REEL_SUFFIXES)


def read_reel(path: Path, options: EditOptions = _DEFAULT_OPTIONS) -> Reel:
    """Return the reel of a file, or of an edit read with `options`.

    The sources of its shots become absolute paths. Raises InputError that names the file and the
    place in it if it is damaged.
    """
    if not path.name.lower().endswith(REEL_SUFFIX):
        from heatlens.media.documents.edit_file import read_edit

        return read_edit(path, options)
    document = read_json(path)
    document.check_version(_VERSION, REEL_VERSION, "reel")
    entries = document.members([_VERSION, *_REEL_FIELDS], ["shots"])
    values = {
        name: entries[name].convert(kind)
        for name, kind in (("frames_per_second", float), ("start_timecode", str))
        if name in entries
    }
    items = entries["shots"].items()
    gaps = [(index, _read_gap(item)) for index, item in enumerate(items)]
    gaps += [(len(items), entries["gap_after"].integer())] if "gap_after" in entries else []
    values["shots"] = tuple(_read_shot(item, path) for item in items)
    values["gaps"] = tuple(gap for gap in gaps if gap[1])
    return document.build(Reel, {"name": path.name[: -len(REEL_SUFFIX)], **values})


def write_reel(path: Path, reel: Reel) -> None:
    """Write a reel completely or not at all. Raises InputError if that fails."""
    gaps = dict(reel.gaps)
    entries = {
        _VERSION: REEL_VERSION,
        "frames_per_second": reel.frames_per_second,
        **({"start_timecode": reel.start_timecode} if reel.start_timecode else {}),
        "shots": [
            _shot_entry(shot, gaps.get(at, 0), path.parent) for at, shot in enumerate(reel.shots)
        ],
    }
    if len(reel.shots) in gaps:
        entries["gap_after"] = gaps[len(reel.shots)]
    write_atomically(path, (json.dumps(entries, indent=2, ensure_ascii=False) + "\n").encode())


def _read_gap(entry: JsonEntry) -> int:
    """Return the number of empty frames before the shot of an entry."""
    members = entry.members(_SHOT_FIELDS)
    return members["gap_before"].integer() if "gap_before" in members else 0


def _read_shot(entry: JsonEntry, path: Path) -> ReelShot:
    """Return the shot of a JSON entry of the reel at `path`; its source becomes absolute."""
    members = entry.members(_SHOT_FIELDS)
    for name in ("name", "source"):
        if name not in members:
            entry.refuse(f"the entry {name!r} is missing")
    source = members["source"].text()
    try:
        frames = parse_frame_range(members["frames"].text()) if "frames" in members else None
    except InputError as error:
        members["frames"].refuse(str(error))
    return entry.build(
        ReelShot,
        {
            "name": members["name"].text(),
            "source": absolute_source(source, path) if source else "",
            "frames": frames,
            "grade": members["grade"].record(Grade) if "grade" in members else None,
            "retime": members["retime"].record(Retime) if "retime" in members else None,
            **{name: members[name].convert(tuple[str, ...]) for name in _LISTS if name in members},
        },
    )


def _shot_entry(shot: ReelShot, gap: int, folder: Path) -> dict[str, object]:
    """Return the JSON entry of a shot with `gap` empty frames before it."""
    return {
        "name": shot.name,
        "source": relative_source(shot.source, folder) if shot.source else "",
        **({"frames": str(shot.frames)} if shot.frames is not None else {}),
        **{name: list(texts) for name in _LISTS if (texts := getattr(shot, name))},
        **({"grade": record_to_json(shot.grade)} if shot.grade is not None else {}),
        **({"retime": record_to_json(shot.retime)} if shot.retime is not None else {}),
        **({"gap_before": gap} if gap else {}),
    }
