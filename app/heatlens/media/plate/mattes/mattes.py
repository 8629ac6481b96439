"""Find the matte of an object in a plate: Cryptomatte, a channel of ids, or a plain matte.

A matte is named by its source and the object, with a colon between: `cryptomatte:hero`,
`CryptoAsset:car`, `objectId:7`, `matte:mask.R`. The distance of the object is measured by its matte
and the depth of the plate.
"""

import re
from collections.abc import Sequence
from difflib import get_close_matches
from pathlib import Path

import numpy as np

from heatlens.core.base.errors import InputError
from heatlens.core.model.boxes import Box
from heatlens.core.model.marks.marks import MattePart
from heatlens.media.files.picture_formats import is_picture
from heatlens.media.plate.coc_line import no_distances_error
from heatlens.media.plate.exr.exr_read import read_parts
from heatlens.media.plate.header.channels import (
    ChannelRef,
    Part,
    flat_channels,
    join_names,
    pixels_of,
)
from heatlens.media.plate.mattes.cryptomatte import (
    Cryptomatte,
    find_cryptomattes,
    half_cryptomattes,
    view_as_ids,
)
from heatlens.media.plate.plate import FloatImage, Plate
from heatlens.media.plate.windows import move_to_window, read_header_window

CRYPTOMATTE, MATTE = "cryptomatte", "matte"
_RANK = re.compile(r"\d\d\.[a-z]+$", re.IGNORECASE)  # CryptoObject00.R
_ID_LEAVES = ("objectid", "instanceid", "materialid", "id")


class UnknownThingError(InputError):
    """The object is not in the plate's file; it may be in other frames of the sequence."""


def read_matte(plate: Plate, text: str) -> FloatImage:
    """Return the coverage (H, W) of each pixel of the plate's data window by an object.

    The coverage is all zero if the file names the object but it is hidden. The file of the plate is
    read again. Raises UnknownThingError if the file does not name the object, and InputError if it
    has no mattes, has ids that cannot be used, or cannot be read.
    """
    source, matte = read_thing_matte(plate.path, text)
    return move_to_window(matte, source, plate.data_window, 0.0)


def read_thing_matte(path: Path, text: str) -> tuple[Box, FloatImage]:
    """Return the data window of a file, and the coverage of an object over it.

    Raises InputError as `read_matte` does.
    """
    parts = _read_exr_parts(path)
    source_name, _, thing_name = text.partition(":")
    if source_name.lower() == MATTE:
        ref = _find_channel(path, parts, thing_name)
        matte = np.nan_to_num(pixels_of(parts, ref).astype(np.float32))
        return _window_of(parts, ref), np.clip(matte, 0.0, 1.0)
    candidates = _matching_cryptomattes(path, parts, source_name)
    for crypto in candidates:
        matte = crypto.matte(parts, crypto.id_of(thing_name))
        # Some renderers list only the things in the picture, and some list none.
        if thing_name in crypto.ids or matte.any():
            return _window_of(parts, crypto.ranks[0][0]), matte
    if candidates or source_name.lower() == CRYPTOMATTE:
        raise _unknown_thing_error(path, parts, source_name, thing_name)
    return _matte_by_id(path, parts, source_name, thing_name)


def has_things(plate: Plate) -> bool:
    """Return True if the plate's file may have Cryptomatte or a channel of ids."""
    return any(_RANK.search(name) or _leaf_name(name) in _ID_LEAVES for name in plate.aovs)


def thing_at(plate: Plate, x: int, y: int) -> str | None:
    """Return the name of the matte that covers most of pixel (x, y) of the display window.

    None outside the picture, on an empty pixel, and where the file has neither Cryptomatte nor
    a channel of ids.
    """
    if is_picture(plate.path):
        return None
    parts = _read_exr_parts(plate.path)
    mattes = find_cryptomattes(plate.path, parts)
    if mattes:
        thing_id = _id_at(plate, parts, mattes[0].ranks[0][0], x, y, as_bits=True)
        return (
            f"{_last_component(mattes[0].name)}:{mattes[0].name_of(thing_id)}" if thing_id else None
        )
    for ref in flat_channels([header for header, _ in parts]):
        if _leaf_name(ref.full_name) in _ID_LEAVES:
            thing_id = _id_at(plate, parts, ref, x, y, as_bits=False)
            return None if thing_id is None else f"{ref.full_name}:{thing_id}"
    return None


def _read_exr_parts(path: Path) -> list[Part]:
    """Read the parts of an EXR file. Raises InputError for other files, which have no mattes."""
    if is_picture(path):
        raise InputError(f"{path} is not an EXR file, so it has no mattes of things.")
    return read_parts(path)


def _matching_cryptomattes(
    path: Path, parts: Sequence[Part], source_name: str
) -> list[Cryptomatte]:
    """Return the Cryptomattes that `source_name` may mean: all, or those with this name."""
    mattes = find_cryptomattes(path, parts)
    if source_name.lower() == CRYPTOMATTE:
        return list(mattes)
    return [
        matte
        for matte in mattes
        if source_name.lower() in (matte.name.lower(), _last_component(matte.name).lower())
    ]


def _last_component(name: str) -> str:
    return name.rpartition(".")[2]


def _leaf_name(name: str) -> str:
    return _last_component(name).lower()


