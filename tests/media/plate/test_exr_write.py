"""Test writing of EXR: the file reads back as written, and no partial file is ever left."""

import sys
from fractions import Fraction

import numpy as np
import OpenEXR
import pytest

from heatlens.core.base.errors import InputError
from heatlens.core.model.boxes import Box
from heatlens.media.plate.exr.exr_read import read_parts
from heatlens.media.plate.exr.exr_write import COMPRESSIONS, write_exr
from heatlens.media.plate.header.camera_header import camera_at_header, lens_attributes
from heatlens.media.plate.read import read_plate

WINDOW = Box(0, 0, 5, 3)


def ramp(dtype=np.float32):
    return np.arange(15, dtype=dtype).reshape(3, 5) - 4


def write_and_read(tmp_path, channels, **options):
    """Write channels to a file. Return its header and channels as read back."""
    path = tmp_path / "out.exr"
    windows = {"data_window": WINDOW, "display_window": WINDOW} | options
    write_exr(path, channels, **windows)
    (part,) = read_parts(path)
    return part


@pytest.mark.parametrize("compression", COMPRESSIONS[:5])
@pytest.mark.parametrize("half", [True, False])
def test_write_exr_reads_back_in_every_compression(tmp_path, compression, half):
    written_channels = {"R": ramp(), "Z": ramp() / 3, "depth.Z": ramp() / 7}
    _, channels = write_and_read(tmp_path, written_channels, compression=compression, half=half)
    assert channels["R"].dtype == (np.float16 if half else np.float32)
    for name, values in written_channels.items():
        np.testing.assert_array_equal(channels[name], values)
        assert name == "R" or channels[name].dtype == np.float32


VIEWS = {
    "channel of RGBA": lambda: np.repeat(ramp()[:, :, None], 4, axis=2)[:, :, 1],
    "mirrored": lambda: ramp()[:, ::-1],
    "upside down": lambda: ramp()[::-1],
    "transposed": lambda: np.ascontiguousarray(ramp().T).T,
    "every other": lambda: np.repeat(ramp(), 2, axis=0)[::2],
    "Fortran order": lambda: np.asfortranarray(ramp()),
    "float64": lambda: ramp(np.float64),
}


@pytest.mark.parametrize("view", VIEWS)
@pytest.mark.parametrize("half", [True, False])
def test_write_exr_accepts_any_memory_order(tmp_path, view, half):
    values = VIEWS[view]()
    _, channels = write_and_read(tmp_path, {"R": values}, half=half)
    np.testing.assert_array_equal(channels["R"], values)


def test_write_exr_clamps_half_floats_but_not_depth(tmp_path):
    values = ramp()
    values[0, :4] = 1e9, -1e9, np.inf, 65504
    _, channels = write_and_read(tmp_path, {"R": values})
    assert channels["R"][0, :4].tolist() == [65504, -65504, 65504, 65504]
    _, channels = write_and_read(tmp_path, {"Z": np.full((3, 5), np.inf, np.float32)})
    assert np.isinf(channels["Z"]).all()


@pytest.mark.parametrize("data", [Box(-3, 7, 2, 10), Box(1, 1, 6, 4), Box(-9, -9, -4, -6)])
def test_write_exr_keeps_windows_and_pixel_aspect(tmp_path, data):
    path = tmp_path / "out.exr"
    channels = dict.fromkeys("RGBZ", ramp() + 6)
    write_exr(path, channels, data, Box(0, 0, 40, 20), pixel_aspect_ratio=2.0)
    plate = read_plate(path)
    assert plate.data_window == data and plate.display_window == Box(0, 0, 40, 20)
    assert plate.pixel_aspect_ratio == 2.0 and not plate.has_alpha
    np.testing.assert_array_equal(plate.color[:, :, 2], ramp() + 6)


def test_write_exr_keeps_attributes_of_a_plate(tmp_path):
    matrix = np.arange(16, dtype=np.float32).reshape(4, 4)
    attributes = {"owner": "me", "shot": 7, "gain": 0.5, "worldToCamera": matrix}
    channels = dict.fromkeys("RGBZ", ramp() + 6)
    first, second = tmp_path / "1.exr", tmp_path / "2.exr"
    write_exr(first, channels, WINDOW, WINDOW, attributes=attributes)
    write_exr(second, channels, WINDOW, WINDOW, attributes=read_plate(first).attributes)
    attributes_read = read_plate(second).attributes
    assert (attributes_read["owner"], attributes_read["shot"], attributes_read["gain"]) == (
        "me",
        7,
        0.5,
    )
    np.testing.assert_array_equal(attributes_read["worldToCamera"], matrix)


