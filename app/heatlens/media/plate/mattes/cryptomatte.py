"""Read Cryptomatte: how much of each pixel an object, material or asset covers.

A Cryptomatte of a file is a list of ranks, each a pair of channels: the id of a thing, and the
share of the pixel that it covers. The header lists the names of the things (Friedman and Jones,
"Cryptomatte Specification", version 1.2.0, Psyop 2018).
"""

import json
import re
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import mmh3
import numpy as np
from numpy.typing import NDArray

from heatlens.core.base.errors import InputError
from heatlens.core.base.paths import read_file_bytes
from heatlens.media.plate.header.channels import ChannelRef, Header, Part, flat_channels, pixels_of
from heatlens.media.plate.plate import FloatImage

METADATA = "cryptomatte/"  # prefix of the attributes
# Bits of the exponent of a float32: if all are 0 or all are 1, the float is not a normal number.
_EXPONENT, _EXPONENT_LOWEST_BIT = 0x7F800000, 1 << 23
_LEAVES = {"r": 0, "red": 0, "g": 1, "green": 1, "b": 2, "blue": 2, "a": 3, "alpha": 3}
_HEX = 16  # base of the ids in a manifest
_ID_MOST = 0xFFFFFFFF
_MANIFEST_MOST_BYTES = 64_000_000
_ID_PATTERN = re.compile(r"(?:#|0x)?[0-9a-f]{8}", re.IGNORECASE)


@dataclass(frozen=True)
class Cryptomatte:
    """One Cryptomatte of a file.

    name    such as CryptoObject or ViewLayer.CryptoAsset
    ranks   channels of ids and of coverage, the largest coverage first
    header  the attributes that belong to it, without their prefix
    folder  the folder of the file, in which a manifest of its own may lie
    """

    name: str
    ranks: tuple[tuple[ChannelRef, ChannelRef], ...]
    header: dict[str, str]
    folder: Path

    @cached_property
    def ids(self) -> dict[str, int]:
        """The id of each name in the manifest; none if there is no manifest or it is damaged.

        An id that does not fit in 32 bits is left out, because no pixel can hold it.
        """
        try:
            text = self.header.get("manifest") or self._read_sidecar()
            by_name = {str(name): int(str(bits), _HEX) for name, bits in json.loads(text).items()}
            return {name: bits for name, bits in by_name.items() if 0 <= bits <= _ID_MOST}
        except (OSError, ValueError, AttributeError, RecursionError):
            return {}

    def _read_sidecar(self) -> str:
        """Return the text of the manifest file; "{}" if the header names none."""
        # Only a file in the folder of the plate is read, whatever path the header names.
        name = Path(self.header.get("manif_file", "").replace("\\", "/")).name
        if not name:
            return "{}"
        return read_file_bytes(self.folder / name, _MANIFEST_MOST_BYTES).decode("utf-8")

    def id_of(self, name: str) -> int:
        """Return the id of a name, or of `#1f2e3d4c`, which stands for a thing without a name.

        Other programs write such an id as `0x1f2e3d4c` or `1f2e3d4c`. The id of a name that the
        manifest does not have is its hash, as in every renderer. Raises InputError.
        """
        if name in self.ids:
            return self.ids[name]
        if _ID_PATTERN.fullmatch(name):
            return int(name.removeprefix("#"), _HEX)
        if name.startswith("#"):
            raise InputError(f"{name} is not an id: write it as # and 8 hexadecimal digits.")
        return hash_name(name)

    def name_of(self, thing_id: int) -> str:
        """Return the name of an id, or `#1f2e3d4c` if the manifest does not have it."""
        names = (name for name, bits in self.ids.items() if bits == thing_id)
        return next(names, f"#{thing_id:08x}")

    def matte(self, parts: Sequence[Part], thing_id: int) -> FloatImage:
        """Return the coverage (H, W) of each pixel by the object with this id."""
        shape = pixels_of(parts, self.ranks[0][0]).shape
        matte: FloatImage = np.zeros(shape, np.float32)
        for ids, coverage in self.ranks:
            is_thing = view_as_ids(pixels_of(parts, ids)) == np.uint32(thing_id)
            matte[is_thing] += pixels_of(parts, coverage)[is_thing].astype(np.float32)
        return np.clip(np.nan_to_num(matte), 0.0, 1.0, out=matte)


