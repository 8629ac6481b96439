"""Test that a plate with alpha is empty outside its data window and blurs over its edges."""

from dataclasses import fields

import numpy as np
import pytest

from heatlens.core.model.boxes import Box
from heatlens.core.model.depth_words import DepthConvention
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.core.model.shot.settings import DefocusSettings, Quality
from heatlens.core.model.shot.shot import Shot
from heatlens.media.plate.deep.stacked import enclosing_window
from heatlens.media.plate.inspection import inspect
from heatlens.media.plate.read import read_plate
from support.deep_files import write_deep
from support.exr_files import window, write_file
from support.methods_of_plates import OF_PLATES
from support.plates import lens_blurring

SIZE = (24, 40)
BOX = Box(12, 6, 28, 18)  # that of the element
DISPLAY = window(0, 0, 40, 24)
INSIDE = (slice(6, 18), slice(12, 28))


def element(far: float = np.inf, depth: str = "Z", value: float = 4.0) -> dict[str, np.ndarray]:
    """Return an orange card with alpha in an empty frame."""
    channels = {name: np.zeros(SIZE, np.float32) for name in "RGBA"}
    for name, light in {"R": 0.9, "G": 0.5, "B": 0.1, "A": 1.0}.items():
        channels[name][INSIDE] = light
    channels[depth] = np.full(SIZE, far, np.float32)
    channels[depth][INSIDE] = value
    return channels


def write_cropped_and_full(tmp_path, channels: dict[str, np.ndarray]):
    """Write the element cut to its box, and at full size."""
    cut = {name: np.ascontiguousarray(values[INSIDE]) for name, values in channels.items()}
    data = window(12, 6, 28, 18)
    cropped = write_file(tmp_path / "cut.exr", cut, dataWindow=data, displayWindow=DISPLAY)
    return cropped, write_file(tmp_path / "full.exr", channels, displayWindow=DISPLAY)


def assert_same_plates(cropped, full) -> None:
    assert cropped.data_window == full.data_window == Box(0, 0, 40, 24)
    assert np.array_equal(cropped.color, full.color) and cropped.has_alpha
    for values, full_values in ((cropped.depth_m, full.depth_m), (cropped.coc_px, full.coc_px)):
        assert values is full_values is None or np.array_equal(values, full_values)
    report, expected = cropped.depth, full.depth
    assert (report.near_m, report.infinite_count) == pytest.approx(
        (expected.near_m, expected.infinite_count), nan_ok=True
    )


def test_read_plate_of_cropped_element_equals_full_size(tmp_path):
    cropped, full = write_cropped_and_full(tmp_path, element())
    assert_same_plates(read_plate(cropped), read_plate(full))
    assert inspect(cropped, PlateOptions())["data_window"] == [12, 6, 28, 18]


@pytest.mark.parametrize("method", OF_PLATES)
@pytest.mark.parametrize("quality", [Quality.FILM, Quality.PREVIEW])
def test_cropped_element_blurs_beyond_its_box_in_every_method(tmp_path, renderer, method, quality):
    cropped, full = write_cropped_and_full(tmp_path, element())
    settings = DefocusSettings(method=method, quality=quality)
    shot = Shot(lens_blurring(8.0, SIZE[1]), settings)
    pictures = []
    for path in (cropped, full):
        renderer.load(read_plate(path))
        pictures.append(renderer.pixels(shot))
    assert pictures[0].shape == (*SIZE, 4)
    assert np.allclose(*pictures, rtol=1e-4, atol=1e-5)
    alpha = pictures[0][12, :, 3]
    assert 0.05 < alpha[10] < 0.6 and 0.4 < alpha[13] < 0.95 and alpha[2] < 0.03


@pytest.mark.parametrize("coc_px", [-8.0, 8.0])
def test_circle_of_confusion_outside_box_does_not_hide_blur(tmp_path, renderer, coc_px):
    cropped, full = write_cropped_and_full(tmp_path, element(far=coc_px, depth="coc", value=coc_px))
    options = PlateOptions(depth_convention=DepthConvention.COC)
    plate = read_plate(cropped, options)
    assert_same_plates(plate, read_plate(full, options))
    renderer.load(plate)
    alpha = renderer.pixels(Shot(Lens(50.0, 2.0, 2.0, 36.0)))[12, :, 3]
    assert 0.05 < alpha[10] < 0.6 and 0.4 < alpha[13] < 0.95 and alpha[2] < 0.03


def test_behind_image_of_cropped_element_covers_whole_frame(tmp_path):
    cropped, full = write_cropped_and_full(tmp_path, element())
    wall = {name: np.full(SIZE, 0.25, np.float32) for name in "RGB"}
    wall["Z"] = np.full(SIZE, 9.0, np.float32)
    options = PlateOptions(behind=(str(write_file(tmp_path / "wall.exr", wall)),))
    plates = [read_plate(path, options) for path in (cropped, full)]
    assert_same_behind(*plates)
    assert plates[0].color[0, 0, 0] == 0.25 and plates[0].depth_m[0, 0] == 9.0


def assert_same_behind(cropped, full) -> None:
    assert cropped.data_window == full.data_window
    assert np.array_equal(cropped.color, full.color)
    assert np.array_equal(cropped.depth_m, full.depth_m)
    for field in fields(full.fragments):
        values = [getattr(plate.fragments, field.name) for plate in (cropped, full)]
        assert np.array_equal(*values), field.name


def test_read_plate_of_cropped_deep_file_equals_full_size(tmp_path):
    samples = [[(0.5, 0.5, 2.0), (0.5, 1.0, 5.0)], [(0.25, 1.0, 3.0)]]
    cut = write_deep(
        tmp_path / "cut.exr",
        samples,
        (1, 2),
        dataWindow=window(1, 1, 3, 2),
        displayWindow=window(0, 0, 4, 3),
    )
    full_samples = [[]] * 5 + samples + [[]] * 5
    full = write_deep(tmp_path / "full.exr", full_samples, (3, 4), displayWindow=window(0, 0, 4, 3))
    plates = [read_plate(path) for path in (cut, full)]
    assert_same_behind(*plates)
    assert plates[0].has_alpha and plates[0].depth == plates[1].depth
    assert plates[0].behind == plates[1].behind and plates[0].fragments.count == 2
    assert inspect(cut, PlateOptions())["data_window"] == [1, 1, 3, 2]


def test_read_plate_without_alpha_keeps_its_data_window(tmp_path):
    channels = element()
    del channels["A"]
    plate = read_plate(write_cropped_and_full(tmp_path, channels)[0])
    assert plate.data_window == BOX and not plate.has_alpha
    assert (plate.color[..., 3] == 1.0).all() and np.isfinite(plate.depth_m).all()


def test_enclosing_window_keeps_overscan_and_ignores_impossible_display():
    wide = Box(-4, -4, 44, 20)
    assert enclosing_window(wide, Box(0, 0, 40, 24)) == Box(-4, -4, 44, 24)
    assert enclosing_window(BOX, Box(0, 0, 1 << 30, 1 << 30)) == BOX
    assert enclosing_window(BOX, Box(50, 50, 2, 2)) == BOX


def test_enclosing_window_allows_large_display_for_large_data_only():
    """A large display window takes memory and time, but no bytes in the file."""
    frame, vast = Box(0, 0, 8192, 4320), Box(0, 0, 8192, 8192)
    assert enclosing_window(BOX, frame) == frame
    assert enclosing_window(BOX, vast) == BOX
    assert enclosing_window(frame, vast) == vast
