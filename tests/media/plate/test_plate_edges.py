"""Edges and documented numbers of reading and writing plates, spelt out."""

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
from heatlens.media.plate.behind import _convention
from heatlens.media.plate.coc_line import area_at, depth_at_m, middle_m
from heatlens.media.plate.deep.deep_plate import flattened_part, read_deep_plate
from heatlens.media.plate.deep.deep_write import check_deep_fits, deep_samples, write_deep
from heatlens.media.plate.deep.fragment_merge import _SLICE, _SLICES_MOST
from heatlens.media.plate.grain import noise_of
from heatlens.media.plate.header.camera_header import _short
from heatlens.media.plate.header.shoot_names import ShootLens
from heatlens.media.plate.of_arrays import plate_of_arrays
from heatlens.media.plate.overscan_need import frame_centre_px, picture_point, plate_pixel, room_of
from heatlens.media.plate.picture.picture_open import _HEAD_BYTES, MAX_SIDE_PX, _check_size
from heatlens.media.plate.plate_notes import breathing_notes, depth_note, lens_notes, shot_notes
from heatlens.media.plate.windows import header_at_box
from support.fragment_lists import packed_lists
from support.plates import coc_plate_of, plate_of

LENS = Lens(50.0, 2.0, 2.0, 36.0)


def grey(height, width):
    return np.full((height, width, 3), 0.5, np.float32)


def test_an_array_is_reported_as_what_it_holds():
    metres = plate_of_arrays(grey(2, 3), depth_m=np.full((2, 3), 4.0))
    pixels = plate_of_arrays(grey(2, 3), coc_px=np.full((2, 3), -4.0))
    assert metres.depth.convention is DepthConvention.DISTANCE and metres.depth.near_m == 4.0
    assert pixels.depth.convention is DepthConvention.COC and not pixels.has_distances


# Focus by a click


def test_a_click_takes_the_median_of_five_by_five():
    depth = np.full((9, 9), 8.0, np.float32)
    depth[2:7, 2:7] = 2.0
    depth[4, 4] = 99.0  # a noisy pixel
    plate = plate_of(grey(9, 9), depth)
    assert depth_at_m(plate, 4, 4) == 2.0
    assert depth_at_m(plate, 6, 4) == 2.0  # 15 of 25
    assert depth_at_m(plate, 7, 4) == 8.0
    assert depth_at_m(plate, 8, 8) == 8.0 == depth_at_m(plate, 0, 0)
    for outside in ((9, 0), (0, 9), (-1, 0), (0, -1)):
        with pytest.raises(InputError, match=r"0,0 to 8,8"):
            depth_at_m(plate, *outside)
    with pytest.raises(InputError, match="circle of confusion"):
        depth_at_m(coc_plate_of(grey(9, 9), depth), 4, 4)


def test_the_area_of_a_click_counts_from_the_data_window():
    data, display = Box(-2, -1, 10, 9), Box(0, 0, 8, 8)
    assert area_at(0, 0, data, display) == Box(0, 0, 5, 4)
    assert area_at(3, 3, data, display) == Box(3, 2, 8, 7)
    assert area_at(9, 8, data, display) == Box(9, 7, 12, 10)
    with pytest.raises(InputError, match=r"-2,-1 to 9,8"):
        area_at(10, 0, data, display)


def test_the_median_is_a_depth_that_is_there():
    inf = np.inf
    for values, middle in (
        ([1, 2, 3], 2), ([1, 2, 3, 4], 3), ([2, inf, inf], inf), ([1, 1, inf, inf], inf),
        ([np.nan, 1, 1], 1),
    ):  # fmt: skip
        assert middle_m(np.float32(values)) == middle


# A breathing lens


def breathing_plate(width=40, height=20, margin=4):
    data = Box(-margin, -margin, width + margin, height + margin)
    depth = np.full(data.shape, 2.0, np.float32)
    plate = plate_of(grey(*data.shape), depth)
    return replace(plate, data_window=data, display_window=Box(0, 0, width, height))


@given(st.integers(0, 39), st.integers(0, 19), st.floats(0.9, 1.1))
def test_a_pixel_of_the_picture_and_its_place_in_the_plate_belong_together(x, y, breathing):
    plate = breathing_plate()
    lens = replace(LENS, breathing=breathing, close_focus_m=0.5, focus_distance_m=0.6)
    seen = plate_pixel(plate, lens, (x, y))
    back = picture_point(plate, lens, (seen[0] + 0.5, seen[1] + 0.5))
    assert back == pytest.approx((x + 0.5, y + 0.5), abs=0.6)
    assert plate_pixel(plate, LENS, (x, y)) == (x, y)
    assert picture_point(plate, LENS, (x, y)) == (x, y)
    assert picture_point(plate, lens, (20.0, 10.0)) == (20.0, 10.0)


def test_the_frame_lies_in_the_middle_of_its_window():
    assert frame_centre_px(breathing_plate()) == (24.0, 14.0)
    assert frame_centre_px(breathing_plate(), 0.5) == (12.0, 7.0)


# Deep files


