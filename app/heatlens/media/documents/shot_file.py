"""Read and write shot files, name.heatlens.json, which people can read and compare line by line.

The names of the entries contain their units. The path of the plate is relative to the file, so that
a shot can be moved together with its plate and its aperture image.
"""

import hashlib
import json
import os
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from pathlib import Path

from heatlens.core.base.errors import InputError
from heatlens.core.base.named_paths import path_in_folder
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
from heatlens.media.files.atomic_file import write_atomically
from heatlens.media.files.json_record import JsonEntry, read_json, record_to_json, to_json
from heatlens.media.plate.opening_picture import (
    convert_shot_images,
    read_relative_image,
    relative_path,
    with_relative_path,
)

SHOT_SUFFIX = ".heatlens.json"
SHOT_VERSION = 1
_UNSAVED_FOLDER = "unsaved"

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
_BUILT_IN_SOURCES = ("demo",)
_SPECIAL_ENTRIES = ("source", "focus_interpolation", "keys", "live_focus", "marks")


def read_shot(path: str | os.PathLike[str], moved_folders: Sequence[Sequence[str]] = ()) -> Shot:
    """Read a shot file; the source of the shot becomes an absolute path.

    `moved_folders` holds pairs of a folder, relative to the shot, and the folder that has its files
    on this machine.

    Raises InputError that names the file and the place in it if it is damaged, holds impossible
    values or has an unknown version, and if an aperture image is missing or cannot be read, because
    the discs would be wrong without it.
    """
    path = Path(path)
    document = read_json(path)
    document.check_version(_VERSION, SHOT_VERSION, "shot")
    entries = document.members([_VERSION, *_FIELDS, *_SPECIAL_ENTRIES], ["lens"])
    values = {
        field: entries[name].convert(kind)
        for name, (field, kind) in _FIELDS.items()
        if name in entries
    }
    if "source" in entries:
        values["source"] = absolute_source(entries["source"].text(), path, moved_folders)
    if "plate_options" in values:
        values["plate_options"] = values["plate_options"].with_files_beside(
            lambda text: absolute_source(text, path, moved_folders)
        )
    if "marks" in entries:
        values["marks"] = tuple(_read_mark(entry) for entry in entries["marks"].items())
    shot = document.build(Shot, values | {"curves": _read_curves(entries)})
    _check_keys(document, shot)
    try:
        return convert_shot_images(shot, lambda image: _read_image(image, path, moved_folders))
    except InputError as error:
        document.refuse(f"the aperture image that it names: {error}")


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
    _write_json(Path(path), shot)
    with suppress(OSError):  # a remaining one is offered once more
        autosave_path(path).unlink(missing_ok=True)


def autosave_path(path: str | os.PathLike[str]) -> Path:
    """Return the path of the autosave of a shot file: a hidden file beside it."""
    path = Path(path)
    return path.with_name(f".{path.name}.autosave")


def write_autosave(path: str | os.PathLike[str], shot: Shot) -> None:
    """Write the unsaved state of the shot file `path` to its autosave, for `read_shot`."""
    _write_json(autosave_path(path), shot)


def shot_to_json(shot: Shot, folder: str | os.PathLike[str]) -> dict[str, object]:
    """Return the entries of the file for `shot`, with paths relative to `folder`."""
    options = shot.plate_options.with_files_beside(lambda text: relative_source(text, folder))
    shot = replace(shot, plate_options=options)
    shot = convert_shot_images(shot, lambda image: with_relative_path(image, folder))
    fields = {
        name: to_json(value)
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
        "keys": {
            str(name): [_key_json(key) for key in curve.keys]
            for name, curve in curves.items()
            if curve.keys
        },
        **({} if shot.curves.live is None else {"live_focus": to_json(shot.curves.live)}),
        "marks": [record_to_json(mark) for mark in shot.marks],
    }


def _write_json(path: Path, shot: Shot) -> None:
    """Write the entries of a shot to `path` completely or not at all."""
    text = _format_json(shot_to_json(shot, path.parent)) + "\n"
    # File names that are not valid Unicode cannot be written as UTF-8; JSON reads their escapes.
    data = text.encode("utf-8", "backslashreplace")
    write_atomically(path, data)


