"""Attributes that the library refuses or has never heard of: the picture is read all the same."""

import io
import struct
from pathlib import Path

import numpy as np
import OpenEXR
import pytest

from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.media.plate.exr.exr_read import read_parts
from heatlens.media.plate.exr.exr_scan import scanned_headers
from heatlens.media.plate.inspection import inspect
from heatlens.media.plate.parts.header_read import read_headers
from heatlens.media.plate.read import read_plate
from support.deep_files import write_deep
from support.exr_files import write_file

SIZE = (3, 4)
FLAT = {name: np.full(SIZE, 0.5, np.float32) for name in "RGB"} | {
    "Z": np.arange(1, 13, dtype=np.float32).reshape(SIZE)
}
ENTRIES = {
    "deepImageState": b"deepImageState\0deepImageState\0\x01\0\0\0\x01",
    "idmanifest": b"idManifest\0idmanifest\0\x0c\0\0\0" + b"\x01" * 12,
    "of the future": b"newest\0neverHeardOf\0\x05\0\0\0hello",
}


def insert(path: Path, entry: bytes) -> None:
    """Put an attribute first in the header of a file of one part, and move its chunks on."""
    data = path.read_bytes()
    file = io.BytesIO(data)
    scanned_headers(file)
    table = file.tell()
    (first,) = struct.unpack_from("<Q", data, table)
    count = (first - table) // 8
    offsets = struct.unpack_from(f"<{count}Q", data, table)
    moved = struct.pack(f"<{count}Q", *(offset + len(entry) for offset in offsets))
    path.write_bytes(data[:8] + entry + data[8:table] + moved + data[table + 8 * count :])


@pytest.fixture(params=ENTRIES)
def entry(request) -> bytes:
    return ENTRIES[request.param]


def test_a_flat_plate_is_read_as_without_it(tmp_path, entry):
    path = write_file(tmp_path / "flat.exr", FLAT)
    plain = read_plate(path)
    insert(path, entry)
    plate = read_plate(path)
    np.testing.assert_array_equal(plate.depth_m, plain.depth_m)
    np.testing.assert_array_equal(plate.color, plain.color)
    assert read_headers(path)[0].keys() <= {*parts_header(path), "newest"}


def parts_header(path: Path) -> set[str]:
    """Return the names of a header without what nobody can write again."""
    names = set(read_parts(path)[0][0])
    assert not names & {"deepImageState", "idManifest"} and not any("~" in it for it in names)
    return names


def test_a_deep_plate_is_read_as_without_it(tmp_path, entry):
    samples = [[(0.5, 0.5, 2.0), (0.25, 1.0, 5.0)]] * 12
    path = write_deep(tmp_path / "deep.exr", samples, SIZE)
    plain = read_plate(path)
    insert(path, entry)
    plate = read_plate(path)
    np.testing.assert_array_equal(plate.color, plain.color)
    np.testing.assert_array_equal(plate.depth_m, plain.depth_m)
    assert plate.fragments is not None
    assert inspect(path, PlateOptions())["depth"]["near_m"] == pytest.approx(2.0)


def test_the_name_of_a_file_may_be_any(tmp_path):
    path = write_file(tmp_path / "flat.exr", FLAT)
    insert(path, ENTRIES["deepImageState"])
    odd = path.rename(tmp_path / "fl\udcffat.exr")
    assert read_plate(odd).depth_m is not None


def test_the_header_of_a_file_without_them_is_what_the_library_gives(tmp_path):
    path = write_file(tmp_path / "flat.exr", FLAT, owner="second unit")
    library = OpenEXR.File(str(path), header_only=True).parts[0].header
    assert read_headers(path)[0].keys() == library.keys()
