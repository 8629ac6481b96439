"""Test what neighboring frames add to a frame: a wall behind a card, with known cameras."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from heatlens.core.model.boxes import Box
from heatlens.media.plate.neighbours.found import mean_of_middle_half, with_neighbours
from heatlens.media.plate.neighbours.view import View
from heatlens.media.plate.of_arrays import plate_of_arrays
from heatlens.media.plate.plate import ReadPixels
from support.cards import POST, SIZE, WALL_M, Card, view_of_cards, wall_picture

MOVED_M = 0.25  # sideways from frame to frame: a post at 2 m moves by 8 px against the wall


def frames(*numbers: int, cards=(POST,)) -> list:
    return [view_of_cards(number * MOVED_M, cards, number) for number in numbers]


def first_surface_behind(plate) -> tuple[np.ndarray, np.ndarray]:
    """Return depth and color of the first surface behind each pixel; NaN where there is none."""
    shape = plate.depth_m.shape
    depth, color = np.full(plate.depth_m.size, np.nan), np.full((plate.depth_m.size, 3), np.nan)
    if plate.fragments is not None:
        begins = plate.fragments.begins
        has_list = np.diff(begins) > 0
        depth[has_list] = 1 / plate.fragments.dioptres[begins[:-1][has_list]]
        color[has_list] = plate.fragments.color[begins[:-1][has_list]]
    return depth.reshape(shape), color.reshape(*shape, 3)


def test_with_neighbours_finds_wall_behind_card():
    view = frames(0)[0]
    result = with_neighbours(view, frames(-2, -1, 1, 2))
    depth, color = first_surface_behind(result.plate)
    is_hidden = view.plate.depth_m < 9
    assert np.array_equal(np.isfinite(depth), is_hidden)
    assert np.allclose(depth[is_hidden], WALL_M, rtol=1e-5)
    assert np.allclose(color[is_hidden], wall_picture(0.0)[is_hidden], atol=1e-3)
    assert result.frames == (-2, -1, 1, 2) and not result.left_out
    assert np.array_equal(result.plate.color, view.plate.color)


def test_with_neighbours_finds_nothing_without_camera_motion():
    view = view_of_cards(0.0)
    result = with_neighbours(view, [view_of_cards(0.0, frame=k) for k in (1, 2)])
    assert result.plate.fragments is None and result.hidden_part == 0


def test_with_neighbours_does_not_depend_on_order_of_frames():
    view, (a, b, c) = frames(0)[0], frames(-2, 1, 2)
    plate = with_neighbours(view, [a, b, c]).plate
    reordered_plate = with_neighbours(view, [c, a, b]).plate
    assert np.array_equal(plate.fragments.words, reordered_plate.fragments.words)


def test_with_neighbours_ignores_object_that_moved_by_itself():
    """A ball is between the post and the wall: where it was, another frame sees the wall."""

    def with_ball(number: int):
        ball = Card(4.0, (-0.4 + 0.3 * number, -0.2 + 0.3 * number), (-0.3, 0.3), light=0.1)
        return view_of_cards(number * MOVED_M, (POST, ball), number)

    depth, _ = first_surface_behind(
        with_neighbours(with_ball(0), [with_ball(k) for k in (-2, -1, 1, 2)]).plate
    )
    assert not (np.abs(depth - 4) < 1).any()


def test_with_neighbours_leaves_out_frames_of_another_size():
    result = with_neighbours(frames(0)[0], [*frames(1), view_of_cards(0.2, frame=2, size=(24, 36))])
    assert result.frames == (1,)
    assert result.left_out == ((2, "it is 36x24, this frame 72x48."),)


def with_changed_camera(view, change) -> View:
    """Return the view with its camera's x translation scaled by `change`."""
    world_to_camera = view.world_to_camera.copy()
    world_to_camera[0, 3] *= change
    return replace(view, world_to_camera=world_to_camera)


@pytest.mark.parametrize("change", [-1.0, 0.0, 3.0], ids=["mirrored", "still", "unit"])
def test_with_neighbours_leaves_out_wrong_camera_with_reason(change):
    view, (a, b) = frames(0)[0], frames(1, 2)
    result = with_neighbours(view, [a, with_changed_camera(b, change)])
    assert result.frames == (1,)
    ((frame, reason),) = result.left_out
    assert frame == 2 and "camera" in reason


