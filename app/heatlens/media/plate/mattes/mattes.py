"""Find the matte of an object in a plate: Cryptomatte, a channel of ids, or a plain matte.

A matte is named by where it is found and what it shows, with a colon between:
`cryptomatte:hero`, `CryptoAsset:car`, `objectId:7`, `matte:mask.R`. The distance of the object is
measured by its matte and the depth of the plate.
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
from heatlens.media.plate.coc_line import no_distances
from heatlens.media.plate.exr.exr_read import read_parts
from heatlens.media.plate.header.channels import ChannelRef, Part, flat_channels, listed, pixels_of
from heatlens.media.plate.mattes.cryptomatte import (
    Cryptomatte,
    bits_of,
    cryptomattes,
    half_cryptomattes,
)
from heatlens.media.plate.plate import FloatImage, Plate
from heatlens.media.plate.windows import box_at_header, moved_to_window

CRYPTOMATTE, MATTE = "cryptomatte", "matte"
_RANK = re.compile(r"\d\d\.[a-z]+$", re.IGNORECASE)  # CryptoObject00.R
_ID_LEAVES = ("objectid", "instanceid", "materialid", "id")


class UnknownThingError(InputError):
    """The object is not in the plate's file; it may be in other frames of the sequence."""


def matte_of(plate: Plate, text: str) -> FloatImage:
    """Return the coverage (H, W) of each pixel of the plate's data window by an object.

    All zero where the file names the thing and it is hidden. Reads the file of the plate again.
    Raises UnknownThingError where the file does not know such a thing, InputError where it has no
    mattes at all, or ids that are no use, or cannot be read.
    """
    source, matte = thing_in(plate.path, text)
    return moved_to_window(matte, source, plate.data_window, 0.0)


def thing_in(path: Path, text: str) -> tuple[Box, FloatImage]:
    """Return the coverage of a thing in a file, and the window of that. Raises as `matte_of`."""
    parts = _parts_of(path)
    where, _, what = text.partition(":")
    if where.lower() == MATTE:
        ref = _channel(path, parts, what)
        matte = np.nan_to_num(pixels_of(parts, ref).astype(np.float32))
        return _window_of(parts, ref), np.clip(matte, 0.0, 1.0)
    asked = _asked(path, parts, where)
    for crypto in asked:
        matte = crypto.matte(parts, crypto.id_of(what))
        # Some renderers list only the things in the picture, and some list none.
        if what in crypto.ids or matte.any():
            return _window_of(parts, crypto.ranks[0][0]), matte
    if asked or where.lower() == CRYPTOMATTE:
        raise _unknown(path, parts, where, what)
    return _by_id(path, parts, where, what)


def has_things(plate: Plate) -> bool:
    """Return True if the plate's file may have Cryptomatte or a channel of ids."""
    return any(_RANK.search(name) or _leaf(name) in _ID_LEAVES for name in plate.aovs)


def thing_at(plate: Plate, x: int, y: int) -> str | None:
    """Return the name of the matte that covers most of pixel (x, y) of the display window.

    None outside the picture, on an empty pixel, and where the file has neither Cryptomatte nor
    a channel of ids.
    """
    if is_picture(plate.path):
        return None
    parts = _parts_of(plate.path)
    mattes = cryptomattes(plate.path, parts)
    if mattes:
        thing = _value_at(plate, parts, mattes[0].ranks[0][0], x, y, as_bits=True)
        return f"{_last(mattes[0].name)}:{mattes[0].name_of(thing)}" if thing else None
    for ref in flat_channels([header for header, _ in parts]):
        if _leaf(ref.full_name) in _ID_LEAVES:
            thing = _value_at(plate, parts, ref, x, y, as_bits=False)
            return None if thing is None else f"{ref.full_name}:{thing}"
    return None


def _parts_of(path: Path) -> list[Part]:
    if is_picture(path):
        raise InputError(f"{path} is not an EXR file, so it has no mattes of things.")
    return read_parts(path)


def _asked(path: Path, parts: Sequence[Part], where: str) -> list[Cryptomatte]:
    """Return the Cryptomattes that `where` may mean: all, or the one with this name."""
    mattes = cryptomattes(path, parts)
    if where.lower() == CRYPTOMATTE:
        return list(mattes)
    return [it for it in mattes if where.lower() in (it.name.lower(), _last(it.name).lower())]


def _last(name: str) -> str:
    return name.rpartition(".")[2]


def _leaf(name: str) -> str:
    return _last(name).lower()


