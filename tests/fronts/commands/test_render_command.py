"""Test `heatlens render`: the written files, and the messages about the lens."""

import numpy as np
import pytest
from PIL import Image

from heatlens.media.camera.plate_camera import read_plate_camera
from heatlens.media.plate.exr.exr_read import read_parts
from heatlens.media.plate.header.camera_header import CameraHeader, camera_at_header
from support.command_line import (
    CAMERA,
    HEIGHT,
    OLD_CONTENT,
    WIDTH,
    channels,
    folder_of,
    picture,
    refused_render_message,
    render,
)
from support.exr_files import rgb, window, write_file


@pytest.fixture
def plate(tmp_path):
    return write_file(tmp_path / "plate.exr", channels(), **CAMERA)


# What is written


def test_render_exr_keeps_windows_and_writes_lens_and_half_colors(capsys, tmp_path):
    windows = {"dataWindow": window(-3, 2, 13, 12), "displayWindow": window(0, 0, 12, 14)}
    plate = write_file(tmp_path / "p.exr", channels(), pixelAspectRatio=2.0, **windows, **CAMERA)
    render(capsys, plate, tmp_path / "out.exr", "--f-stop", "1.4")
    header, pixels = picture(tmp_path / "out.exr")
    for name in windows:
        np.testing.assert_array_equal(header[name], windows[name])
    assert header["pixelAspectRatio"] == 2.0
    assert header["channels"][0].name == "B" and len(header["channels"]) == 3
    assert read_parts(tmp_path / "out.exr")[0][1]["R"].dtype == np.float16
    assert header["aperture"] == pytest.approx(1.4, rel=1e-6)
    assert np.ptp(pixels[1:, :, 0]) > 0


def test_float_option_writes_float32(capsys, plate, tmp_path):
    render(capsys, plate, tmp_path / "out.exr", "--float")
    assert read_parts(tmp_path / "out.exr")[0][1]["G"].dtype == np.float32


def test_render_copies_metadata_of_plate(capsys, tmp_path):
    plate = write_file(tmp_path / "p.exr", channels(), owner="second unit", tStop=2.3, **CAMERA)
    render(capsys, plate, tmp_path / "out.exr")
    header, _ = picture(tmp_path / "out.exr")
    assert header["owner"] == "second unit" and header["tStop"] == pytest.approx(2.3)


