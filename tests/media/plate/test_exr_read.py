"""Test reading of plates: layouts, windows, parts, repairs and damage."""

import random
import struct
import sys

import numpy as np
import OpenEXR
import pytest

from heatlens.core.base.errors import InputError
from heatlens.core.model.boxes import Box
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.media.plate.exr.exr_read import read_parts
from heatlens.media.plate.read import read_plate
from support.exr_files import (
    distances,
    part_header,
    rgb,
    tiled_header,
    window,
    write_file,
    write_parts,
)

LOSSLESS = ("NO", "RLE", "ZIPS", "ZIP", "PIZ")


def assert_is_ramp(plate):
    expected = np.stack([rgb()[name] for name in "RGB"], axis=-1)
    np.testing.assert_array_equal(plate.color[:, :, :3], expected)
    np.testing.assert_array_equal(plate.depth_m, distances())


@pytest.mark.parametrize("compression", LOSSLESS)
@pytest.mark.parametrize("dtype", [np.float16, np.float32])
def test_read_plate_in_every_lossless_compression_and_type(tmp_path, compression, dtype):
    kind = getattr(OpenEXR, f"{compression}_COMPRESSION")
    path = write_file(tmp_path / "a.exr", rgb(dtype=dtype) | {"Z": distances()}, compression=kind)
    plate = read_plate(path)
    assert_is_ramp(plate)
    assert plate.color.dtype == plate.depth_m.dtype == np.float32
    assert plate.color.flags.c_contiguous
    assert (plate.color[:, :, 3] == 1).all() and not plate.has_alpha


def test_read_plate_of_tiled_file(tmp_path):
    path = write_file(tmp_path / "a.exr", rgb() | {"Z": distances()}, **tiled_header())
    assert_is_ramp(read_plate(path))


def test_read_plate_keeps_alpha_and_negative_light(tmp_path):
    channels = rgb(dtype=np.float32) | {"Z": distances()}
    channels["A"] = np.full((6, 8), 0.25, np.float32)
    channels["R"] = -channels["R"]
    plate = read_plate(write_file(tmp_path / "a.exr", channels))
    assert plate.has_alpha and (plate.color[:, :, 3] == 0.25).all()
    np.testing.assert_array_equal(plate.color[:, :, 0], channels["R"])


def test_read_plate_keeps_windows_and_metadata(tmp_path):
    path = write_file(
        tmp_path / "a.exr",
        rgb() | {"Z": distances()},
        dataWindow=window(-3, 5, 5, 11),
        displayWindow=window(0, 0, 20, 10),
        pixelAspectRatio=2.0,
        owner="the lab",
        focus=4.5,
        aperture=2.8,
        tStop=3.1,
        nominalFocalLength=35.0,
        pinholeFocalLength=50.0,
        sensorOverallDimensions=np.array([36, 24], np.float32),
    )
    plate = read_plate(path)
    assert plate.data_window == Box(-3, 5, 5, 11)
    assert plate.display_window == Box(0, 0, 20, 10)
    assert plate.pixel_aspect_ratio == 2.0
    assert plate.attributes["owner"] == "the lab" and "dataWindow" not in plate.attributes
    camera = plate.camera
    assert (camera.focus_distance_m, camera.focal_length_mm) == (4.5, 50.0)
    assert (camera.f_stop, camera.t_stop) == pytest.approx((2.8, 3.1))
    assert (camera.sensor_width_mm, camera.sensor_height_mm) == (36.0, 24.0)
    assert camera.sources["focal_length_mm"] == "pinholeFocalLength"


def test_camera_header_ignores_impossible_values(tmp_path):
    path = write_file(
        tmp_path / "a.exr",
        rgb() | {"Z": distances()},
        focus=float("inf"),
        aperture=0.0,
        pinholeFocalLength=-1.0,
        nominalFocalLength=float("inf"),
        effectiveFocalLength=40.0,
    )
    camera = read_plate(path).camera
    assert camera.focus_distance_m == float("inf")
    assert camera.f_stop is None and camera.sensor_width_mm is None
    assert camera.focal_length_mm == 40.0
    assert camera.sources["focal_length_mm"] == "effectiveFocalLength"


