"""What neighbouring frames know of a frame: a wall behind a card, with cameras that are known."""

import numpy as np

from heatlens.plate.neighbours.found import with_neighbours
from support.cards import POST, SIZE, WALL_M, Card, seen, wall_seen

MOVED_M = 0.25  # sideways from frame to frame: a post at 2 m moves by 8 px against the wall


def frames(*numbers: int, cards=(POST,)) -> list:
    return [seen(number * MOVED_M, cards, number) for number in numbers]


def behind(plate) -> tuple[np.ndarray, np.ndarray]:
    """Return depth and colour of the first surface behind each pixel; NaN where there is none."""
    depth, color = np.full(SIZE[0] * SIZE[1], np.nan), np.full((SIZE[0] * SIZE[1], 3), np.nan)
    if plate.fragments is not None:
        starts = (plate.fragments.starts >> 1).astype(int)
        has = np.diff(starts) > 0
        depth[has] = 1 / plate.fragments.dioptres[starts[:-1][has]]
        color[has] = plate.fragments.color[starts[:-1][has]]
    return depth.reshape(SIZE), color.reshape(*SIZE, 3)


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