def listed_plate():
    """Return three pixels; the first lists its visible surface and one behind, the last one."""
    depth = np.float32([[1.0, 2.0, 3.0]])
    color = np.float32([[[1, 0, 0], [0, 1, 0], [0, 0, 1]]])
    rgba = np.float32([[1, 0, 0, 1], [0.5, 0.25, 0.125, 1], [0.25, 0.5, 1, 0.5]])
    front = np.array([True, False, False])
    lists = packed_lists(np.int64([2, 0, 1]), front, rgba, np.float32([1, 4, 8]))
    return replace(plate_of(color, depth), fragments=lists)


def test_the_visible_surface_is_added_where_the_list_does_not_begin_with_it():
    counts, samples = deep_samples(listed_plate())
    assert counts.tolist() == [2, 1, 2]
    np.testing.assert_allclose(samples[:, 4], [1, 4, 2, 3, 8], rtol=1e-3)
    np.testing.assert_allclose(samples[:, 3], [1, 1, 1, 1, 0.5], rtol=1e-2)
    np.testing.assert_allclose(samples[1, :3], [0.5, 0.25, 0.125], rtol=1e-2)
    np.testing.assert_array_equal(samples[2, :3], [0, 1, 0])
    np.testing.assert_allclose(samples[4, :3], np.float32([0.25, 0.5, 1]) / 2, rtol=1e-2)


def written(path, plate, **more):
    write_deep(path, plate, {"owner": "me"}, **more)
    found = OpenEXR.File(str(path), separate_channels=True)
    return found.header(), {name: one.pixels for name, one in found.channels().items()}


def test_a_deep_file_has_the_plate_and_what_is_behind_it(tmp_path):
    plate = plate_of(grey(2, 3), np.float32([[1, 2, 3], [4, 5, 6]]))
    counts, samples = deep_samples(plate)
    assert counts.tolist() == [1] * 6
    np.testing.assert_array_equal(samples[:, :4], plate.color.reshape(-1, 4))
    np.testing.assert_array_equal(samples[:, 4], plate.depth_m.ravel())
    header, channels = written(tmp_path / "d.exr", plate)
    assert header["owner"] == "me" and set(channels) == set("RGBAZ")
    assert channels["Z"][1, 2].tolist() == [6.0] and channels["Z"][0, 0].dtype == np.float32
    assert channels["R"][0, 0].dtype == np.float16
    _, whole = written(tmp_path / "w.exr", plate, half=False)
    assert whole["R"][0, 0].dtype == np.float32
    low, high = header_at_box(plate.data_window)
    assert header["dataWindow"][0].tolist() == low.tolist() and high.tolist() == [2, 1]