def test_read_plate_takes_depth_from_own_part_with_own_window(tmp_path):
    display = window(0, 0, 8, 6)
    depth = np.full((4, 4), 3.0, np.float32)
    path = write_parts(
        tmp_path / "a.exr",
        ({"name": "rgba", "displayWindow": display}, rgb()),
        (
            {"name": "depth", "displayWindow": display, "dataWindow": window(2, 1, 6, 5)},
            {"Z": depth},
        ),
    )
    plate = read_plate(path)
    expected = np.full((6, 8), np.inf, np.float32)
    expected[1:5, 2:6] = 3.0
    np.testing.assert_array_equal(plate.depth_m, expected)
    assert plate.depth.channel == "depth.Z" and plate.depth.infinite_count == 48 - 16
    assert any("32 pixels" in note for note in plate.notes)
    assert plate.aovs == ("rgba.B", "rgba.G", "rgba.R", "depth.Z")


def test_read_plate_rejects_parts_with_different_display_windows(tmp_path):
    path = tmp_path / "a.exr"
    display = window(0, 0, 78, 76)
    headers = ({"name": name, "displayWindow": display} for name in ("rgba", "depth"))
    write_parts(path, *zip(headers, (rgb(), {"Z": distances()}), strict=True))
    before, _, after = path.read_bytes().rpartition(struct.pack("<2i", 77, 75))
    path.write_bytes(before + struct.pack("<2i", 88, 86) + after)
    with pytest.raises(InputError, match=r"different display windows|cannot be read"):
        read_plate(path)


def test_read_plate_repairs_invalid_color_and_notes_count(tmp_path):
    channels = rgb(dtype=np.float32) | {"Z": distances()}
    channels["G"][2, 3] = np.nan
    channels["B"][4, 4] = np.inf
    plate = read_plate(write_file(tmp_path / "a.exr", channels))
    good = np.ones((6, 8), bool)
    good[2, 3] = good[4, 4] = False
    assert np.isfinite(plate.color).all()
    for index, name in enumerate("RGB"):
        np.testing.assert_array_equal(plate.color[good, index], channels[name][good])
    assert any("2 of 48 pixels" in note for note in plate.notes)


def test_read_plate_radial_depth_needs_lens_from_header_or_options(tmp_path):
    bare = write_file(tmp_path / "bare.exr", rgb() | {"Z": distances()})
    with pytest.raises(InputError, match="--focal-length"):
        read_plate(bare, PlateOptions(depth_kind="radial"))
    with pytest.raises(InputError, match="--sensor-width"):
        read_plate(bare, PlateOptions(depth_kind="radial", focal_length_mm=50))
    # f = sensor width: the centre of pixel (0, 0) is 3.5/8 and 2.5/8 of it off the axis.
    plate = read_plate(
        bare, PlateOptions(depth_kind="radial", focal_length_mm=36, sensor_width_mm=36)
    )
    expected = 2 / np.sqrt(1 + (3.5 / 8) ** 2 + (2.5 / 8) ** 2)
    assert plate.depth_m[0, 0] == pytest.approx(expected, rel=1e-6)
    assert plate.depth.near_m == pytest.approx(float(plate.depth_m.min()))
    assert plate.depth.kind == "radial"


def test_read_plate_reads_circle_of_confusion_instead_of_depth(tmp_path):
    coc = np.linspace(-9, 9, 48, dtype=np.float32).reshape(6, 8)
    path = write_file(tmp_path / "a.exr", rgb() | {"coc": coc, "Z": distances()})
    plate = read_plate(path, PlateOptions(depth_convention="coc"))
    assert plate.depth_m is None
    np.testing.assert_array_equal(plate.coc_px, coc)
    assert read_plate(path).coc_px is None


@pytest.mark.parametrize(
    ("content", "words"),
    [(b"", "is empty"), (b"\x89PNG\r\n", "not an OpenEXR"), (b"\x76\x2f\x31\x01\x02", "damaged")],
)
def test_read_parts_reports_file_that_is_no_exr(tmp_path, content, words):
    path = tmp_path / "shot.exr"
    path.write_bytes(content)
    with pytest.raises(InputError, match=words) as error:
        read_parts(path)
    assert "shot.exr" in str(error.value)


def test_read_parts_reports_missing_file_and_folder(tmp_path):
    with pytest.raises(InputError, match=r"none\.exr is not there"):
        read_parts(tmp_path / "none.exr")
    with pytest.raises(InputError, match="is a folder"):
        read_parts(tmp_path)