def _format_json(value: object, indent: str = "") -> str:
    """Format JSON with one entry or list item on each line; list items are not broken up."""
    inner = f"{indent}  "
    if isinstance(value, dict) and value:
        rows = [
            f"{json.dumps(name)}: {_format_json(entry, inner)}" for name, entry in value.items()
        ]
    elif isinstance(value, list) and value:
        rows = [json.dumps(item, ensure_ascii=False) for item in value]
    else:
        return json.dumps(value, ensure_ascii=False)
    start, end = "{}" if isinstance(value, dict) else "[]"
    return f"{start}\n{inner}" + f",\n{inner}".join(rows) + f"\n{indent}{end}"


def _check_keys(document: JsonEntry, shot: Shot) -> None:
    """Raise InputError if a key leads to an impossible lens, or a followed mark is missing."""
    if shot.missing_marks:
        document.refuse(f"the focus follows mark {shot.missing_marks[0]}, which the shot lacks")
    keys = JsonEntry(document.path, "keys", value=None)
    for frame in shot.key_frames:
        keys.build(shot.lens_at, {"frame": frame})


def _read_curves(entries: Mapping[str, JsonEntry]) -> LensCurves:
    """Return the keys of each parameter; the file states the interpolation scale of the focus."""
    curves = LensCurves()
    if "focus_interpolation" in entries:
        scale = FOCUS_SCALES[entries["focus_interpolation"].choice(FOCUS_SCALES)]
        curves = replace(curves, focus_distance_m=Curve(scale=scale))
    if "live_focus" in entries:
        curves = replace(curves, live=entries["live_focus"].record(LiveFocus))
    if "keys" not in entries:
        return curves
    keyed_curves: Values = {
        name: entry.build(
            Curve,
            {
                "keys": tuple(item.record(Key) for item in entry.items()),
                "scale": curves.of(LensParameter(name)).scale,
            },
        )
        for name, entry in entries["keys"]
        .members([parameter.value for parameter in LensParameter])
        .items()
    }
    return replace(curves, **keyed_curves)


def _key_json(key: Key) -> dict[str, object]:
    """Return the entries of a key; handles in their default position are left out."""
    default = record_to_json(Ease())
    return {name: value for name, value in record_to_json(key).items() if value != default}


def _read_mark(entry: JsonEntry) -> Mark:
    """Return the mark of an entry; the names of its members tell its kind, else it is a point."""
    entries = entry.value if isinstance(entry.value, dict) else {}
    return entry.record(kind_of_entries(entries))


def _focus_word(scale: Scale) -> str:
    """Return the name of a scale of the focus, as it is in files and on the command line."""
    return next(word for word, known_scale in FOCUS_SCALES.items() if known_scale is scale)


def relative_source(source: str, folder: str | os.PathLike[str]) -> str:
    """Return the path relative to `folder`, or the absolute path if it is on another drive.

    The name of a built-in scene is returned unchanged.
    """
    if source in _BUILT_IN_SOURCES and not os.path.exists(source):
        return source
    return relative_path(source, folder)


def _read_image(
    image: OpeningImage, path: Path, moved_folders: Sequence[Sequence[str]]
) -> OpeningImage:
    """Return the aperture image that the shot file `path` names, with its light."""
    return read_relative_image(
        replace(image, path=absolute_source(image.path, path, moved_folders)), path.parent
    )


def _map_moved_folder(absolute: str, folder: Path, moved_folders: Sequence[Sequence[str]]) -> str:
    """Return where the file `absolute` lies on this machine.

    `moved_folders` holds pairs of an old folder and its present one. A path in no old folder is
    returned unchanged.
    """
    for old_folder, new_folder in moved_folders:
        old_path = path_in_folder(old_folder, folder)
        if Path(old_path) in Path(absolute).parents:
            return os.path.abspath(os.path.join(new_folder, os.path.relpath(absolute, old_path)))
    return absolute


def absolute_source(source: str, path: Path, moved_folders: Sequence[Sequence[str]] = ()) -> str:
    """Return the absolute path of `source`, which is relative to the folder of the file `path`."""
    if not source or "\0" in source:  # invalid: Shot refuses it with a better message
        return source
    absolute = _map_moved_folder(path_in_folder(source, path.parent), path.parent, moved_folders)
    return source if source in _BUILT_IN_SOURCES and not os.path.exists(absolute) else absolute


def unnamed_path(folder: Path, source: str) -> Path:
    """Return the autosave path of a shot without a file: named after its source, in `folder`."""
    digest = hashlib.sha256(source.encode("utf-8", "surrogateescape")).hexdigest()[:16]
    return folder / _UNSAVED_FOLDER / f"{digest}{SHOT_SUFFIX}"
