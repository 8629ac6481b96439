"""Read and write shot files, name.heatlens.json, which people can read and compare line by line.

The names of the entries contain their units. The path of the plate is relative to the file, so that
a shot can be moved together with its plate and its aperture image.
"""

import json
import os
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from pathlib import Path

from heatlens.core.base.errors import InputError
from heatlens.core.model.curves.curve import Curve, Key
from heatlens.core.model.curves.frames import FrameRange
from heatlens.core.model.curves.interpolation import Ease, Scale
from heatlens.core.model.focus.live_focus import LiveFocus
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.lens.lens_kit import LensKit
from heatlens.core.model.lens.opening_image import OpeningImage
from heatlens.core.model.marks.mark import Mark
from heatlens.core.model.marks.marks import kind_of_entries
from heatlens.core.model.option import Values
from heatlens.core.model.shot.framing import Framing
from heatlens.core.model.shot.grade import Grade
from heatlens.core.model.shot.lens_parameter import FOCUS_SCALES, LensParameter
from heatlens.core.model.shot.look import Look
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.core.model.shot.settings import DefocusSettings
from heatlens.core.model.shot.shot import LensCurves, Shot
from heatlens.media.files.atomic_file import write_whole
from heatlens.media.files.json_record import JsonEntry, plain, read_json, record_to_json
from heatlens.media.plate.opening_picture import (
    image_beside,
    named_beside,
    path_beside,
    path_from,
    shot_with_images,
)

SHOT_SUFFIX = ".heatlens.json"
SHOT_VERSION = 1

_VERSION = "heatlens_shot"
# Entries that hold an unchanged field of Shot -> the name of the field, and its type.
_FIELDS: dict[str, tuple[str, object]] = {
    "plate": ("plate_options", PlateOptions),
    "frames": ("frames", FrameRange),
    "in_out": ("in_out", FrameRange),
    "frames_per_second": ("frames_per_second", float),
    "lens": ("lens", Lens),
    "defocus": ("defocus", DefocusSettings),
    "framing": ("framing", Framing),
    "looks": ("looks", tuple[Look, ...]),
    "lens_kit": ("kit", LensKit),
    "start_timecode": ("start_timecode", str),
    "grade": ("grade", Grade),
}
# Sources that are names and not paths, unless a file has that name: the built-in scene.
_NAMES = ("demo",)
_OTHERS = ("source", "focus_interpolation", "keys", "live_focus", "marks")


def read_shot(path: str | os.PathLike[str], moved: Sequence[Sequence[str]] = ()) -> Shot:
    """Read a shot file; the source of the shot becomes an absolute path.

    `moved` holds folders, relative to the shot, and where their files are on this machine.

    Raises InputError that names the file and the place in it if it is damaged, holds impossible
    values or has an unknown version, and if an aperture image is missing or cannot be read, because
    the discs would be wrong without it.
    """
    path = Path(path)
    top = read_json(path)
    top.check_version(_VERSION, SHOT_VERSION, "shot")
    entries = top.members([_VERSION, *_FIELDS, *_OTHERS], ["lens"])
    values = {
        field: entries[name].of_type(kind)
        for name, (field, kind) in _FIELDS.items()
        if name in entries
    }
    if "source" in entries:
        values["source"] = absolute_source(entries["source"].text(), path, moved)
    if "plate_options" in values:
        values["plate_options"] = values["plate_options"].with_files_beside(
            lambda text: absolute_source(text, path, moved)
        )
    if "marks" in entries:
        values["marks"] = tuple(_mark(entry) for entry in entries["marks"].items())
    shot = top.built(Shot, values | {"curves": _curves(entries)})
    _check_keys(top, shot)
    try:
        return shot_with_images(shot, lambda image: _image_at(image, path, moved))
    except InputError as error:
        top.refuse(f"the aperture image that it names: {error}")


def is_shot_file(text: str) -> bool:
    """Return whether a name is that of a shot file or its autosave.

    Plates, scenes and cameras never have such a name.
    """
    name = Path(text).name.lower()
    return name.endswith((SHOT_SUFFIX, f"{SHOT_SUFFIX}.autosave"))


def write_shot(path: str | os.PathLike[str], shot: Shot) -> None:
    """Write a shot completely or not at all, then delete the autosave beside it.

    Raises InputError if the file cannot be written.
    """
    _write(Path(path), shot)
    with suppress(OSError):  # a remaining one is offered once more
        autosave_path(path).unlink(missing_ok=True)


def autosave_path(path: str | os.PathLike[str]) -> Path:
    """Return the path of the autosave of a shot file: a hidden file beside it."""
    path = Path(path)
    return path.with_name(f".{path.name}.autosave")


def write_autosave(path: str | os.PathLike[str], shot: Shot) -> None:
    """Write the unsaved state of the shot file `path` to its autosave, for `read_shot`."""
    _write(autosave_path(path), shot)


