"""What neighbouring frames know of a frame: a wall behind a card, with cameras that are known."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from heatlens.core.model.boxes import Box
from heatlens.media.plate.neighbours.found import middle_half, with_neighbours
from heatlens.media.plate.neighbours.view import View
from heatlens.media.plate.of_arrays import plate_of_arrays
from heatlens.media.plate.plate import ReadPixels
from support.cards import POST, SIZE, WALL_M, Card, seen, wall_seen

MOVED_M = 0.25  # sideways from frame to frame: a post at 2 m moves by 8 px against the wall


def frames(*numbers: int, cards=(POST,)) -> list:
    return [seen(number * MOVED_M, cards, number) for number in numbers]


def behind(plate) -> tuple[np.ndarray, np.ndarray]:
    """Return depth and colour of the first surface behind each pixel; NaN where there is none."""
    shape = plate.depth_m.shape
    depth, color = np.full(plate.depth_m.size, np.nan), np.full((plate.depth_m.size, 3), np.nan)
    if plate.fragments is not None:
        starts = (plate.fragments.starts >> 1).astype(int)
        has = np.diff(starts) > 0
        depth[has] = 1 / plate.fragments.dioptres[starts[:-1][has]]
        color[has] = plate.fragments.color[starts[:-1][has]]
    return depth.reshape(shape), color.reshape(*shape, 3)


def test_a_wall_behind_a_card_is_found_as_it_is():
    here = frames(0)[0]
    found = with_neighbours(here, frames(-2, -1, 1, 2))
    depth, color = behind(found.plate)
    is_hidden = here.plate.depth_m < 9
    assert np.array_equal(np.isfinite(depth), is_hidden)
    assert np.allclose(depth[is_hidden], WALL_M, rtol=1e-5)
    assert np.allclose(color[is_hidden], wall_seen(0.0)[is_hidden], atol=1e-3)
    assert found.frames == (-2, -1, 1, 2) and not found.left_out
    assert np.array_equal(found.plate.color, here.plate.color)


def test_nothing_is_found_where_nothing_moves():
    here = seen(0.0)
    found = with_neighbours(here, [seen(0.0, frame=k) for k in (1, 2)])
    assert found.plate.fragments is None and found.hidden_part == 0


def test_the_order_of_the_neighbours_does_not_matter():
    here, (a, b, c) = frames(0)[0], frames(-2, 1, 2)
    one, other = with_neighbours(here, [a, b, c]).plate, with_neighbours(here, [c, a, b]).plate
    assert np.array_equal(one.fragments.words, other.fragments.words)


def test_what_moved_by_itself_is_not_taken():
    """A ball between the post and the wall: where it was, another frame sees the wall."""

    def with_ball(number: int):
        ball = Card(4.0, (-0.4 + 0.3 * number, -0.2 + 0.3 * number), (-0.3, 0.3), light=0.1)
        return seen(number * MOVED_M, (POST, ball), number)

    depth, _ = behind(with_neighbours(with_ball(0), [with_ball(k) for k in (-2, -1, 1, 2)]).plate)
    assert not (np.abs(depth - 4) < 1).any()


def test_frames_of_another_size_are_left_out():
    found = with_neighbours(frames(0)[0], [*frames(1), seen(0.2, frame=2, size=(24, 36))])
    assert found.frames == (1,)
    assert found.left_out == ((2, "it is 36x24, this frame 72x48."),)


def with_move(view, change) -> View:
    """Return the view with another camera: `change` scales its place along x."""
    move = view.world_to_camera.copy()
    move[0, 3] *= change
    return replace(view, world_to_camera=move)


@pytest.mark.parametrize("change", [-1.0, 0.0, 3.0], ids=["mirrored", "still", "unit"])
def test_a_wrong_camera_is_left_out_with_a_reason(change):
    here, (a, b) = frames(0)[0], frames(1, 2)
    found = with_neighbours(here, [a, with_move(b, change)])
    assert found.frames == (1,)
    ((frame, reason),) = found.left_out
    assert frame == 2 and "camera" in reason


def test_another_shot_is_left_out():
    other = seen(0.25, [Card(3.0, (-9, 9), light=0.2)], frame=2)
    found = with_neighbours(frames(0)[0], [other, *frames(1)])
    assert found.frames == (1,) and "another shot" in found.left_out[0][1]


def test_what_lies_outside_the_frame_is_found():
    """The camera goes to the right, so that the right border is known, and the wall goes on."""
    border = 8
    here = frames(0)[0]
    found = with_neighbours(here, frames(2, 4), border).plate
    assert np.array_equal(found.color, here.plate.color)
    assert found.data_window == here.plate.data_window
    plate = found.beyond
    assert plate.data_window == Box(-8, -8, SIZE[1] + 8, SIZE[0] + 8)
    assert plate.display_window == here.plate.display_window
    inner = np.s_[border : border + SIZE[0], border : border + SIZE[1]]
    assert np.array_equal(plate.color[inner], here.plate.color)
    wide = seen(0.0, size=(SIZE[0], SIZE[1] + 2 * border)).plate
    right = np.s_[:, SIZE[1] + border :]
    assert np.array_equal(plate.depth_m[border:-border][right], wide.depth_m[right])
    assert np.allclose(plate.color[border:-border][right], wide.color[right], atol=0.002)
    assert np.array_equal(plate.color[border:-border, 0], here.plate.color[:, 0])


def test_a_border_that_nobody_saw_leaves_the_plate_as_it_is():
    here = seen(0.0)
    assert with_neighbours(here, [seen(0.0, frame=1)], 8).plate.beyond is None


@given(
    st.lists(st.tuples(st.floats(1.5, 8), st.floats(-0.6, 0.4), st.floats(-0.4, 0.2)), max_size=3),
    st.floats(0.05, 0.3),
)
@settings(max_examples=12, deadline=None)
def test_rows_and_columns_are_alike(places, metres):
    cards = [Card(z, (x, x + 0.3), (y, y + 0.5), light=z / 10) for z, x, y in places]
    views = [seen(metres * k, cards, k) for k in (0, -1, 1)]
    upright = with_neighbours(views[0], views[1:], 4)
    lying = with_neighbours(transposed(views[0]), [transposed(it) for it in views[1:]], 4)
    assert lying.frames == upright.frames
    assert abs(lying.hidden_part - upright.hidden_part) < 0.02
    shape = upright.plate.depth_m.shape
    (depth, color), (its_depth, its_color) = (behind(it.plate) for it in (upright, lying))
    assert np.allclose(its_depth.T, depth, rtol=1e-4, equal_nan=True) and depth.shape == shape
    assert np.allclose(its_color.swapaxes(0, 1), color, atol=2e-3, equal_nan=True)


def transposed(view: View) -> View:
    """Return the view with rows for columns."""
    plate, (fx, fy), (cx, cy) = view.plate, view.focal_px, view.centre_px
    swap = np.array([[0, -1, 0, 0], [-1, 0, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1.0]])
    turned = plate_of_arrays(plate.color.swapaxes(0, 1).copy(), plate.depth_m.T.copy())
    return View(view.frame, turned, swap @ view.world_to_camera, (fy, fx), (cy, cx))


def test_a_point_fades_as_the_only_frame_that_saw_it_leaves():
    """One frame sees the wall behind the post: the farther it is, the less it counts."""
    beside, far = seen(0.0, frame=1), seen(0.6, frame=9)
    alphas = []
    for reach in (9, 10, 30):
        others = [beside, far, seen(0.0, frame=-reach)]
        lists = with_neighbours(seen(0.0), others).plate.fragments
        alphas.append(float(lists.coverage.max()))
    assert alphas[0] == pytest.approx(0.4, abs=0.01)
    assert alphas[0] < alphas[1] < alphas[2] == 1


@given(st.lists(st.tuples(st.floats(0, 5), st.floats(0.1, 1)), min_size=1, max_size=6))
def test_the_middle_half_is_free_of_outliers_and_of_what_weighs_nothing(samples):
    light, weights = np.array(samples, np.float32).T[:, :, None]
    colors = np.repeat(light[..., None], 4, 2)
    middle = middle_half(colors, weights)[0, 0]
    assert light.min() - 1e-4 <= middle <= light.max() + 1e-4
    more = np.concatenate([colors, np.full((1, 1, 4), 1e4, np.float32)])
    outlier = np.concatenate([weights, weights.sum(0, keepdims=True) / 4])
    assert middle_half(more, outlier)[0, 0] <= light.max() + 1e-3
    nothing = np.concatenate([weights, np.full((1, 1), 1e-6, np.float32)])
    assert middle_half(more, nothing)[0, 0] == pytest.approx(middle, rel=1e-3, abs=1e-3)


def test_the_sky_behind_a_card_is_found_at_infinity():
    here, *others = (with_sky(it) for it in frames(0, -1, 1))
    with np.errstate(divide="ignore"):
        depth, color = behind(with_neighbours(here, others).plate)
    assert np.isinf(depth[here.plate.depth_m < 9]).all()
    assert np.allclose(color[here.plate.depth_m < 9], 1.0, atol=1e-3)


def with_sky(view: View) -> View:
    """Return the view with an endless sky for its wall."""
    depth = np.where(view.plate.depth_m > 9, np.float32(np.inf), view.plate.depth_m)
    color = np.where(np.isinf(depth)[..., None], np.float32(1.0), view.plate.color)
    return replace(view, plate=replace(view.plate, pixels=ReadPixels(color, depth)))


def test_a_border_is_found_around_a_sky():
    cards = (POST, Card(3.0, (1.2, 1.5)), Card(3.0, (-1.5, -1.2)))
    here, *others = (with_sky(it) for it in frames(0, -1, 1, cards=cards))
    wide = with_neighbours(here, others, 8).plate.beyond
    assert np.array_equal(wide.depth_m[8:-8, 8:-8], here.plate.depth_m)
    assert (wide.depth_m[8:-8, -8:] == 3).any()  # a card at the edge of the frame


def test_frames_with_overscan_are_placed_by_their_windows():
    here = frames(0)[0]
    narrow = with_neighbours(here, frames(-1, 1), 8).plate.beyond
    wide = with_neighbours(here, [with_overscan(k) for k in (-1, 1)], 8).plate.beyond
    (depth, color), (its_depth, its_color) = behind(narrow), behind(wide)
    both = np.isfinite(depth) & np.isfinite(its_depth)
    assert both.sum() > 500
    assert np.allclose(depth[both], its_depth[both]) and np.allclose(color[both], its_color[both])
    truth = seen(0.0, size=(SIZE[0], SIZE[1] + 16)).plate
    assert np.allclose(wide.color[8:-8], truth.color, atol=2e-3)


def with_overscan(number: int) -> View:
    """Return a frame with eight more pixels on the left and on the right."""
    view = seen(number * MOVED_M, frame=number, size=(SIZE[0], SIZE[1] + 16))
    data, shown = Box(-8, 0, SIZE[1] + 8, SIZE[0]), Box(0, 0, SIZE[1], SIZE[0])
    plate = replace(view.plate, data_window=data, display_window=shown)
    return replace(view, plate=plate, centre_px=(SIZE[1] / 2, SIZE[0] / 2))


def test_what_moves_and_goes_on_behind_a_post_is_not_taken_for_the_wall():
    """A walker at 4 m comes out from behind the post: the frames around show the wall there."""

    def with_walker(number: int):
        walker = Card(4.0, (-0.2 + 0.9 * number, 0.5 + 0.9 * number), light=0.1)
        return seen(number * MOVED_M, (POST, walker), number)

    here, others = with_walker(0), [with_walker(k) for k in (-2, -1, 1, 2)]
    depth, _ = behind(with_neighbours(here, others).plate)
    is_post = here.plate.depth_m == 2
    beside = is_post & np.roll(here.plate.depth_m == 4, -1, 1)
    assert beside.any() and not (depth[beside] > 9).any()
    assert (depth[is_post] > 9).any() or not np.isfinite(depth[is_post]).any()
