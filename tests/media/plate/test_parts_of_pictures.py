"""Test images as parts with channels: light, alpha, depth and lens of PNG, JPEG and TIFF."""

import numpy as np
import pytest
from PIL import Image, ImageCms

from heatlens.core.base.errors import InputError
from heatlens.core.model.shot.plate_options import PictureCurve, PlateOptions
from heatlens.media.plate.header.entries import FOR_THE_EYE, picture_facts
from heatlens.media.plate.parts.picture_parts import color_parts, depth_parts, picture_header
from heatlens.media.plate.read import read_plate


def decode_srgb(value):
    """Return sRGB as IEC 61966-2-1 decodes it."""
    return value / 12.92 if value <= 0.04045 else ((value + 0.055) / 1.055) ** 2.4


def save_png(path, pixels, **options):
    Image.fromarray(pixels).save(path, **options)
    return path


def single_part(parts):
    ((header, channels),) = parts
    return header, channels


@pytest.mark.parametrize(
    ("shape", "names"), [((3, 4), "Y"), ((3, 4, 2), "YA"), ((3, 4, 3), "RGB"), ((3, 4, 4), "RGBA")]
)
def test_color_parts_name_channels_by_their_number(tmp_path, shape, names):
    pixels = np.full(shape, 255, np.uint8)
    header, channels = single_part(
        color_parts(save_png(tmp_path / "a.png", pixels), PictureCurve.AUTO)
    )
    assert "".join(channels) == names and header[FOR_THE_EYE] == 1
    assert [channel.name for channel in header["channels"]] == list(names)
    assert all((values == 1.0).all() for values in channels.values())
    assert header["dataWindow"][1].tolist() == [3, 2]


@pytest.mark.parametrize("value", [0, 5, 10, 11, 128, 255])
def test_color_parts_decode_integers_as_srgb_unless_linear(tmp_path, value):
    path = save_png(tmp_path / "a.png", np.full((2, 2, 3), value, np.uint8))
    for curve, expected in (
        (PictureCurve.AUTO, decode_srgb(value / 255)),
        (PictureCurve.SRGB, decode_srgb(value / 255)),
        (PictureCurve.LINEAR, value / 255),
    ):
        header, channels = single_part(color_parts(path, curve))
        assert channels["G"] == pytest.approx(np.full((2, 2), expected), rel=1e-5)
        notes = picture_facts(header).notes
        assert bool(notes) is (curve is PictureCurve.AUTO)
    assert picture_facts({}) is None


def test_color_parts_premultiply_color_in_linear_light(tmp_path):
    pixels = np.full((2, 2, 4), 128, np.uint8)
    pixels[..., 3] = 51
    _, channels = single_part(color_parts(save_png(tmp_path / "a.png", pixels), PictureCurve.AUTO))
    assert channels["A"] == pytest.approx(np.full((2, 2), 0.2))
    assert channels["R"] == pytest.approx(np.full((2, 2), 0.2 * decode_srgb(128 / 255)), rel=1e-5)


def test_depth_parts_keep_stored_values(tmp_path):
    deep = np.array([[0, 1000], [40000, 65535]], np.uint16)
    header, channels = single_part(depth_parts(save_png(tmp_path / "z.png", deep)))
    np.testing.assert_array_equal(channels["Z"], deep)
    assert picture_facts(header).full_scale == 65535.0
    floats = np.array([[0.5, 2.0], [3.0, 1e6]], np.float32)
    header, channels = single_part(depth_parts(save_png(tmp_path / "z.tif", floats)))
    np.testing.assert_array_equal(channels["Z"], floats)
    assert picture_facts(header).full_scale is None and FOR_THE_EYE not in header


@pytest.mark.parametrize(("off", "is_grey"), [(0, True), (5, True), (6, False), (100, False)])
def test_depth_parts_accept_small_color_difference_as_gray(tmp_path, off, is_grey):
    pixels = np.full((2, 2, 3), 100, np.uint8)
    pixels[..., 1] += off
    path = save_png(tmp_path / "z.png", pixels)
    if is_grey:
        assert single_part(depth_parts(path))[1]["Z"].max() == 100
    else:
        with pytest.raises(InputError, match="coloured"):
            depth_parts(path)


@pytest.mark.parametrize(
    ("focal_mm", "is_told"), [(1, True), (26, True), (2000, True), (2001, False)]
)
def test_picture_header_takes_focal_length_of_exif_but_not_f_stop(tmp_path, focal_mm, is_told):
    exif = Image.Exif()
    exif.get_ifd(0x8769)[0xA405] = focal_mm  # focal length for 35 mm film, in the Exif block
    exif.get_ifd(0x8769)[0x829D] = 1.8  # f-stop
    path = save_png(tmp_path / "a.jpg", np.zeros((2, 2, 3), np.uint8), exif=exif)
    header = picture_header(path)
    assert ("pinholeFocalLength" in header) is is_told and "fStop" not in header
    if is_told:
        assert header["pinholeFocalLength"] == pytest.approx(focal_mm)
    assert header[FOR_THE_EYE] == 1


def test_color_parts_convert_profile_or_note_it(tmp_path):
    lab = ImageCms.ImageCmsProfile(ImageCms.createProfile("LAB")).tobytes()
    srgb = ImageCms.ImageCmsProfile(ImageCms.createProfile("sRGB")).tobytes()
    pixels = np.full((2, 2, 3), 128, np.uint8)

    def notes(profile, values=pixels):
        path = save_png(tmp_path / "a.png", values, icc_profile=profile)
        return " ".join(picture_facts(single_part(color_parts(path, PictureCurve.SRGB))[0]).notes)

    assert notes(srgb) == "" == notes(b"no profile")
    assert "cannot be used; taken as sRGB" in notes(lab) or "converted" in notes(lab)


@pytest.mark.parametrize(("kind", "full"), [(np.uint16, 65535), (np.uint8, 255)])
def test_read_plate_fills_unmeasured_pixels_of_integer_depth(tmp_path, kind, full):
    """0 and the largest number are fills in a map of integers; among floats both are distances."""
    millimetres = np.full((12, 16), 200, kind)
    millimetres[:, 8:] = 100
    millimetres[2, 2:4], millimetres[5, 12] = 0, full
    color = save_png(tmp_path / "c.png", np.full((12, 16, 3), 90, np.uint8))
    depth = save_png(tmp_path / "d.png", millimetres)
    options = PlateOptions(depth_source=str(depth), scene_unit_m=0.001)
    plate = read_plate(color, options)
    expected_m = np.where(np.arange(16) < 8, 0.2, 0.1)
    np.testing.assert_allclose(plate.depth_m, np.broadcast_to(expected_m, (12, 16)), rtol=1e-6)
    assert any(f"0 in 2 and {full} in 1 of 192" in note for note in plate.notes)


def test_read_plate_keeps_sky_of_mostly_empty_depth_map(tmp_path):
    millimetres = np.zeros((12, 16), np.uint16)
    millimetres[9:] = 2000
    color = save_png(tmp_path / "c.png", np.full((12, 16, 3), 90, np.uint8))
    depth = save_png(tmp_path / "d.png", millimetres)
    plate = read_plate(color, PlateOptions(depth_source=str(depth), scene_unit_m=0.001))
    assert np.isinf(plate.depth_m[:9]).all() and (plate.depth_m[9:] == 2).all()