def _by_id(path: Path, parts: Sequence[Part], where: str, what: str) -> tuple[Box, FloatImage]:
    """Return the matte of a number in a channel of ids. Raises UnknownThingError without one."""
    try:
        number = int(what)
    except ValueError:
        raise _unknown(path, parts, where, what) from None
    ref = _channel(path, parts, where)
    # Renderers store ids as floats; fractions come from filtered edges and belong to no object.
    ids = pixels_of(parts, ref)
    matte = (ids == number).astype(np.float32)
    if not matte.any():
        held = listed(f"{it:g}" for it in np.unique(ids[np.isfinite(ids)]) if it == round(it))
        raise UnknownThingError(f"{path}: no pixel of {ref.full_name} is {number}. It has: {held}.")
    return _window_of(parts, ref), matte


def _channel(path: Path, parts: Sequence[Part], name: str) -> ChannelRef:
    refs = flat_channels([header for header, _ in parts])
    named = [ref for ref in refs if name.lower() in (ref.full_name.lower(), ref.leaf.lower())]
    if not named:
        channels = listed(ref.full_name for ref in refs)
        raise InputError(f"{path} has no channel {name!r}. It has: {channels}.")
    return next((ref for ref in named if ref.full_name.lower() == name.lower()), named[0])


def _window_of(parts: Sequence[Part], ref: ChannelRef) -> Box:
    return box_at_header(parts[ref.part][0], "dataWindow")


def _value_at(
    plate: Plate, parts: Sequence[Part], ref: ChannelRef, x: int, y: int, as_bits: bool
) -> int | None:
    """Return the id at a pixel of the display window; None outside the channel's window."""
    box = _window_of(parts, ref)
    at = Box(x, y, x + 1, y + 1)
    column, row = at.x0 + plate.display_window.x0, at.y0 + plate.display_window.y0
    if not box.contains(column, row):
        return None
    pixel = pixels_of(parts, ref)[row - box.y0, column - box.x0 : column - box.x0 + 1]
    if as_bits:
        return int(bits_of(pixel)[0])
    return int(pixel[0]) if np.isfinite(pixel[0]) else None


def _unknown(path: Path, parts: Sequence[Part], where: str, what: str) -> InputError:
    """Return the error for an object that is not in the file; it lists those that are."""
    mattes = cryptomattes(path, parts)
    if not mattes and (half := half_cryptomattes(parts)):
        return InputError(
            f"{path}: the ids of the Cryptomatte {half[0]} are stored as half, whose 16 bits "
            "cannot hold them. Render its channels as float (32 bit)."
        )
    if not mattes:
        return UnknownThingError(
            f"{path} has no Cryptomatte, so {where}:{what} is not in it. Render one, or name a "
            "matte channel as matte:CHANNEL or an id as CHANNEL:NUMBER."
        )
    asked = _asked(path, parts, where)
    if not asked:
        layers = listed(_last(it.name) for it in mattes)
        return UnknownThingError(f"{path} has no Cryptomatte {where!r}. It has: {layers}.")
    names = [name for it in asked for name in it.ids]
    if not names:
        return UnknownThingError(
            f"{path}: {what!r} is nowhere in the picture, and the Cryptomatte lists no names: its "
            "manifest is missing or damaged."
        )
    near = get_close_matches(what, names, 1)
    hint = f"Did you mean {near[0]}?" if near else f"It has: {listed(names)}."
    return UnknownThingError(f"{path}: no Cryptomatte has {what!r}. {hint}")


LEAST_PX = 4.0  # coverage below which an object counts as hidden
SURE = 0.5  # coverage from which the depth of a pixel is the object's
_NEAREST = 0.98  # share of the coverage behind the nearest part: ignores stray pixels


def thing_m(plate: Plate, text: str, part: MattePart) -> float | None:
    """Return the distance of an object in metres; None where it is hidden or out of the frame.

    Its middle is the median of what is seen of it, in dioptres, and its nearest part is that
    behind which 98 % of it lies; both are weighted by coverage. Raises InputError for a plate
    without distances, and as `matte_of` does.
    """
    if not plate.has_distances:
        raise no_distances(plate)
    depth_m = plate.depth_m
    assert depth_m is not None
    return distance_m(matte_of(plate, text), depth_m, part)


def distance_m(matte: FloatImage, depth_m: FloatImage, part: MattePart) -> float | None:
    """Return what `thing_m` does, from a matte and depths in metres, both (H, W)."""
    is_there = matte > 0
    if float(matte.sum()) < LEAST_PX:
        return None
    # Pixels at an edge may have the depth of something else.
    if (matte >= SURE).sum() >= LEAST_PX:
        is_there = matte >= SURE
    dioptres, weights = 1.0 / depth_m[is_there].astype(np.float64), matte[is_there]
    order = np.argsort(dioptres)
    passed = np.cumsum(weights[order], dtype=np.float64)
    share = _NEAREST if part is MattePart.NEAREST else 0.5
    level = float(dioptres[order[np.searchsorted(passed, share * passed[-1])]])
    return 1.0 / level if level > 0 else float("inf")
