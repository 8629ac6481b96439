"""Test edge cases and documented numbers of reading and writing plates."""

from dataclasses import fields, replace

import numpy as np
import OpenEXR
import pytest
from hypothesis import given
from hypothesis import strategies as st

from heatlens.core.base.errors import InputError
from heatlens.core.model.boxes import Box
from heatlens.core.model.curves.frames import FrameRange
from heatlens.core.model.depth_words import DepthConvention, DepthKind
from heatlens.core.model.lens.breathing import breathing_note
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.lens_parameter import LensParameter
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.core.model.shot.shot import Shot
from heatlens.media.plate.behind import _convention_behind
from heatlens.media.plate.coc_line import area_at, depth_at_m, upper_median_m
from heatlens.media.plate.deep.deep_plate import read_deep_plate, read_flattened_part
from heatlens.media.plate.deep.deep_write import check_deep_fits, deep_samples, write_deep
from heatlens.media.plate.deep.fragment_merge import _SLICE, _SLICES_MOST
from heatlens.media.plate.grain import measure_noise
from heatlens.media.plate.header.camera_header import _shorten_value
from heatlens.media.plate.header.shoot_names import ShootLens
from heatlens.media.plate.of_arrays import plate_of_arrays
from heatlens.media.plate.overscan_need import (
    frame_centre_px,
    overscan_ratio,
    picture_point,
    plate_pixel,
)
from heatlens.media.plate.picture.openimageio_read import MAX_SIDE_PX, check_size
from heatlens.media.plate.picture.picture_open import _HEAD_BYTES
from heatlens.media.plate.plate_notes import breathing_notes, depth_note, lens_notes, shot_notes
from heatlens.media.plate.windows import make_header_window
from support.fragment_lists import packed_lists
from support.plates import coc_plate_of, plate_of

LENS = Lens(50.0, 2.0, 2.0, 36.0)


def gray_color(height, width):
    return np.full((height, width, 3), 0.5, np.float32)


def test_plate_of_arrays_reports_distance_or_circle_of_confusion():
    metres = plate_of_arrays(gray_color(2, 3), depth_m=np.full((2, 3), 4.0))
    pixels = plate_of_arrays(gray_color(2, 3), coc_px=np.full((2, 3), -4.0))
    assert metres.depth.convention is DepthConvention.DISTANCE and metres.depth.near_m == 4.0
    assert pixels.depth.convention is DepthConvention.COC and not pixels.has_distances


# Focus by a click


def test_depth_at_m_is_median_of_five_by_five():
    depth = np.full((9, 9), 8.0, np.float32)
    depth[2:7, 2:7] = 2.0
    depth[4, 4] = 99.0  # a noisy pixel
    plate = plate_of(gray_color(9, 9), depth)
    assert depth_at_m(plate, 4, 4) == 2.0
    assert depth_at_m(plate, 6, 4) == 2.0  # 15 of 25
    assert depth_at_m(plate, 7, 4) == 8.0
    assert depth_at_m(plate, 8, 8) == 8.0 == depth_at_m(plate, 0, 0)
    for outside in ((9, 0), (0, 9), (-1, 0), (0, -1)):
        with pytest.raises(InputError, match=r"0,0 to 8,8"):
            depth_at_m(plate, *outside)
    with pytest.raises(InputError, match="circle of confusion"):
        depth_at_m(coc_plate_of(gray_color(9, 9), depth), 4, 4)


def test_area_at_is_relative_to_data_window():
    data, display = Box(-2, -1, 10, 9), Box(0, 0, 8, 8)
    assert area_at(0, 0, data, display) == Box(0, 0, 5, 4)
    assert area_at(3, 3, data, display) == Box(3, 2, 8, 7)
    assert area_at(9, 8, data, display) == Box(9, 7, 12, 10)
    with pytest.raises(InputError, match=r"-2,-1 to 9,8"):
        area_at(10, 0, data, display)


def test_upper_median_m_returns_an_existing_depth():
    inf = np.inf
    for values, middle in (
        ([1, 2, 3], 2), ([1, 2, 3, 4], 3), ([2, inf, inf], inf), ([1, 1, inf, inf], inf),
        ([np.nan, 1, 1], 1),
    ):  # fmt: skip
        assert upper_median_m(np.float32(values)) == middle