def hash_name(name: str) -> int:
    """Return the id of a name: its MurmurHash3, adjusted so that the float is a normal number.

    Raises InputError for a name that cannot be encoded as UTF-8, which no thing can have.
    """
    try:
        encoded = name.encode()
    except UnicodeEncodeError as error:
        raise InputError(
            f"{name!r} cannot be the name of a thing, because it is not UTF-8: give its id, # and "
            "8 hexadecimal digits."
        ) from error
    bits = mmh3.hash(encoded, signed=False)
    if bits & _EXPONENT in (0, _EXPONENT):
        bits ^= _EXPONENT_LOWEST_BIT
    return bits


def view_as_ids(ids: NDArray[np.generic]) -> NDArray[np.uint32]:
    """Return ids as integers; a file stores their bits as float32."""
    return np.ascontiguousarray(ids).view(np.uint32)


def find_cryptomattes(path: Path, parts: Sequence[Part]) -> tuple[Cryptomatte, ...]:
    """Return the Cryptomattes of a file, in the order of their attributes."""
    headers = [header for header, _ in parts]
    # Half floats cannot hold the 32 bits of an id.
    refs = [ref for ref in flat_channels(headers) if pixels_of(parts, ref).dtype == np.float32]
    mattes = []
    for name, attributes in _attributes_by_name(headers).items():
        ranks = _find_ranks(refs, name)
        if ranks:
            mattes.append(Cryptomatte(name, ranks, header=attributes, folder=path.parent))
    return tuple(mattes)


def thing_names(folder: Path, headers: Sequence[Header]) -> dict[str, list[str]]:
    """Return the names of the things that each Cryptomatte of a file in `folder` lists."""
    entries = _attributes_by_name(headers).items()
    return {
        name: sorted(Cryptomatte(name, (), attributes, folder).ids) for name, attributes in entries
    }


def half_cryptomattes(parts: Sequence[Part]) -> tuple[str, ...]:
    """Return the names of the Cryptomattes with ids in half floats, which cannot hold 32 bits."""
    headers = [header for header, _ in parts]
    refs = [ref for ref in flat_channels(headers) if pixels_of(parts, ref).dtype == np.float16]
    return tuple(name for name in _attributes_by_name(headers) if _find_ranks(refs, name))


def _attributes_by_name(headers: Sequence[Header]) -> dict[str, dict[str, str]]:
    """Return the attributes of each Cryptomatte by its name; parts may repeat them."""
    by_key: dict[str, dict[str, str]] = {}
    for header in headers:
        for attribute, value in header.items():
            key, slash, field = attribute.removeprefix(METADATA).partition("/")
            if attribute.startswith(METADATA) and slash and isinstance(value, str):
                by_key.setdefault(key, {})[field] = value
    return {matte["name"]: matte for matte in by_key.values() if matte.get("name")}


def _find_ranks(refs: Sequence[ChannelRef], name: str) -> tuple[tuple[ChannelRef, ChannelRef], ...]:
    """Return the pairs of id and coverage channels of NAME00, NAME01, ...; others are left out."""
    by_rank: dict[int, ChannelRef] = {}
    for ref in refs:
        number = ref.layer[-2:]
        if ref.layer[:-2] == name and number.isdecimal() and ref.leaf.lower() in _LEAVES:
            by_rank[4 * int(number) + _LEAVES[ref.leaf.lower()]] = ref
    pairs = [(rank, rank + 1) for rank in sorted(by_rank) if rank % 2 == 0 and rank + 1 in by_rank]
    return tuple((by_rank[ids], by_rank[coverage]) for ids, coverage in pairs)