def _matte_by_id(
    path: Path, parts: Sequence[Part], source_name: str, thing_name: str
) -> tuple[Box, FloatImage]:
    """Return the matte of a number in a channel of ids. Raises UnknownThingError without one."""
    try:
        number = int(thing_name)
    except ValueError:
        raise _unknown_thing_error(path, parts, source_name, thing_name) from None
    ref = _find_channel(path, parts, source_name)
    # Renderers store ids as floats; fractions come from filtered edges and belong to no object.
    ids = pixels_of(parts, ref)
    matte = (ids == number).astype(np.float32)
    if not matte.any():
        present_ids = join_names(
            f"{value:g}" for value in np.unique(ids[np.isfinite(ids)]) if value == round(value)
        )
        raise UnknownThingError(
            f"{path}: no pixel of {ref.full_name} is {number}. It has: {present_ids}."
        )
    return _window_of(parts, ref), matte


def _find_channel(path: Path, parts: Sequence[Part], name: str) -> ChannelRef:
    """Return the channel with this full name, or with this leaf, ignoring case."""
    refs = flat_channels([header for header, _ in parts])
    matches = [ref for ref in refs if name.lower() in (ref.full_name.lower(), ref.leaf.lower())]
    if not matches:
        channels = join_names(ref.full_name for ref in refs)
        raise InputError(f"{path} has no channel {name!r}. It has: {channels}.")
    return next((ref for ref in matches if ref.full_name.lower() == name.lower()), matches[0])


def _window_of(parts: Sequence[Part], ref: ChannelRef) -> Box:
    return read_header_window(parts[ref.part][0], "dataWindow")


def _id_at(
    plate: Plate, parts: Sequence[Part], ref: ChannelRef, x: int, y: int, as_bits: bool
) -> int | None:
    """Return the id at a pixel of the display window; None outside the channel's window."""
    box = _window_of(parts, ref)
    pixel_box = Box(x, y, x + 1, y + 1)
    column, row = pixel_box.x0 + plate.display_window.x0, pixel_box.y0 + plate.display_window.y0
    if not box.contains(column, row):
        return None
    pixel = pixels_of(parts, ref)[row - box.y0, column - box.x0 : column - box.x0 + 1]
    if as_bits:
        return int(view_as_ids(pixel)[0])
    return int(pixel[0]) if np.isfinite(pixel[0]) else None


def _unknown_thing_error(
    path: Path, parts: Sequence[Part], source_name: str, thing_name: str
) -> InputError:
    """Return the error for an object that is not in the file; it lists those that are."""
    mattes = find_cryptomattes(path, parts)
    if not mattes and (half_names := half_cryptomattes(parts)):
        return InputError(
            f"{path}: the ids of the Cryptomatte {half_names[0]} are stored as half, whose 16 bits "
            "cannot hold them. Render its channels as float (32 bit)."
        )
    if not mattes:
        return UnknownThingError(
            f"{path} has no Cryptomatte, so {source_name}:{thing_name} is not in it. Render one, "
            "or name a "
            "matte channel as matte:CHANNEL or an id as CHANNEL:NUMBER."
        )
    candidates = _matching_cryptomattes(path, parts, source_name)
    if not candidates:
        layers = join_names(_last_component(matte.name) for matte in mattes)
        return UnknownThingError(f"{path} has no Cryptomatte {source_name!r}. It has: {layers}.")
    names = [name for matte in candidates for name in matte.ids]
    if not names:
        return UnknownThingError(
            f"{path}: {thing_name!r} is nowhere in the picture, and the Cryptomatte lists no "
            "names, since its manifest is missing or damaged: give an id, # and 8 digits."
        )
    closest = get_close_matches(thing_name, names, 1)
    hint = f"Did you mean {closest[0]}?" if closest else f"It has: {join_names(names)}."
    return UnknownThingError(f"{path}: no Cryptomatte has {thing_name!r}. {hint}")


LEAST_PX = 4.0  # coverage below which an object counts as hidden
SURE_COVERAGE = 0.5  # coverage from which the depth of a pixel is the object's
_NEAREST_SHARE = 0.98  # share of the coverage behind the nearest part: ignores stray pixels


def thing_distance_m(plate: Plate, text: str, part: MattePart) -> float | None:
    """Return the distance of an object in meters; None where it is hidden or out of the frame.

    `part` chooses its middle, the median of its visible pixels in dioptres, or its nearest part,
    the depth behind which 98 % of it lies; both are weighted by coverage. Raises InputError for a
    plate without distances, and as `read_matte` does.
    """
    if not plate.has_distances:
        raise no_distances_error(plate)
    depth_m = plate.depth_m
    assert depth_m is not None
    return distance_by_matte_m(read_matte(plate, text), depth_m, part)


def distance_by_matte_m(matte: FloatImage, depth_m: FloatImage, part: MattePart) -> float | None:
    """Return what `thing_distance_m` does, from a matte and depths in meters, both (H, W)."""
    is_measured = matte > 0
    if float(matte.sum()) < LEAST_PX:
        return None
    # Pixels at an edge may have the depth of something else.
    if (matte >= SURE_COVERAGE).sum() >= LEAST_PX:
        is_measured = matte >= SURE_COVERAGE
    dioptres, weights = 1.0 / depth_m[is_measured].astype(np.float64), matte[is_measured]
    order = np.argsort(dioptres)
    coverage_sums = np.cumsum(weights[order], dtype=np.float64)
    share = _NEAREST_SHARE if part is MattePart.NEAREST else 0.5
    level = float(dioptres[order[np.searchsorted(coverage_sums, share * coverage_sums[-1])]])
    return 1.0 / level if level > 0 else float("inf")