def shot_to_json(shot: Shot, folder: str | os.PathLike[str]) -> dict[str, object]:
    """Return the entries of the file for `shot`, with paths relative to `folder`."""
    options = shot.plate_options.with_files_beside(lambda text: relative_source(text, folder))
    shot = replace(shot, plate_options=options)
    shot = shot_with_images(shot, lambda image: named_beside(image, folder))
    fields = {
        name: plain(value)
        for name, (field, _) in _FIELDS.items()
        if (value := getattr(shot, field)) is not None and value != ()
    }
    curves = {parameter: shot.curves.of(parameter) for parameter in LensParameter}
    source = {} if shot.source is None else {"source": relative_source(shot.source, folder)}
    return {
        _VERSION: SHOT_VERSION,
        **source,
        **fields,
        "focus_interpolation": _focus_word(shot.curves.focus_distance_m.scale),
        "keys": {str(p): [_key_json(key) for key in c.keys] for p, c in curves.items() if c.keys},
        **({} if shot.curves.live is None else {"live_focus": plain(shot.curves.live)}),
        "marks": [record_to_json(mark) for mark in shot.marks],
    }


def _write(path: Path, shot: Shot) -> None:
    text = _lines(shot_to_json(shot, path.parent)) + "\n"
    # File names that are not valid Unicode cannot be written as UTF-8; JSON reads their escapes.
    data = text.encode("utf-8", "backslashreplace")
    write_whole(path, data)


def _lines(value: object, indent: str = "") -> str:
    """Format JSON with one entry or list item on each line; list items are not broken up."""
    inner = f"{indent}  "
    if isinstance(value, dict) and value:
        rows = [f"{json.dumps(name)}: {_lines(entry, inner)}" for name, entry in value.items()]
    elif isinstance(value, list) and value:
        rows = [json.dumps(item, ensure_ascii=False) for item in value]
    else:
        return json.dumps(value, ensure_ascii=False)
    start, end = "{}" if isinstance(value, dict) else "[]"
    return f"{start}\n{inner}" + f",\n{inner}".join(rows) + f"\n{indent}{end}"


def _check_keys(top: JsonEntry, shot: Shot) -> None:
    """Raise InputError if a key leads to an impossible lens, or a followed mark is missing."""
    if shot.lost_marks:
        top.refuse(f"the focus follows mark {shot.lost_marks[0]}, which the shot lacks")
    keys = JsonEntry(top.path, "keys", None)
    for frame in shot.key_frames:
        keys.built(shot.lens_at, {"frame": frame})


def _curves(entries: Mapping[str, JsonEntry]) -> LensCurves:
    """Return the keys of each parameter; the file states the interpolation scale of the focus."""
    curves = LensCurves()
    if "focus_interpolation" in entries:
        scale = FOCUS_SCALES[entries["focus_interpolation"].choice(FOCUS_SCALES)]
        curves = replace(curves, focus_distance_m=Curve(scale=scale))
    if "live_focus" in entries:
        curves = replace(curves, live=entries["live_focus"].record(LiveFocus))
    if "keys" not in entries:
        return curves
    keyed: Values = {
        name: entry.built(
            Curve,
            {
                "keys": tuple(item.record(Key) for item in entry.items()),
                "scale": curves.of(LensParameter(name)).scale,
            },
        )
        for name, entry in entries["keys"].members([p.value for p in LensParameter]).items()
    }
    return replace(curves, **keyed)


def _key_json(key: Key) -> dict[str, object]:
    """Return the entries of a key; handles in their default position are left out."""
    default = record_to_json(Ease())
    return {name: value for name, value in record_to_json(key).items() if value != default}


def _mark(entry: JsonEntry) -> Mark:
    """Return the mark of an entry, of the kind that its entries tell; else a point."""
    entries = entry.value if isinstance(entry.value, dict) else {}
    return entry.record(kind_of_entries(entries))


def _focus_word(scale: Scale) -> str:
    return next(word for word, known in FOCUS_SCALES.items() if known is scale)


def relative_source(source: str, folder: str | os.PathLike[str]) -> str:
    """Return the path relative to the folder of the file, or absolute on another drive."""
    if source in _NAMES and not os.path.exists(source):
        return source
    return path_beside(source, folder)


def _image_at(image: OpeningImage, path: Path, moved: Sequence[Sequence[str]]) -> OpeningImage:
    return image_beside(replace(image, path=absolute_source(image.path, path, moved)), path.parent)


def _moved(absolute: str, folder: Path, moved: Sequence[Sequence[str]]) -> str:
    for old, new in moved:
        before = path_from(old, folder)
        if Path(before) in Path(absolute).parents:
            return os.path.abspath(os.path.join(new, os.path.relpath(absolute, before)))
    return absolute


def absolute_source(source: str, path: Path, moved: Sequence[Sequence[str]] = ()) -> str:
    """Return the absolute path of `source`, which is relative to the folder of the file `path`."""
    if not source or "\0" in source:  # invalid: Shot refuses it with a better message
        return source
    absolute = _moved(path_from(source, path.parent), path.parent, moved)
    return source if source in _NAMES and not os.path.exists(absolute) else absolute
