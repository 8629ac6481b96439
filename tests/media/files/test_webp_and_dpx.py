"""Test that WebP and DPX files hold the values and marks written, and are told apart."""

import sys

import numpy as np
import OpenImageIO
import pytest

from heatlens.core.base.errors import InputError
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.deliver.export.finished import fingerprint_in
from heatlens.media.files.marks import JOB_ATTRIBUTE
from heatlens.media.plate.picture.picture_open import open_picture, picture_info
from heatlens.media.plate.picture.picture_write import write_display_values, write_png
from heatlens.media.plate.read import read_plate
from support.command_line import refused_render_message, render
from support.exports import write_plate
from support.picture_files import save_dpx

MARKS = {JOB_ATTRIBUTE: "f" * 64, "heatlens:blurred": "yes"}


def smooth(channels: int) -> np.ndarray:
    """Return (H, W, C) of 0 to 1, with every tenth of a percent in red."""
    values = np.linspace(0, 1, 24 * 48, dtype=np.float32).reshape(24, 48)
    return np.stack([values, values[::-1], values[:, ::-1], np.sqrt(values)][:channels], axis=-1)


def test_dpx_holds_ten_bits_of_written_values(tmp_path):
    path = tmp_path / "a.dpx"
    codes = np.arange(1024, dtype=np.float32).reshape(32, 32)
    shown = np.stack([codes, codes.T, codes[::-1]], axis=-1) / 1023
    write_display_values(path, shown, MARKS)
    read = open_picture(path)
    assert read.values.dtype == np.uint16 and read.full_scale == 65535
    np.testing.assert_array_equal(np.round(read.values / 65535 * 1023), shown * 1023)
    assert path.stat().st_size == 8192 + 4 * 32 * 32  # three times ten bits are a word
    assert fingerprint_in(path) == "f" * 64 and picture_info(path)[1]["bits"] == 10


def test_dpx_clips_and_rounds_values(tmp_path):
    shown = np.float32([[[-1, 0.5, 2.0], [0.25 / 1023, 0.75 / 1023, np.nan]]])
    write_display_values(tmp_path / "a.dpx", shown)
    codes = np.round(open_picture(tmp_path / "a.dpx").values / 65535 * 1023)
    np.testing.assert_array_equal(codes, [[[0, 512, 1023], [0, 1, 0]]])


def test_dpx_has_video_transfer_and_identical_bytes_each_time(tmp_path):
    for name in ("a.dpx", "b.dpx"):
        write_display_values(tmp_path / name, smooth(3), MARKS)
    assert (tmp_path / "a.dpx").read_bytes() == (tmp_path / "b.dpx").read_bytes()
    opened = OpenImageIO.ImageInput.open(str(tmp_path / "a.dpx"))
    assert opened.spec()["dpx:Transfer"] == "ITU-R 709-4"
    opened.close()


@pytest.mark.parametrize("channels", [3, 4])
def test_webp_is_close_to_written_values(tmp_path, channels):
    path, shown = tmp_path / "a.webp", smooth(channels)
    write_display_values(path, shown, MARKS)
    difference = np.abs(open_picture(path).values / 255 - shown)
    assert difference.mean() < 0.01 and difference.max() < 0.1
    if channels == 4:
        assert difference[..., 3].max() < 0.51 / 255  # transparency has no losses
    assert fingerprint_in(path) == "f" * 64


def test_write_png_to_dpx_blends_over_black_and_reads_back_as_light(tmp_path):
    light = np.dstack([smooth(3) * 0.5, np.full((24, 48), 0.5, np.float32)])
    write_png(tmp_path / "a.dpx", light)
    save_dpx(tmp_path / "z.dpx", np.full((24, 48, 1), 0.5), 16)
    options = PlateOptions(depth_source=str(tmp_path / "z.dpx"), near_m=1.0, far_m=9.0)
    plate = read_plate(tmp_path / "a.dpx", options)
    np.testing.assert_allclose(plate.color[..., :3], light[..., :3], atol=2e-3)
    assert "10 bits, taken as sRGB" in " ".join(plate.notes)
    assert np.ptp(plate.depth_m) == 0 and 1 < plate.depth_m[0, 0] < 9


def test_read_plate_notes_printing_density_of_dpx(tmp_path):
    path = save_dpx(tmp_path / "a.dpx", smooth(3), Transfer="Printing density")
    save_dpx(tmp_path / "z.dpx", np.full((24, 48, 1), 0.5), 16)
    options = PlateOptions(depth_source=str(tmp_path / "z.dpx"), near_m=1.0, far_m=9.0)
    assert "printing density, the log of film" in " ".join(read_plate(path, options).notes)
    write_display_values(path, smooth(3))
    assert "log of film" not in " ".join(read_plate(path, options).notes)


@pytest.mark.parametrize("suffix", [".png", ".webp", ".dpx"])
def test_scene_is_rendered_to_png_webp_and_dpx(tmp_path, capsys, suffix):
    words = ("--size", "32x18", "--quality", "draft")
    render(capsys, "demo", tmp_path / f"a{suffix}", *words)
    assert open_picture(tmp_path / f"a{suffix}").values.shape == (18, 32, 3)


def test_open_picture_rejects_truncated_dpx(tmp_path):
    path = tmp_path / "a.dpx"
    write_display_values(path, smooth(3))
    data = path.read_bytes()
    for length in (0, 3, 500, 2048, len(data) - 1):
        path.write_bytes(data[:length])
        with pytest.raises(InputError, match=r"a\.dpx"):
            open_picture(path)


@pytest.mark.parametrize(("content", "ending"), [(".dpx", ".png"), (".png", ".dpx")])
def test_open_picture_names_true_suffix_of_renamed_dpx_or_png(tmp_path, content, ending):
    write_display_values(tmp_path / f"a{content}", smooth(3))
    disguised = (tmp_path / f"a{content}").rename(tmp_path / f"b{ending}")
    with pytest.raises(InputError, match=rf"although its name ends in {ending}: rename it to b"):
        open_picture(disguised)


def test_open_picture_does_not_open_other_formats_as_dpx(tmp_path):
    """OpenImageIO would try all its readers, and open a Radiance image under this name."""
    path, spec = tmp_path / "a.dpx", OpenImageIO.ImageSpec(4, 4, 3, "float")
    out = OpenImageIO.ImageOutput.create("hdr")
    assert out.open(str(path), spec) and out.write_image(np.ones((4, 4, 3), np.float32))
    out.close()
    with pytest.raises(InputError, match=r"cannot be read as \.dpx"):
        open_picture(path)


def test_render_to_dpx_without_openimageio_fails_before_rendering(capsys, tmp_path, monkeypatch):
    write_plate(tmp_path / "p.exr")
    monkeypatch.setitem(sys.modules, "OpenImageIO", None)
    message = refused_render_message(capsys, tmp_path / "p.exr", tmp_path / "a.dpx")
    assert (
        "Writing DPX needs the package OpenImageIO" in message and "heatlens[pictures]" in message
    )
