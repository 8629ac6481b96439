"""Test that sizes claimed by an EXR file are checked before memory is allocated."""

import os
import struct

import numpy as np
import OpenEXR
import pytest

from heatlens.core.base.errors import InputError
from heatlens.media.plate.exr import exr_scan
from heatlens.media.plate.exr.exr_read import read_parts
from heatlens.media.plate.exr.exr_scan import check_exr, parse_channels, scan_headers
from heatlens.media.plate.header.camera_header import camera_at_header
from heatlens.media.plate.parts.header_read import read_headers
from heatlens.media.plate.read import read_plate
from support.exr_files import distances, rgb, tiled_header, window, write_file, write_parts

COMPRESSIONS = [name for name in dir(OpenEXR) if name.endswith("_COMPRESSION")]


def patch_attribute(path, name: str, value: bytes, at: int = 0):
    """Overwrite bytes of an attribute's value in the only header. Return the path."""
    data = bytearray(path.read_bytes())
    place = data.index(name.encode() + b"\0")
    start = data.index(b"\0", data.index(b"\0", place) + 1) + 5
    data[start + at : start + at + len(value)] = value
    path.write_bytes(data)
    return path


@pytest.mark.parametrize("compression", COMPRESSIONS)
@pytest.mark.parametrize("value", [0.0, 1.5])
def test_check_exr_accepts_constant_picture_in_any_compression(tmp_path, compression, value):
    """These are the smallest files: 1,024 pixels a side, in half, float and uint."""
    plane = np.full((1024, 1024), value, np.float32)
    channels = {"R": plane.astype(np.float16), "G": plane, "I": plane.astype(np.uint32)}
    path = tmp_path / "a.exr"
    write_file(path, channels, compression=getattr(OpenEXR, compression))
    check_exr(path)


def test_scan_headers_agrees_with_library(tmp_path):
    path = write_parts(
        tmp_path / "a.exr",
        ({"name": "rgb", "dataWindow": window(-3, 4, 5, 10)}, rgb()),
        ({"name": "depth", "dataWindow": window(-3, 4, 5, 10)}, {"Z": distances()}),
    )
    with path.open("rb") as file:
        scanned = scan_headers(file)
    library_headers = read_headers(path)
    for raw, header in zip(scanned, library_headers, strict=True):
        names = [channel.name.decode() for channel in parse_channels(raw)]
        assert names == [channel.name for channel in header["channels"]]
        (x0, y0), (x1, y1) = header["dataWindow"]
        assert struct.unpack("<4i", raw["dataWindow"]) == (x0, y0, x1, y1)


@pytest.mark.parametrize("sides", [(32, 16_777_216), (8_388_640, 16), (0, 16), (2**32 - 1, 1)])
def test_read_parts_rejects_tiles_far_larger_than_picture(tmp_path, sides):
    path = write_file(tmp_path / "a.exr", rgb() | {"Z": distances()}, **tiled_header())
    assert read_plate(path).color.shape == (6, 8, 4)
    patch_attribute(path, "tiles", struct.pack("<II", *sides))
    with pytest.raises(InputError, match=rf"tiles of {sides[0]} x {sides[1]}.*up to 4096 x 4096"):
        read_parts(path)


@pytest.mark.parametrize("compression", ["NO", "RLE", "ZIPS", "ZIP", "PIZ", "PXR24", "B44"])
def test_read_parts_rejects_window_that_its_bytes_cannot_fill(tmp_path, compression):
    path = tmp_path / "a.exr"
    write_file(path, rgb(), compression=getattr(OpenEXR, f"{compression}_COMPRESSION"))
    patch_attribute(path, "dataWindow", struct.pack("<2i", 16383, 16383), at=8)
    with pytest.raises(InputError, match=r"hold the 1,610,612,736"):
        read_parts(path)


@pytest.mark.parametrize("compression", ["HTJ2K32", "HTJ2K256"])
@pytest.mark.parametrize("size", [(24, 10), (10, 24), (16, 1)])
def test_read_parts_rejects_jpeg_2000_of_other_size(tmp_path, compression, size):
    """JPEG 2000 stores its size; otherwise images of one color would fit."""
    flat = np.full((10, 16), 0.5, np.float32)
    channels = {name: flat for name in "RGBZ"}
    kind = getattr(OpenEXR, f"{compression}_COMPRESSION")
    path = write_file(tmp_path / "a.exr", channels, compression=kind)
    before, after = (struct.pack("<4i", 0, 0, w - 1, h - 1) for w, h in ((16, 10), size))
    path.write_bytes(path.read_bytes().replace(before, after))
    with pytest.raises(InputError, match="damaged or cut short"):
        read_parts(path)


