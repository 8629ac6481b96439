"""What lies outside the data window of a picture with alpha is empty, and blurs like the rest."""

from dataclasses import fields

import numpy as np
import pytest

from heatlens.core.model.boxes import Box
from heatlens.core.model.depth_words import DepthConvention
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.core.model.shot.settings import DefocusSettings, Quality
from heatlens.core.model.shot.shot import Shot
from heatlens.media.plate.deep.stacked import window_of_all
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


def both(tmp_path, channels: dict[str, np.ndarray]):
    """Write the element cut to its box, and at full size."""
    cut = {name: np.ascontiguousarray(values[INSIDE]) for name, values in channels.items()}
    data = window(12, 6, 28, 18)
    cropped = write_file(tmp_path / "cut.exr", cut, dataWindow=data, displayWindow=DISPLAY)
    return cropped, write_file(tmp_path / "full.exr", channels, displayWindow=DISPLAY)


def assert_same(cropped, full) -> None:
    assert cropped.data_window == full.data_window == Box(0, 0, 40, 24)
    assert np.array_equal(cropped.color, full.color) and cropped.has_alpha
    for values, other in ((cropped.depth_m, full.depth_m), (cropped.coc_px, full.coc_px)):
        assert values is other is None or np.array_equal(values, other)
    report, expected = cropped.depth, full.depth
    assert (report.near_m, report.infinite_count) == pytest.approx(
        (expected.near_m, expected.infinite_count), nan_ok=True
    )


def test_an_element_cut_to_its_box_is_the_same_plate_as_at_full_size(tmp_path):
    cropped, full = both(tmp_path, element())
    assert_same(read_plate(cropped), read_plate(full))
    assert inspect(cropped, PlateOptions())["data_window"] == [12, 6, 28, 18]


@pytest.mark.parametrize("method", OF_PLATES)
@pytest.mark.parametrize("quality", [Quality.FILM, Quality.PREVIEW])
def test_it_blurs_beyond_its_box_in_every_method(tmp_path, renderer, method, quality):
    cropped, full = both(tmp_path, element())
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
def test_circles_of_confusion_outside_do_not_hide_the_blur(tmp_path, renderer, coc_px):
    cropped, full = both(tmp_path, element(far=coc_px, depth="coc", value=coc_px))
    options = PlateOptions(depth_convention=DepthConvention.COC)
    plate = read_plate(cropped, options)
    assert_same(plate, read_plate(full, options))
    renderer.load(plate)
    alpha = renderer.pixels(Shot(Lens(50.0, 2.0, 2.0, 36.0)))[12, :, 3]
    assert 0.05 < alpha[10] < 0.6 and 0.4 < alpha[13] < 0.95 and alpha[2] < 0.03


def test_a_picture_behind_is_seen_in_the_whole_frame(tmp_path):
    cropped, full = both(tmp_path, element())
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


def test_deep_samples_are_the_same_plate_as_at_full_size(tmp_path):
    samples = [[(0.5, 0.5, 2.0), (0.5, 1.0, 5.0)], [(0.25, 1.0, 3.0)]]
    cut = write_deep(
        tmp_path / "cut.exr",
        samples,
        (1, 2),
        dataWindow=window(1, 1, 3, 2),
        displayWindow=window(0, 0, 4, 3),
    )
    whole = [[]] * 5 + samples + [[]] * 5
    full = write_deep(tmp_path / "full.exr", whole, (3, 4), displayWindow=window(0, 0, 4, 3))
    plates = [read_plate(path) for path in (cut, full)]
    assert_same_behind(*plates)
    assert plates[0].has_alpha and plates[0].depth == plates[1].depth
    assert plates[0].behind == plates[1].behind and plates[0].fragments.count == 2
    assert inspect(cut, PlateOptions())["data_window"] == [1, 1, 3, 2]


def test_a_plate_without_alpha_stays_over_its_data_window(tmp_path):
    channels = element()
    del channels["A"]
    plate = read_plate(both(tmp_path, channels)[0])
    assert plate.data_window == BOX and not plate.has_alpha
    assert (plate.color[..., 3] == 1.0).all() and np.isfinite(plate.depth_m).all()


def test_overscan_stays_and_an_impossible_display_window_is_left():
    wide = Box(-4, -4, 44, 20)
    assert window_of_all(wide, Box(0, 0, 40, 24)) == Box(-4, -4, 44, 24)
    assert window_of_all(BOX, Box(0, 0, 1 << 30, 1 << 30)) == BOX
    assert window_of_all(BOX, Box(50, 50, 2, 2)) == BOX


def test_a_display_window_may_be_large_where_the_file_holds_much_itself():
    """It takes memory and time, and costs the file no bytes."""
    frame, vast = Box(0, 0, 8192, 4320), Box(0, 0, 8192, 8192)
    assert window_of_all(BOX, frame) == frame
    assert window_of_all(BOX, vast) == BOX
    assert window_of_all(frame, vast) == vast