def test_render_png_at_half_size(capsys, plate, tmp_path):
    render(capsys, plate, tmp_path / "out.png", "--proxy", "0.5")
    with Image.open(tmp_path / "out.png") as image:
        assert (image.format, image.mode, image.size) == ("PNG", "RGB", (WIDTH // 2, HEIGHT // 2))


@pytest.mark.parametrize("name", ["OUT.EXR", "out.PNG", "out.final.exr", "Ä ö.exr"])
def test_render_chooses_format_by_file_ending(capsys, plate, tmp_path, name):
    render(capsys, plate, tmp_path / name)
    magic = (tmp_path / name).read_bytes()[:4]
    assert magic == (b"\x89PNG" if name.lower().endswith("png") else b"\x76\x2f\x31\x01")


def test_proxy_option_scales_both_windows(capsys, tmp_path):
    windows = {"dataWindow": window(-4, 2, 12, 12), "displayWindow": window(0, 0, 20, 14)}
    plate = write_file(tmp_path / "p.exr", channels(), **windows, **CAMERA)
    render(capsys, plate, tmp_path / "out.exr", "--proxy", "0.5")
    header, pixels = picture(tmp_path / "out.exr")
    assert pixels.shape == (5, 8, 3)
    np.testing.assert_array_equal(header["dataWindow"], window(-2, 1, 6, 6))
    np.testing.assert_array_equal(header["displayWindow"], window(0, 0, 10, 7))


def test_render_overwrites_file_with_reproducible_pixels(capsys, plate, tmp_path):
    out = tmp_path / "out.exr"
    out.write_bytes(OLD_CONTENT)
    render(capsys, plate, out, "--float")
    first = picture(out)[1]
    render(capsys, plate, out, "--float")
    assert np.array_equal(first, picture(out)[1])
    assert set(folder_of(out)) == {"plate.exr", "out.exr"}


def test_render_of_plate_in_focus_returns_its_pixels(capsys, tmp_path):
    """The half-float colors of the plate come out unchanged."""
    given_channels = rgb(HEIGHT, WIDTH) | {"Z": np.full((HEIGHT, WIDTH), 2.24, np.float32)}
    plate = write_file(tmp_path / "p.exr", given_channels, **CAMERA)
    render(capsys, plate, tmp_path / "out.exr", "--focus-at", "3,3")
    _, out_channels = read_parts(tmp_path / "out.exr")[0]
    for name in "RGB":
        assert np.array_equal(out_channels[name], given_channels[name])


# The lens: given, from the header, and into the header


def test_render_takes_lens_from_header(capsys, plate, tmp_path):
    message = render(capsys, plate, tmp_path / "out.exr", "--verbose")
    assert "lens: 50 mm, f/2, focus 2.24 m\n" in message
    assert "50 mm (header, pinholeFocalLength)" in message
    assert "sensor width 36" in message
    assert "f/2 (header, aperture)" in message
    assert "focus 2.24 m (header, focus)" in message


def test_lens_options_override_header(capsys, plate, tmp_path):
    lens = ["--focal-length", "85", "--sensor-width", "24.9", "--f-stop", "1.4"]
    message = render(capsys, plate, tmp_path / "out.exr", *lens, "-v", "--focus-distance", "190cm")
    assert "85 mm (--focal-length)" in message
    assert "sensor width 24.9 mm (--sensor-width)" in message
    assert "f/1.4 (--f-stop)" in message
    assert "focus 1.9 m (--focus-distance)" in message


def test_render_reports_assumed_full_frame_sensor(capsys, tmp_path):
    plate = write_file(tmp_path / "p.exr", channels())
    lens = ["--focal-length", "50", "--f-stop", "2", "--focus-distance", "3"]
    assert "assumed full frame; change it with --sensor-width" in render(
        capsys, plate, tmp_path / "o.exr", *lens
    )


def test_filmback_option_sets_sensor_width(capsys, plate, tmp_path):
    message = render(capsys, plate, tmp_path / "out.exr", "--filmback", "usd", "-v")
    assert "sensor width 20.955" in message


@pytest.mark.parametrize(
    ("attribute", "words"),
    [
        ("pinholeFocalLength", ("no focal length", "--focal-length")),
        ("aperture", ("no f-stop", "--f-stop")),
        ("focus", ("no focus distance", "--focus-distance or --focus-at")),
    ],
)
def test_render_asks_for_missing_lens_value(capsys, tmp_path, attribute, words):
    camera = {name: value for name, value in CAMERA.items() if name != attribute}
    plate = write_file(tmp_path / "p.exr", channels(), **camera)
    message = refused_render_message(capsys, plate, tmp_path / "out.exr")
    assert "p.exr" in message and all(word in message for word in words)


@pytest.mark.parametrize("focus", ["1.85", "inf"])
def test_render_writes_lens_into_header(capsys, plate, tmp_path, focus):
    lens = ["--focal-length", "85", "--sensor-width", "24.9", "--f-stop", "1.4"]
    render(capsys, plate, tmp_path / "out.exr", *lens, "--focus-distance", focus)
    camera = camera_at_header([picture(tmp_path / "out.exr")[0]])
    assert camera.focal_length_mm == pytest.approx(85.0, rel=1e-6)
    assert camera.sensor_width_mm == pytest.approx(24.9, rel=1e-6)
    assert camera.f_stop == pytest.approx(1.4, rel=1e-6)
    assert camera.focus_distance_m == pytest.approx(float(focus), rel=1e-6)
    height, width = picture(tmp_path / "out.exr")[1].shape[:2]  # 24 mm belonged to 36 mm
    assert camera.sensor_height_mm == pytest.approx(24.9 * height / width, rel=1e-6)


def test_lens_of_written_header_reproduces_picture(capsys, plate, tmp_path):
    """A plate with the header of the first result needs no option to give the same pixels."""
    render(capsys, plate, tmp_path / "1.exr", "--f-stop", "1.3", "--focus-at", "5,4", "--float")
    header, first = picture(tmp_path / "1.exr")
    names = (*CAMERA, "pinholeFocalLength")
    plate_with_lens = write_file(
        tmp_path / "p.exr", channels(), **{name: header[name] for name in names}
    )
    render(capsys, plate_with_lens, tmp_path / "2.exr", "--float")
    # The header holds float32: f/1.3 comes back 4e-8 off.
    np.testing.assert_allclose(picture(tmp_path / "2.exr")[1], first, rtol=1e-3)


def test_written_sensor_height_follows_picture_aspect(capsys, plate, tmp_path):
    """The header gives 24 mm, but the picture shows less of it; camera files do the same."""
    render(capsys, plate, tmp_path / "out.exr")
    camera = camera_at_header([picture(tmp_path / "out.exr")[0]])
    assert (camera.sensor_width_mm, camera.sensor_height_mm) == (36.0, 36.0 * HEIGHT / WIDTH)
    plate_camera = read_plate_camera(str(tmp_path / "out.exr"))
    assert plate_camera.sensor_height_mm == (camera.sensor_height_mm,)


def test_render_of_coc_plate_uses_and_writes_no_lens(capsys, tmp_path):
    coc = np.full((HEIGHT, WIDTH), 4.0, np.float32)
    plate = write_file(tmp_path / "p.exr", rgb(HEIGHT, WIDTH) | {"coc": coc})
    words = ("--depth-convention", "coc")
    message = render(capsys, plate, tmp_path / "out.exr", *words, "--f-stop", "2")
    assert "of confusion, --f-stop" in message
    assert camera_at_header([picture(tmp_path / "out.exr")[0]]) == CameraHeader()
    message = refused_render_message(
        capsys, plate, tmp_path / "no.exr", *words, "--focus-at", "1,1"
    )
    assert "no distances" in message


def test_filmback_option_applies_to_radial_depth(capsys, plate, tmp_path):
    """A film back by name and its width in millimetres give the same lens."""
    words = ("--float", "--depth-kind", "radial")
    render(capsys, plate, tmp_path / "1.exr", *words, "--filmback", "USD")
    render(capsys, plate, tmp_path / "2.exr", *words, "--sensor-width", "20.955")
    assert np.array_equal(picture(tmp_path / "1.exr")[1], picture(tmp_path / "2.exr")[1])


def test_render_png_of_squeezed_plate_suggests_desqueeze(tmp_path, capsys):
    plate = write_file(tmp_path / "wide.exr", channels(), pixelAspectRatio=2.0, **CAMERA)
    words = ("--f-stop", "2", "--focus-distance", "3")
    message = render(capsys, plate, tmp_path / "o.png", *words)
    assert "2 times as wide as high" in message and "--desqueeze 2" in message
    assert "squeezed" not in render(capsys, plate, tmp_path / "o.exr", *words)