# A breathing lens


def plate_with_overscan(width=40, height=20, margin=4):
    data = Box(-margin, -margin, width + margin, height + margin)
    depth = np.full(data.shape, 2.0, np.float32)
    plate = plate_of(gray_color(*data.shape), depth)
    return replace(plate, data_window=data, display_window=Box(0, 0, width, height))


@given(st.integers(0, 39), st.integers(0, 19), st.floats(0.9, 1.1))
def test_plate_pixel_and_picture_point_are_inverse(x, y, breathing):
    plate = plate_with_overscan()
    lens = replace(LENS, breathing=breathing, close_focus_m=0.5, focus_distance_m=0.6)
    pixel = plate_pixel(plate, lens, (x, y))
    point = picture_point(plate, lens, (pixel[0] + 0.5, pixel[1] + 0.5))
    assert point == pytest.approx((x + 0.5, y + 0.5), abs=0.6)
    assert plate_pixel(plate, LENS, (x, y)) == (x, y)
    assert picture_point(plate, LENS, (x, y)) == (x, y)
    assert picture_point(plate, lens, (20.0, 10.0)) == (20.0, 10.0)


def test_frame_centre_px_is_middle_of_display_window():
    assert frame_centre_px(plate_with_overscan()) == (24.0, 14.0)
    assert frame_centre_px(plate_with_overscan(), 0.5) == (12.0, 7.0)


# Deep files


def plate_with_lists():
    """Return three pixels: the first lists two surfaces, the third lists one."""
    depth = np.float32([[1.0, 2.0, 3.0]])
    color = np.float32([[[1, 0, 0], [0, 1, 0], [0, 0, 1]]])
    rgba = np.float32([[1, 0, 0, 1], [0.5, 0.25, 0.125, 1], [0.25, 0.5, 1, 0.5]])
    front = np.array([True, False, False])
    lists = packed_lists(np.int64([2, 0, 1]), front, rgba, np.float32([1, 4, 8]))
    return replace(plate_of(color, depth), fragments=lists)


def test_deep_samples_add_visible_surface_missing_from_list():
    counts, samples = deep_samples(plate_with_lists())
    assert counts.tolist() == [2, 1, 2]
    np.testing.assert_allclose(samples[:, 4], [1, 4, 2, 3, 8], rtol=1e-3)
    np.testing.assert_allclose(samples[:, 3], [1, 1, 1, 1, 0.5], rtol=1e-2)
    np.testing.assert_allclose(samples[1, :3], [0.5, 0.25, 0.125], rtol=1e-2)
    np.testing.assert_array_equal(samples[2, :3], [0, 1, 0])
    np.testing.assert_allclose(samples[4, :3], np.float32([0.25, 0.5, 1]) / 2, rtol=1e-2)


def write_and_read_deep(path, plate, **options):
    write_deep(path, plate, {"owner": "me"}, **options)
    deep_file = OpenEXR.File(str(path), separate_channels=True)
    return deep_file.header(), {
        name: channel.pixels for name, channel in deep_file.channels().items()
    }


def test_write_deep_writes_plate_with_its_types_and_windows(tmp_path):
    plate = plate_of(gray_color(2, 3), np.float32([[1, 2, 3], [4, 5, 6]]))
    counts, samples = deep_samples(plate)
    assert counts.tolist() == [1] * 6
    np.testing.assert_array_equal(samples[:, :4], plate.color.reshape(-1, 4))
    np.testing.assert_array_equal(samples[:, 4], plate.depth_m.ravel())
    header, channels = write_and_read_deep(tmp_path / "d.exr", plate)
    assert header["owner"] == "me" and set(channels) == set("RGBAZ")
    assert channels["Z"][1, 2].tolist() == [6.0] and channels["Z"][0, 0].dtype == np.float32
    assert channels["R"][0, 0].dtype == np.float16
    _, full_channels = write_and_read_deep(tmp_path / "w.exr", plate, half=False)
    assert full_channels["R"][0, 0].dtype == np.float32
    low, high = make_header_window(plate.data_window)
    assert header["dataWindow"][0].tolist() == low.tolist() and high.tolist() == [2, 1]