def test_with_neighbours_leaves_out_another_shot():
    other_view = view_of_cards(0.25, [Card(3.0, (-9, 9), light=0.2)], frame=2)
    result = with_neighbours(frames(0)[0], [other_view, *frames(1)])
    assert result.frames == (1,) and "another shot" in result.left_out[0][1]


def test_with_neighbours_fills_border_outside_frame():
    """The camera moves right, so the right border is seen by other frames; the wall continues."""
    border = 8
    view = frames(0)[0]
    result_plate = with_neighbours(view, frames(2, 4), border).plate
    assert np.array_equal(result_plate.color, view.plate.color)
    assert result_plate.data_window == view.plate.data_window
    plate = result_plate.with_border
    assert plate.data_window == Box(-8, -8, SIZE[1] + 8, SIZE[0] + 8)
    assert plate.display_window == view.plate.display_window
    inner = np.s_[border : border + SIZE[0], border : border + SIZE[1]]
    assert np.array_equal(plate.color[inner], view.plate.color)
    wide = view_of_cards(0.0, size=(SIZE[0], SIZE[1] + 2 * border)).plate
    right = np.s_[:, SIZE[1] + border :]
    assert np.array_equal(plate.depth_m[border:-border][right], wide.depth_m[right])
    assert np.allclose(plate.color[border:-border][right], wide.color[right], atol=0.002)
    assert np.array_equal(plate.color[border:-border, 0], view.plate.color[:, 0])


def test_with_neighbours_has_no_border_that_no_frame_saw():
    view = view_of_cards(0.0)
    assert with_neighbours(view, [view_of_cards(0.0, frame=1)], 8).plate.with_border is None


@given(
    st.lists(st.tuples(st.floats(1.5, 8), st.floats(-0.6, 0.4), st.floats(-0.4, 0.2)), max_size=3),
    st.floats(0.05, 0.3),
)
@settings(max_examples=12, deadline=None)
def test_with_neighbours_treats_rows_and_columns_alike(places, metres):
    cards = [Card(z, (x, x + 0.3), (y, y + 0.5), light=z / 10) for z, x, y in places]
    views = [view_of_cards(metres * k, cards, k) for k in (0, -1, 1)]
    upright = with_neighbours(views[0], views[1:], 4)
    lying = with_neighbours(transposed(views[0]), [transposed(it) for it in views[1:]], 4)
    assert lying.frames == upright.frames
    assert abs(lying.hidden_part - upright.hidden_part) < 0.02
    shape = upright.plate.depth_m.shape
    (depth, color), (its_depth, its_color) = (
        first_surface_behind(it.plate) for it in (upright, lying)
    )
    assert np.allclose(its_depth.T, depth, rtol=1e-4, equal_nan=True) and depth.shape == shape
    assert np.allclose(its_color.swapaxes(0, 1), color, atol=2e-3, equal_nan=True)


def transposed(view: View) -> View:
    """Return the view with rows and columns swapped."""
    plate, (fx, fy), (cx, cy) = view.plate, view.focal_px, view.centre_px
    swap = np.array([[0, -1, 0, 0], [-1, 0, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1.0]])
    swapped_plate = plate_of_arrays(plate.color.swapaxes(0, 1).copy(), plate.depth_m.T.copy())
    return View(view.frame, swapped_plate, swap @ view.world_to_camera, (fy, fx), (cy, cx))


def test_with_neighbours_fades_point_seen_only_by_distant_frame():
    """Only one frame sees the wall behind the post: the farther that frame, the less it counts."""
    near_view, far_view = view_of_cards(0.0, frame=1), view_of_cards(0.6, frame=9)
    alphas = []
    for reach in (9, 10, 30):
        others = [near_view, far_view, view_of_cards(0.0, frame=-reach)]
        lists = with_neighbours(view_of_cards(0.0), others).plate.fragments
        alphas.append(float(lists.coverage.max()))
    assert alphas[0] == pytest.approx(0.4, abs=0.01)
    assert alphas[0] < alphas[1] < alphas[2] == 1


