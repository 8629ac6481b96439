"""Test that a photo's own focus and simulated f-stop become the start lens."""

import numpy as np
import pytest
from PIL import Image

from heatlens.media.plate.picture.picture_open import open_picture
from heatlens.media.plate.picture.portrait import portrait_header
from heatlens.media.plate.read import read_plate
from support.picture_files import heic_with_depth, jpeg_with_gdepth

NEAR_M, FAR_M = 1.0, 8.0
REGION = (
    '<x:xmpmeta xmlns:x="adobe:ns:meta/"><rdf:Bag><rdf:li><rdf:Description mwg-rs:Type="Face">'
    '<mwg-rs:Area stArea:x="0.1" stArea:y="0.1"/></rdf:Description></rdf:li>'
    "<rdf:li><mwg-rs:Type>Focus</mwg-rs:Type><mwg-rs:Area><stArea:x>{x}</stArea:x>"
    "<stArea:y>{y}</stArea:y></mwg-rs:Area></rdf:li></rdf:Bag>"
    "<depthBlurEffect:SimulatedAperture>{f_stop}</depthBlurEffect:SimulatedAperture></x:xmpmeta>"
)


def left_near(height: int = 64, width: int = 96) -> np.ndarray:
    """Return a depth map of 0 to 1 with something near in the left third of the upper half."""
    fraction = np.zeros((height, width), np.float32)
    fraction[: height // 2, : width // 3] = 1.0
    return fraction


def write_heic(path, xmp: str):
    pytest.importorskip("pillow_heif").register_heif_opener()
    return heic_with_depth(path, NEAR_M, FAR_M, left_near(), quality=100, xmp=xmp.encode())


@pytest.mark.parametrize(("x", "focus_m"), [(0.2, NEAR_M), (0.8, FAR_M)])
def test_read_plate_of_portrait_takes_its_focus_and_f_stop(tmp_path, x, focus_m):
    path = write_heic(tmp_path / "p.heic", REGION.format(x=x, y=0.25, f_stop=2.8))
    camera = read_plate(path).camera
    assert camera.focus_distance_m == pytest.approx(focus_m, rel=0.02)
    assert camera.f_stop == pytest.approx(2.8)
    assert "focus of the photo" in camera.sources["focus_distance_m"]


@pytest.mark.parametrize("xmp", ["", "<x>", REGION.format(x="...", y=7, f_stop="1.2.3")])
def test_read_plate_of_portrait_ignores_unreadable_metadata(tmp_path, xmp):
    camera = read_plate(write_heic(tmp_path / "p.heic", xmp or " ")).camera
    assert camera.focus_distance_m is None and camera.f_stop is None


@pytest.mark.parametrize("turn", range(1, 9))
def test_portrait_focus_point_rotates_with_photo(tmp_path, turn):
    """The stored pixel that was in focus shows the same object in the upright image."""
    path = jpeg_with_gdepth(tmp_path / "p.jpg", NEAR_M, FAR_M, left_near())
    stored = np.zeros((60, 90), np.uint8)
    stored[10:20, 5:25] = 255
    with Image.open(path) as image:
        exif = image.getexif()
    exif[0x0112] = turn  # orientation
    exif.get_ifd(0x8769)[0x9214] = (15, 15)  # the area in focus, in the Exif block
    plain = tmp_path / "plain.png"
    Image.fromarray(stored).save(plain, exif=exif)
    raw = open_picture(plain)
    header = portrait_header(plain, (90, 60), raw.info)
    (x, y), (height, width) = next(iter(header.values())), raw.values.shape[:2]
    assert (width, height) == ((60, 90) if turn > 4 else (90, 60))
    assert raw.values[int(y * height), int(x * width), 0] == 255