def test_a_deep_file_is_flattened_to_what_is_seen_and_reads_back_with_its_surfaces(tmp_path):
    plate = listed_plate()
    write_deep(tmp_path / "d.exr", plate, {}, half=False)
    _, flat = flattened_part(tmp_path / "d.exr")
    seen = np.stack([flat[name] for name in "RGB"], axis=-1)
    np.testing.assert_allclose(seen, plate.color[..., :3], atol=1e-6)
    np.testing.assert_array_equal(flat["Z"], plate.depth_m)
    back = read_deep_plate(tmp_path / "d.exr", PlateOptions())
    assert (
        back.fragments.count >= 2 and "1.67 surfaces a pixel on average, at most 2" in back.notes[0]
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
def test_options_that_do_not_apply_to_a_deep_file_are_named(tmp_path, wrong, option):
    write_deep(tmp_path / "d.exr", listed_plate(), {})
    with pytest.raises(InputError, match=f"leave.* {option}") as error:
        read_deep_plate(tmp_path / "d.exr", PlateOptions(**wrong))
    assert "d.exr is a deep file" in str(error.value)
    read_deep_plate(tmp_path / "d.exr", PlateOptions(depth_convention=DepthConvention.DISTANCE))


def test_what_takes_too_much_memory_to_write_is_refused_with_what_fits():
    check_deep_fits("a.exr", 2000, 2000)  # 4 million pixels of 1500 bytes: 6 GB
    with pytest.raises(InputError) as error:
        check_deep_fits("a.exr", 4000, 2000)
    assert "4000x2000" in str(error.value) and "12 GB" in str(error.value)
    assert "2828x1414" in str(error.value)


def test_volumes_are_cut_into_at_most_sixteen_slices():
    assert (_SLICES_MOST, _SLICE) == (16, 0.15)


# Grain


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("noise", [0.01, 0.03, 0.05])
def test_noise_is_measured_relative_to_the_light(noise, seed):
    """The evenest blocks have somewhat less than the whole; twice the noise is twice as much."""
    grain = np.random.default_rng(seed).standard_normal((120, 120, 1))

    def found(scale, light=0.5):
        color = (light * (1 + scale * noise * grain)).astype(np.float32)
        return noise_of(np.repeat(color, 3, axis=2))

    assert 0.5 * noise < found(1) < 1.1 * noise
    assert found(2) == pytest.approx(2 * found(1), rel=0.1)
    assert found(1, light=0.05) == pytest.approx(found(1), rel=1e-3)
    assert noise_of(np.full((120, 120, 3), 0.5, np.float32)) == 0.0


def test_fifty_blocks_of_eight_pixels_are_the_least_that_tell_noise():
    rng = np.random.default_rng(1)
    color = (0.5 + 0.05 * rng.standard_normal((42, 82, 3))).astype(np.float32)
    assert noise_of(color) > 0  # 5 x 10 blocks
    assert noise_of(color[:, :81]) == 0.0 == noise_of(color[:41])
    color[:8, :8] = 0.0  # one block is dark: 49 are left
    color[:10, :10] = 0.0
    assert noise_of(color) == 0.0


# Pictures and their limits


def test_a_picture_has_from_one_pixel_to_the_most():
    for right in ((1, 1), (MAX_SIDE_PX, 1), (1, MAX_SIDE_PX)):
        _check_size("a.png", right)
    for wrong in ((0, 1), (1, 0), (MAX_SIDE_PX + 1, 1), (1, MAX_SIDE_PX + 1)):
        with pytest.raises(InputError, match=f"{wrong[0]} x {wrong[1]}"):
            _check_size("a.png", wrong)
    assert _HEAD_BYTES == 4096


def test_a_depth_file_has_a_convention_of_its_own():
    given = PlateOptions(depth_convention=DepthConvention.INVERSE, behind=("a.exr",))
    assert _convention(given, 0) is DepthConvention.INVERSE
    assert _convention(replace(given, depth_source="z.exr"), 0) is DepthConvention.AUTO
    told = replace(given, behind_conventions=(DepthConvention.DISTANCE,))
    assert _convention(told, 0) is DepthConvention.DISTANCE


def test_a_lens_of_a_shoot_has_units_until_a_file_lacks_them():
    empty = ShootLens()
    assert empty.has_unit and empty.sources == {} == empty.unreadable == empty.conflicts
    assert all(getattr(empty, one.name) is None for one in fields(empty)[:5])


def test_a_value_of_a_header_is_told_in_forty_letters():
    assert _short("a" * 36) == "'" + "a" * 36 + "'"
    told = _short("word " * 20)
    assert 30 < len(told) <= 40 and told.endswith("[...]")
    assert _short(2.5) == "2.5" and _short(np.float32([1, 2.5])) == "1 x 2.5"


# What is said of a plate and its lens


def doubtful_plate():
    return plate_of(grey(20, 20), np.full((20, 20), 200.0, np.float32))


def test_a_lens_that_does_not_fit_the_depths_is_doubted_and_refused_where_strict():
    plate = doubtful_plate()
    (said,) = lens_notes(plate, LENS, 1.0, is_strict=False)
    assert "200" in said
    with pytest.raises(InputError, match=r"made\.exr"):
        lens_notes(plate, LENS, 1.0, is_strict=True)
    near = plate_of(grey(20, 20), np.full((20, 20), 2.0, np.float32))
    assert lens_notes(near, LENS, 1.0, is_strict=True) == ()
    blurred = coc_plate_of(grey(20, 20), np.ones((20, 20), np.float32))
    assert lens_notes(blurred, LENS, 1.0, is_strict=True) == ()


def test_a_shot_is_doubted_only_where_every_key_is():
    plate, shot = doubtful_plate(), Shot(LENS, frames=FrameRange(1, 9))
    assert len(shot_notes(shot, plate)) == 1
    pulled = shot.with_key(1, LensParameter.FOCUS_DISTANCE, 2.0)
    assert len(shot_notes(pulled, plate)) == 1
    pulled = pulled.with_key(9, LensParameter.FOCUS_DISTANCE, 200.0)
    assert shot_notes(pulled, plate) == ()
    strict = replace(shot, plate_options=PlateOptions(strict=True))
    with pytest.raises(InputError, match=r"made\.exr"):
        shot_notes(strict, plate)
    near = plate_of(grey(20, 20), np.full((20, 20), 2.0, np.float32))
    (said,) = shot_notes(shot, near, [2000.0])
    assert "--table-unit focus=mm" in said


def test_the_depth_is_told_with_its_reason_once():
    plate = plate_of(grey(4, 4), np.full((4, 4), 2.0, np.float32))
    plate = replace(plate, depth=replace(plate.depth, why="Its name says so."))
    assert depth_note(plate) == "depth: Z taken as distance, planar. Its name says so."
    noted = replace(plate, notes=("Z is a distance. Its name says so.",))
    assert depth_note(noted) == "depth: Z taken as distance, planar."


def test_the_note_on_breathing_knows_the_room_around_a_plate_and_that_a_scene_has_all():
    lens, plate = replace(LENS, breathing=0.8, close_focus_m=0.5), breathing_plate(margin=1)
    of_plate, of_scene = breathing_notes(lens, plate), breathing_notes(lens, None)
    assert of_plate == (breathing_note(lens, room_of(plate)),)
    assert of_scene == (breathing_note(lens, None),) != of_plate
    assert breathing_notes(LENS, plate) == () == breathing_notes(LENS, None)