def test_read_exr_rejects_window_larger_than_a_gpu_allows(tmp_path):
    path = patch_attribute(
        write_file(tmp_path / "a.exr", rgb()), "dataWindow", struct.pack("<i", -16384)
    )
    for read in (read_parts, read_headers):
        with pytest.raises(InputError, match="16392 x 6 pixels; heatlens takes 1 to 16384 a side"):
            read(path)


def test_read_exr_rejects_a_hundred_thousand_channels(tmp_path):
    """The file is written by hand, because the library takes minutes for so many channels."""
    names = (f"c{i:06}".encode() for i in range(100_000))
    listed = b"".join(name + b"\0" + struct.pack("<i4sii", 1, b"", 1, 1) for name in names) + b"\0"
    box = struct.pack("<4i", 0, 0, 0, 0)
    attributes = (("channels", "chlist", listed), ("compression", "compression", b"\3"))
    attributes += (("dataWindow", "box2i", box), ("displayWindow", "box2i", box))
    data = b"\x76\x2f\x31\x01" + struct.pack("<I", 2)
    for name, kind, value in attributes:
        data += (
            name.encode() + b"\0" + kind.encode() + b"\0" + struct.pack("<I", len(value)) + value
        )
    (tmp_path / "a.exr").write_bytes(data + b"\0")
    for read in (read_parts, read_headers):
        with pytest.raises(InputError, match="has 100,000 channels; heatlens takes 4,096"):
            read(tmp_path / "a.exr")


def test_read_parts_rejects_more_pixels_than_memory_limit(tmp_path, monkeypatch):
    path = write_file(tmp_path / "a.exr", rgb(), compression=OpenEXR.ZSTD_COMPRESSION)
    monkeypatch.setattr(exr_scan, "MAX_BYTES", 287)
    with pytest.raises(InputError, match=r"claims 0\.0 GB of pixels; heatlens takes 0\.0"):
        read_parts(path)
    monkeypatch.setattr(exr_scan, "MAX_BYTES", 288)
    assert read_parts(path)


@pytest.mark.parametrize("letter", [b"\xff", b"\x80", b"\xc3"])
def test_read_exr_reports_channel_name_that_is_no_utf_8(tmp_path, letter):
    path = patch_attribute(
        write_file(tmp_path / "a.exr", rgb() | {"Z": distances()}), "channels", letter
    )
    for read in (read_plate, read_headers):
        with pytest.raises(InputError, match="is not UTF-8"):
            read(path)


def test_camera_at_header_refuses_attribute_of_unknown_type(tmp_path):
    path = write_file(tmp_path / "a.exr", rgb(), pinholeFocalLength=50.0)
    name = b"pinholeFocalLength\0"
    good, bad = name + b"float\0", name + b"fl\xde\xc2\xe8\0"
    path.write_bytes(path.read_bytes().replace(good, bad))
    header = OpenEXR.File(str(path), header_only=True).parts[0].header
    refusals = camera_at_header([header]).refused
    assert list(refusals.values()) == ["pinholeFocalLength is of an unknown type"]


def test_read_exr_reports_attribute_type_that_is_no_utf_8(tmp_path):
    path = write_file(tmp_path / "a.exr", rgb() | {"Z": distances()}, pinholeFocalLength=50.0)
    name = b"pinholeFocalLength\0"
    good, bad = name + b"float\0", name + b"fl\xde\xc2\xe8\0"
    path.write_bytes(path.read_bytes().replace(good, bad))
    for read in (read_plate, read_headers):
        with pytest.raises(InputError, match="the attribute 'pinholeFocalLength'"):
            read(path)


def test_read_exr_does_not_wait_for_a_pipe(tmp_path):
    os.mkfifo(tmp_path / "a.exr")
    for read in (read_plate, read_headers):
        with pytest.raises(InputError, match=r"a\.exr cannot be read: it is not a file"):
            read(tmp_path / "a.exr")


def test_read_parts_rejects_header_cut_anywhere(tmp_path):
    path = write_file(tmp_path / "a.exr", rgb(), **tiled_header())
    data = path.read_bytes()
    with path.open("rb") as file:
        scan_headers(file)
        end = file.tell()
    for length in range(4, end):
        path.write_bytes(data[:length])
        with pytest.raises(InputError, match="its header is not whole"):
            read_parts(path)
