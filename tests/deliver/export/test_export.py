"""Test `heatlens export` to EXR: frames equal those of `heatlens render`, headers hold the lens."""

from dataclasses import replace

import numpy as np
import pytest

from heatlens.core.model.focus.coc import coc_line, coc_px
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.core.model.shot.settings import Bokeh, DefocusSettings, Quality
from heatlens.media.documents.shot_file import read_shot, write_shot
from heatlens.media.plate.header.camera_header import camera_at_header
from heatlens.media.plate.read import read_plate
from support.exports import (
    FRAMES,
    HEIGHT,
    QUICK,
    WIDTH,
    export_shot,
    exr,
    files_in,
    names_of,
    refused_export_message,
    render_frame_of_shot,
    same_frames,
    shot_of,
    with_focus,
    write_plates,
)
from support.exr_files import rgb, window, write_file


def test_exported_frames_equal_rendered_ones(capsys, shot_file, out, tmp_path):
    export_shot(capsys, shot_file, out, "--float")
    assert list(files_in(out.parent)) == names_of(".exr")
    shot = read_shot(shot_file)
    for frame in FRAMES:
        alone = render_frame_of_shot(capsys, shot, frame, tmp_path / "alone.exr", "--float")
        assert same_frames(out.parent / f"n.{frame}.exr", alone)
    assert not same_frames(out.parent / "n.1001.exr", out.parent / "n.1002.exr")


def test_export_of_disc_bokeh_at_half_size_equals_render(capsys, shot_file, out, tmp_path):
    """Blur options on the command line replace those of the shot."""
    words = ("--bokeh", "disc", "--proxy", "0.5")
    export_shot(capsys, shot_file, out, *words, "--frames", "1003")
    blur = DefocusSettings(bokeh=Bokeh.DISC, quality=QUICK.quality, layers=None, proxy=0.5)
    shot = replace(read_shot(shot_file), defocus=blur)
    alone = render_frame_of_shot(capsys, shot, 1003, tmp_path / "alone.exr")
    assert same_frames(out.parent / "n.1003.exr", alone)
    assert exr(alone)[1]["R"].shape == (HEIGHT // 2, WIDTH // 2)


def test_exported_header_holds_lens_of_its_frame(capsys, shot_file, out):
    export_shot(capsys, shot_file, out)
    shot = read_shot(shot_file)
    for frame in FRAMES:
        camera, lens = camera_at_header([exr(out.parent / f"n.{frame}.exr")[0]]), None
        lens = shot.lens_at(frame)
        assert camera.focus_distance_m == pytest.approx(lens.focus_distance_m, rel=1e-6)
        assert camera.f_stop == pytest.approx(lens.f_stop, rel=1e-6)
        assert camera.focal_length_mm == lens.focal_length_mm
        assert camera.sensor_width_mm == lens.sensor_width_mm


def test_export_keeps_windows_and_metadata_of_plates(capsys, tmp_path, out):
    windows = {"dataWindow": window(-3, 2, 29, 20), "displayWindow": window(0, 0, 28, 24)}
    header = {"owner": "second unit", "pixelAspectRatio": 2.0, "tStop": 2.3, **windows}
    write_shot(tmp_path / "s.heatlens.json", shot_of(write_plates(tmp_path / "plates", **header)))
    export_shot(capsys, tmp_path / "s.heatlens.json", out)
    out_header = exr(out.parent / "n.1004.exr")[0]
    assert out_header["owner"] == "second unit" and out_header["pixelAspectRatio"] == 2.0
    assert out_header["tStop"] == pytest.approx(2.3)
    for name, value in windows.items():
        np.testing.assert_array_equal(out_header[name], value)


@pytest.mark.parametrize("compression", ["none", "zips", "piz"])
def test_export_options_set_compression_and_float_depth(
    capsys, shot_file, out, tmp_path, compression
):
    export_shot(capsys, shot_file, out, "--frames", "1001", "--compression", compression)
    header, channels = exr(out.parent / "n.1001.exr")
    compression_name = "NO" if compression == "none" else compression.upper()
    assert str(header["compression"]).endswith(f"{compression_name}_COMPRESSION")
    assert channels["R"].dtype == np.float16 and set(channels) == {"R", "G", "B"}
    export_shot(capsys, shot_file, tmp_path / "f.exr", "--frames", "1001", "--float")
    assert exr(tmp_path / "f.exr")[1]["R"].dtype == np.float32


@pytest.mark.parametrize("proxy", [1.0, 0.5])
def test_export_with_depth_and_coc_adds_those_channels(capsys, shot_file, out, proxy):
    words = ("--with-depth", "--with-coc", "--proxy", proxy, "--frames", "1002")
    export_shot(capsys, shot_file, out, *words)
    _, channels = exr(out.parent / "n.1002.exr")
    shot = read_shot(shot_file)
    plate = read_plate(shot.source.replace("####", "1002"))
    step = round(1 / proxy)
    depth_m = plate.depth_m[step // 2 :: step, step // 2 :: step]
    coc = proxy * coc_px(depth_m, coc_line(shot.lens_at(1002), WIDTH))
    assert channels["Z"].dtype == channels["coc"].dtype == np.float32
    assert np.array_equal(channels["Z"], depth_m) and np.isinf(depth_m).any()
    np.testing.assert_allclose(channels["coc"], coc, rtol=1e-6)


def test_exported_coc_channel_can_be_read_as_coc_plate(capsys, shot_file, out, tmp_path):
    """The focus is at 3 m, so the sign of the CoC tells nearer pixels from farther ones."""
    export_shot(capsys, shot_file, out, "--with-coc", "--frames", "1006")
    plate = read_plate(out.parent / "n.1006.exr", PlateOptions(depth_convention="coc"))
    depth_m = read_plate(tmp_path / "plates" / "plate.1006.exr").depth_m
    assert np.array_equal(plate.coc_px > 0, depth_m > 3.0)


def test_export_of_coc_plate_refuses_with_depth(capsys, tmp_path, out):
    coc = np.full((HEIGHT, WIDTH), 4.0, np.float32)
    plate = write_file(tmp_path / "p.exr", rgb(HEIGHT, WIDTH) | {"coc": coc})
    words = ("--depth-convention", "coc", "--bokeh", "heat", "--quality", "draft")
    export_shot(capsys, plate, out.with_name("n.exr"), *words, "--with-coc")
    assert np.array_equal(exr(out.with_name("n.exr"))[1]["coc"], coc)
    message = refused_export_message(capsys, plate, out.with_name("m.exr"), *words, "--with-depth")
    assert "p.exr" in message and "no depth" in message
    assert list(files_in(out.parent)) == ["n.exr"]


def test_export_uses_focus_key_added_to_shot(capsys, shot_file, out):
    write_shot(shot_file, with_focus(read_shot(shot_file), 1003, 5.0))
    export_shot(capsys, shot_file, out, "--frames", "1003")
    camera = camera_at_header([exr(out.parent / "n.1003.exr")[0]])
    assert camera.focus_distance_m == pytest.approx(5.0)
    assert Quality.DRAFT is read_shot(shot_file).defocus.quality
