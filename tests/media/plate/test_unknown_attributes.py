"""Test EXR attributes that the library refuses or does not know: the image is still read."""

import io
import struct
from pathlib import Path

import numpy as np
import OpenEXR
import pytest

from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.media.plate.exr.exr_read import read_parts
from heatlens.media.plate.exr.exr_scan import scan_headers
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


def insert_attribute(path: Path, entry: bytes) -> None:
    """Insert an attribute first in a header of one part, and shift the chunk offsets."""
    data = path.read_bytes()
    file = io.BytesIO(data)
    scan_headers(file)
    table = file.tell()
    (first,) = struct.unpack_from("<Q", data, table)
    count = (first - table) // 8
    offsets = struct.unpack_from(f"<{count}Q", data, table)
    shifted_offsets = struct.pack(f"<{count}Q", *(offset + len(entry) for offset in offsets))
    path.write_bytes(data[:8] + entry + data[8:table] + shifted_offsets + data[table + 8 * count :])


@pytest.fixture(params=ENTRIES)
def entry(request) -> bytes:
    return ENTRIES[request.param]


def test_read_plate_ignores_unknown_attribute_of_flat_file(tmp_path, entry):
    path = write_file(tmp_path / "flat.exr", FLAT)
    plain = read_plate(path)
    insert_attribute(path, entry)
    plate = read_plate(path)
    np.testing.assert_array_equal(plate.depth_m, plain.depth_m)
    np.testing.assert_array_equal(plate.color, plain.color)
    assert read_headers(path)[0].keys() <= {*writable_header_names(path), "newest"}


def writable_header_names(path: Path) -> set[str]:
    """Return the names in a header, and check that none is an attribute that cannot be written."""
    names = set(read_parts(path)[0][0])
    assert not names & {"deepImageState", "idManifest"} and not any("~" in it for it in names)
    return names


def test_read_plate_ignores_unknown_attribute_of_deep_file(tmp_path, entry):
    samples = [[(0.5, 0.5, 2.0), (0.25, 1.0, 5.0)]] * 12
    path = write_deep(tmp_path / "deep.exr", samples, SIZE)
    plain = read_plate(path)
    insert_attribute(path, entry)
    plate = read_plate(path)
    np.testing.assert_array_equal(plate.color, plain.color)
    np.testing.assert_array_equal(plate.depth_m, plain.depth_m)
    assert plate.fragments is not None
    assert inspect(path, PlateOptions())["depth"]["near_m"] == pytest.approx(2.0)


def test_unknown_attribute_is_ignored_in_file_of_any_name(tmp_path):
    path = write_file(tmp_path / "flat.exr", FLAT)
    insert_attribute(path, ENTRIES["deepImageState"])
    odd_path = path.rename(tmp_path / "fl\udcffat.exr")
    assert read_plate(odd_path).depth_m is not None


def test_read_headers_of_plain_file_equals_library_header(tmp_path):
    path = write_file(tmp_path / "flat.exr", FLAT, owner="second unit")
    library = OpenEXR.File(str(path), header_only=True).parts[0].header
    assert read_headers(path)[0].keys() == library.keys()