def test_write_deep_flattens_to_plate_and_reads_back_its_surfaces(tmp_path):
    plate = plate_with_lists()
    write_deep(tmp_path / "d.exr", plate, {}, half=False)
    _, flat = read_flattened_part(tmp_path / "d.exr")
    flat_color = np.stack([flat[name] for name in "RGB"], axis=-1)
    np.testing.assert_allclose(flat_color, plate.color[..., :3], atol=1e-6)
    np.testing.assert_array_equal(flat["Z"], plate.depth_m)
    plate_read = read_deep_plate(tmp_path / "d.exr", PlateOptions())
    assert (
        plate_read.fragments.count >= 2
        and "1.67 surfaces a pixel on average, at most 2" in plate_read.notes[0]
    )


@pytest.mark.parametrize(
    ("wrong", "option"),
    [
        ({"depth_convention": DepthConvention.INVERSE}, "--depth-convention"),
        ({"depth_kind": DepthKind.RADIAL}, "--depth-kind"),
        ({"depth_source": "z.exr"}, "--depth"),
        ({"depth_channel": "Z"}, "--depth-channel"),
        ({"despike": True}, "--despike"),
    ],
)
def test_read_deep_plate_names_options_that_do_not_apply(tmp_path, wrong, option):
    write_deep(tmp_path / "d.exr", plate_with_lists(), {})
    with pytest.raises(InputError, match=f"leave.* {option}") as error:
        read_deep_plate(tmp_path / "d.exr", PlateOptions(**wrong))
    assert "d.exr is a deep file" in str(error.value)
    read_deep_plate(tmp_path / "d.exr", PlateOptions(depth_convention=DepthConvention.DISTANCE))


def test_check_deep_fits_rejects_large_plate_naming_what_fits():
    check_deep_fits("a.exr", 2000, 2000)  # 4 million pixels of 1500 bytes: 6 GB
    with pytest.raises(InputError) as error:
        check_deep_fits("a.exr", 4000, 2000)
    assert "4000x2000" in str(error.value) and "12 GB" in str(error.value)
    assert "2828x1414" in str(error.value)


def test_deep_volume_constants_are_16_slices_of_15_percent():
    assert (_SLICES_MOST, _SLICE) == (16, 0.15)


# Grain


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("noise", [0.01, 0.03, 0.05])
def test_measure_noise_is_relative_to_light(noise, seed):
    """The most even blocks have somewhat less noise than the whole; twice the noise gives twice."""
    grain = np.random.default_rng(seed).standard_normal((120, 120, 1))

    def found(scale, light=0.5):
        color = (light * (1 + scale * noise * grain)).astype(np.float32)
        return measure_noise(np.repeat(color, 3, axis=2))

    assert 0.5 * noise < found(1) < 1.1 * noise
    assert found(2) == pytest.approx(2 * found(1), rel=0.1)
    assert found(1, light=0.05) == pytest.approx(found(1), rel=1e-3)
    assert measure_noise(np.full((120, 120, 3), 0.5, np.float32)) == 0.0


def test_measure_noise_needs_fifty_blocks_of_eight_pixels():
    rng = np.random.default_rng(1)
    color = (0.5 + 0.05 * rng.standard_normal((42, 82, 3))).astype(np.float32)
    assert measure_noise(color) > 0  # 5 x 10 blocks
    assert measure_noise(color[:, :81]) == 0.0 == measure_noise(color[:41])
    color[:8, :8] = 0.0  # one block is dark: 49 are left
    color[:10, :10] = 0.0
    assert measure_noise(color) == 0.0


# Pictures and their limits


def test_check_size_accepts_one_pixel_to_max_side():
    for right in ((1, 1), (MAX_SIDE_PX, 1), (1, MAX_SIDE_PX)):
        check_size("a.png", right)
    for wrong in ((0, 1), (1, 0), (MAX_SIDE_PX + 1, 1), (1, MAX_SIDE_PX + 1)):
        with pytest.raises(InputError, match=f"{wrong[0]} x {wrong[1]}"):
            check_size("a.png", wrong)
    assert _HEAD_BYTES == 4096