def test_write_exr_omits_unsupported_attributes_and_mutates_nothing(tmp_path):
    attributes = {"odd": b"bytes", "none": None, "empty": [], "np": np.float32(2), "owner": "me"}
    channels = {"R": ramp()}
    before = (dict(attributes), dict(channels))
    header, _ = write_and_read(tmp_path, channels, attributes=attributes)
    assert header["owner"] == "me" and not {"odd", "none", "empty"} & header.keys()
    assert (attributes, channels) == before and channels["R"] is before[1]["R"]


def test_write_exr_keeps_or_omits_rational_frame_rate(tmp_path):
    rate = Fraction(24000, 1001)
    header, _ = write_and_read(tmp_path, {"R": ramp()}, attributes={"framesPerSecond": rate})
    assert header.get("framesPerSecond", rate) == rate  # OpenEXR before 3.5 cannot write it


def test_lens_attributes_read_back_in_standard_units(tmp_path):
    lens = lens_attributes(50.0, 2.0, 2.25, 36.0, 24.0, t_stop=2.5)
    header, _ = write_and_read(tmp_path, {"R": ramp()}, attributes=lens)
    assert header["focus"] == 2.25 and header["pinholeFocalLength"] == 50.0
    camera = camera_at_header([header])
    assert (camera.focus_distance_m, camera.focal_length_mm, camera.f_stop) == (2.25, 50.0, 2.0)
    assert (camera.sensor_width_mm, camera.sensor_height_mm) == (36.0, 24.0)
    assert camera.t_stop == 2.5
    camera_without_height = camera_at_header([lens_attributes(50.0, 2.0, float("inf"), 36.0)])
    assert (
        camera_without_height.sensor_height_mm is None
        and camera_without_height.focus_distance_m == float("inf")
    )


def test_write_exr_keeps_old_file_if_writing_fails(tmp_path):
    path = tmp_path / "out.exr"
    path.write_bytes(b"precious")
    with pytest.raises(InputError, match="'R' has"):
        write_exr(path, {"R": np.zeros((2, 2))}, WINDOW, WINDOW)
    with pytest.raises(InputError, match="could not be written"):
        write_exr(path, {"R\x00": ramp(), "": ramp()}, WINDOW, WINDOW)
    assert path.read_bytes() == b"precious"
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.skipif(sys.platform == "win32", reason="no limit on the size of files")
@pytest.mark.parametrize("share", [0.02, 0.5, 0.8, 0.99])
def test_write_exr_detects_full_disk_at_any_position(tmp_path, share):
    """A limit on file size stands in for a full disk; the library alone misses late failures."""
    import resource

    path = tmp_path / "out.exr"
    write_exr(path, {"R": ramp()}, WINDOW, WINDOW)
    limit = int(path.stat().st_size * share)
    path.write_bytes(b"precious")
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (limit, before[1]))
    try:
        with pytest.raises(InputError, match="could not be written"):
            write_exr(path, {"R": ramp()}, WINDOW, WINDOW)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
    assert path.read_bytes() == b"precious" and list(tmp_path.iterdir()) == [path]


def test_write_exr_rejects_bad_folder_target_and_compression(tmp_path):
    with pytest.raises(InputError, match="does not exist"):
        write_exr(tmp_path / "no" / "out.exr", {"R": ramp()}, WINDOW, WINDOW)
    with pytest.raises(InputError, match="not a file"):
        write_exr(tmp_path, {"R": ramp()}, WINDOW, WINDOW)
    with pytest.raises(InputError, match="choose one of none, rle"):
        write_exr(tmp_path / "a.exr", {"R": ramp()}, WINDOW, WINDOW, compression="lzw")
    assert not list(tmp_path.iterdir())


def test_write_exr_follows_symbolic_link(tmp_path):
    real, link = tmp_path / "real.exr", tmp_path / "link.exr"
    real.write_bytes(b"old")
    link.symlink_to(real)
    write_exr(link, {"R": ramp()}, WINDOW, WINDOW)
    assert link.is_symlink() and OpenEXR.isOpenExrFile(str(real))