@given(st.lists(st.tuples(st.floats(0, 5), st.floats(0.1, 1)), min_size=1, max_size=6))
def test_mean_of_middle_half_ignores_outliers_and_tiny_weights(samples):
    light, weights = np.array(samples, np.float32).T[:, :, None]  # each (samples, 1)
    colors = np.repeat(light[..., None], 4, 2)
    middle = mean_of_middle_half(colors, weights)[0, 0]
    assert light.min() - 1e-4 <= middle <= light.max() + 1e-4
    with_outlier = np.concatenate([colors, np.full((1, 1, 4), 1e4, np.float32)])
    # A fifth of all weight is less than the brightest quarter, which is left out.
    fifth = np.concatenate([weights, weights.sum(0, keepdims=True) / 4])
    assert mean_of_middle_half(with_outlier, fifth)[0, 0] <= light.max() + 1e-3
    tiny = np.concatenate([weights, np.full((1, 1), 1e-6, np.float32)])
    mean = mean_of_middle_half(with_outlier, tiny)[0, 0]
    assert mean == pytest.approx(middle, rel=1e-3, abs=1e-3)


def test_with_neighbours_finds_sky_behind_card():
    view, *others = (with_sky(it) for it in frames(0, -1, 1))
    with np.errstate(divide="ignore"):
        depth, color = first_surface_behind(with_neighbours(view, others).plate)
    assert np.isinf(depth[view.plate.depth_m < 9]).all()
    assert np.allclose(color[view.plate.depth_m < 9], 1.0, atol=1e-3)


def with_sky(view: View) -> View:
    """Return the view with an endless sky for its wall."""
    depth = np.where(view.plate.depth_m > 9, np.float32(np.inf), view.plate.depth_m)
    color = np.where(np.isinf(depth)[..., None], np.float32(1.0), view.plate.color)
    return replace(view, plate=replace(view.plate, pixels=ReadPixels(color, depth)))


def test_with_neighbours_finds_border_around_sky():
    cards = (POST, Card(3.0, (1.2, 1.5)), Card(3.0, (-1.5, -1.2)))
    view, *others = (with_sky(it) for it in frames(0, -1, 1, cards=cards))
    border_plate = with_neighbours(view, others, 8).plate.with_border
    assert np.array_equal(border_plate.depth_m[8:-8, 8:-8], view.plate.depth_m)
    assert (border_plate.depth_m[8:-8, -8:] == 3).any()  # a card at the edge of the frame


def test_with_neighbours_places_overscan_frames_by_their_windows():
    view = frames(0)[0]
    narrow = with_neighbours(view, frames(-1, 1), 8).plate.with_border
    wide = with_neighbours(view, [with_overscan(k) for k in (-1, 1)], 8).plate.with_border
    (depth, color), (its_depth, its_color) = (
        first_surface_behind(narrow),
        first_surface_behind(wide),
    )
    are_finite = np.isfinite(depth) & np.isfinite(its_depth)
    assert are_finite.sum() > 500
    assert np.allclose(depth[are_finite], its_depth[are_finite]) and np.allclose(
        color[are_finite], its_color[are_finite]
    )
    truth = view_of_cards(0.0, size=(SIZE[0], SIZE[1] + 16)).plate
    assert np.allclose(wide.color[8:-8], truth.color, atol=2e-3)


def with_overscan(number: int) -> View:
    """Return a frame with eight more pixels on the left and on the right."""
    view = view_of_cards(number * MOVED_M, frame=number, size=(SIZE[0], SIZE[1] + 16))
    data, shown = Box(-8, 0, SIZE[1] + 8, SIZE[0]), Box(0, 0, SIZE[1], SIZE[0])
    plate = replace(view.plate, data_window=data, display_window=shown)
    return replace(view, plate=plate, centre_px=(SIZE[1] / 2, SIZE[0] / 2))


def test_with_neighbours_ignores_walker_who_continues_behind_post():
    """A walker at 4 m comes out from behind the post; neighboring frames show the wall."""

    def with_walker(number: int):
        walker = Card(4.0, (-0.2 + 0.9 * number, 0.5 + 0.9 * number), light=0.1)
        return view_of_cards(number * MOVED_M, (POST, walker), number)

    view, others = with_walker(0), [with_walker(k) for k in (-2, -1, 1, 2)]
    depth, _ = first_surface_behind(with_neighbours(view, others).plate)
    is_post = view.plate.depth_m == 2
    next_to_walker = is_post & np.roll(view.plate.depth_m == 4, -1, 1)
    assert next_to_walker.any() and not (depth[next_to_walker] > 9).any()
    assert (depth[is_post] > 9).any() or not np.isfinite(depth[is_post]).any()