def test_depth_file_has_its_own_convention():
    plate_options = PlateOptions(depth_convention=DepthConvention.INVERSE, behind=("a.exr",))
    assert _convention_behind(plate_options, 0) is DepthConvention.INVERSE
    assert (
        _convention_behind(replace(plate_options, depth_source="z.exr"), 0) is DepthConvention.AUTO
    )
    settled = replace(plate_options, behind_conventions=(DepthConvention.DISTANCE,))
    assert _convention_behind(settled, 0) is DepthConvention.DISTANCE


def test_empty_shoot_lens_has_unit_and_no_values():
    empty = ShootLens()
    assert empty.has_unit and empty.sources == {} == empty.unreadable == empty.conflicts
    assert all(getattr(empty, field.name) is None for field in fields(empty)[:5])


def test_short_text_of_header_value_has_at_most_forty_letters():
    assert _shorten_value("a" * 36) == "'" + "a" * 36 + "'"
    shortened = _shorten_value("word " * 20)
    assert 30 < len(shortened) <= 40 and shortened.endswith("[...]")
    assert _shorten_value(2.5) == "2.5" and _shorten_value(np.float32([1, 2.5])) == "1 x 2.5"


# What is said of a plate and its lens


def doubtful_plate():
    return plate_of(gray_color(20, 20), np.full((20, 20), 200.0, np.float32))


def test_lens_notes_doubt_lens_that_does_not_fit_depths():
    plate = doubtful_plate()
    (note,) = lens_notes(plate, LENS, 1.0, is_strict=False)
    assert "200" in note
    with pytest.raises(InputError, match=r"made\.exr"):
        lens_notes(plate, LENS, 1.0, is_strict=True)
    near_plate = plate_of(gray_color(20, 20), np.full((20, 20), 2.0, np.float32))
    assert lens_notes(near_plate, LENS, 1.0, is_strict=True) == ()
    coc_plate = coc_plate_of(gray_color(20, 20), np.ones((20, 20), np.float32))
    assert lens_notes(coc_plate, LENS, 1.0, is_strict=True) == ()


def test_shot_notes_doubt_shot_only_if_every_key_is_doubtful():
    plate, shot = doubtful_plate(), Shot(LENS, frames=FrameRange(1, 9))
    assert len(shot_notes(shot, plate)) == 1
    keyed_shot = shot.with_key(1, LensParameter.FOCUS_DISTANCE, 2.0)
    assert len(shot_notes(keyed_shot, plate)) == 1
    keyed_shot = keyed_shot.with_key(9, LensParameter.FOCUS_DISTANCE, 200.0)
    assert shot_notes(keyed_shot, plate) == ()
    strict = replace(shot, plate_options=PlateOptions(strict=True))
    with pytest.raises(InputError, match=r"made\.exr"):
        shot_notes(strict, plate)
    near_plate = plate_of(gray_color(20, 20), np.full((20, 20), 2.0, np.float32))
    (note,) = shot_notes(shot, near_plate, [2000.0])
    assert "--table-unit focus=mm" in note


def test_depth_note_has_the_range_and_keeps_the_reason_as_detail():
    depth_m = np.linspace(0.4356, 4.6367, 16, dtype=np.float32).reshape(4, 4)
    plate = plate_of(gray_color(4, 4), depth_m)
    plate = replace(plate, depth=replace(plate.depth, why="Its name says so."))
    note = depth_note(plate)
    assert (note, note.why) == ("depth: Z, metres, 0.436 to 4.64", "Its name says so.")
    inverse = replace(plate.depth, convention=DepthConvention.INVERSE, kind=DepthKind.RADIAL)
    inverse = replace(inverse, infinite_count=2)
    words = "depth: Z, 1 / distance along the ray, 0.436 to 4.64 m and infinity"
    assert depth_note(replace(plate, depth=inverse)) == words


def test_breathing_notes_of_plate_use_its_overscan_and_scene_has_none():
    lens, plate = replace(LENS, breathing=0.8, close_focus_m=0.5), plate_with_overscan(margin=1)
    of_plate, of_scene = breathing_notes(lens, plate), breathing_notes(lens, None)
    assert of_plate == (breathing_note(lens, overscan_ratio(plate)),)
    assert of_scene == (breathing_note(lens, None),) != of_plate
    assert breathing_notes(LENS, plate) == () == breathing_notes(LENS, None)