def test_read_plate_rejects_deep_file_without_coverage(tmp_path):
    deep = np.empty((2, 2), dtype=object)
    for index in np.ndindex(2, 2):
        deep[index] = np.array([1.0, 2.0], np.float32)
    channels = {name: deep.copy() for name in ("R", "G", "B", "Z")}
    deep_header = {"type": OpenEXR.deepscanline, "compression": OpenEXR.ZIPS_COMPRESSION}
    path = write_file(tmp_path / "a.exr", channels, **deep_header)
    with pytest.raises(InputError, match=r"lacks some of R, G, B, A and Z.*It has B, G, R, Z"):
        read_plate(path)


def test_read_parts_of_damaged_file_prints_nothing(tmp_path, capfd):
    data = bytearray(write_file(tmp_path / "a.exr", rgb() | {"Z": distances()}).read_bytes())
    data[-20] ^= 0xFF
    (tmp_path / "a.exr").write_bytes(data)
    with pytest.raises(InputError, match="damaged or cut short"):
        read_parts(tmp_path / "a.exr")
    (tmp_path / "a.exr").write_bytes(data[:-60])
    with pytest.raises(InputError, match="damaged or cut short"):
        read_parts(tmp_path / "a.exr")
    print("after", file=sys.stderr)
    assert capfd.readouterr() == ("", "after\n")


def write_seed_file(path, kind):
    """Write an 8x6 file of one layout, ZIP compressed, whose checksum detects changes."""
    if kind == "parts":
        return write_parts(path, ({"name": "rgba"}, rgb()), ({"name": "d"}, {"Z": distances()}))
    layout = tiled_header() if kind == "tiled" else {}
    return write_file(path, rgb() | {"Z": distances()}, **layout)


def assert_refused_or_right(path):
    """Check that reading raises InputError or returns the written pixels. A changed bit in the
    header may rename a channel, move a window or alter an attribute, which gives another valid
    file; wrong pixel values must never be returned.
    """
    try:
        parts = read_parts(path)
    except InputError:
        return "refused"
    known = {**rgb(), "Z": distances()}
    stored = [array.tobytes() for array in known.values()]
    for _, channels in parts:
        for array in channels.values():
            assert array.shape == (6, 8) and array.tobytes() in stored
    return "right"


@pytest.mark.parametrize("kind", ["scanline", "tiled", "parts"])
def test_read_parts_rejects_every_truncation(tmp_path, kind):
    data = write_seed_file(tmp_path / "seed.exr", kind).read_bytes()
    path = tmp_path / "cut.exr"
    for length in range(0, len(data), 3):
        path.write_bytes(data[:length])
        assert assert_refused_or_right(path) == "refused", length


@pytest.mark.parametrize("kind", ["scanline", "tiled", "parts"])
def test_read_parts_rejects_flipped_bits_in_pixels_or_returns_them_right(tmp_path, kind):
    data = write_seed_file(tmp_path / "seed.exr", kind).read_bytes()
    first_chunk = len(data) - 150
    rng = random.Random(1)
    path = tmp_path / "flip.exr"
    outcomes = []
    for _ in range(200):
        damaged = bytearray(data)
        damaged[rng.randrange(first_chunk, len(data))] ^= 1 << rng.randrange(8)
        path.write_bytes(damaged)
        outcomes.append(assert_refused_or_right(path))
    assert outcomes.count("refused") > 150


@pytest.mark.parametrize("kind", ["scanline", "tiled", "parts"])
def test_read_plate_of_any_flipped_bit_raises_only_input_error(tmp_path, kind):
    data = write_seed_file(tmp_path / "seed.exr", kind).read_bytes()
    rng = random.Random(2)
    path = tmp_path / "flip.exr"
    for _ in range(400):
        damaged = bytearray(data)
        damaged[rng.randrange(len(data))] ^= 1 << rng.randrange(8)
        path.write_bytes(damaged)
        try:
            plate = read_plate(path)
        except InputError as error:
            assert "flip.exr" in str(error)
        else:
            assert np.isfinite(plate.color).all() and not np.isnan(plate.depth_m).any()


def test_read_parts_rejects_width_beyond_16384(tmp_path):
    path = tmp_path / "a.exr"
    row = {name: np.zeros((1, 16385), np.float16) for name in "RGB"}
    OpenEXR.File(part_header(), row).write(str(path))
    with pytest.raises(InputError, match="16385 x 1"):
        read_parts(path)
