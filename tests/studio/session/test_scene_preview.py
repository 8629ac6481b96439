"""How large a scene is drawn while it moves, on a clock of the test's own."""

from collections.abc import Iterator
from dataclasses import dataclass, field, replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.framing import Framing, Pose
from heatlens.core.model.shot.shot import Shot
from heatlens.render.scene_gpu.pinhole_draw import PINHOLE_VIEWS
from heatlens.studio.session.opened.scene_preview import MOST_S, ScenePreview

SIZE = (640, 360)
REST_S, SLICE_S = 0.08, 0.012
SHOT = Shot(Lens(35.0, 2.0, 3.0, 36.0), framing=Framing(*SIZE))


@dataclass
class Machine:
    """A renderer that draws at a price, and nothing where the picture is there already."""

    per_px_s: float
    now: float = 100.0
    drawn: list[tuple[int, int, int]] = field(default_factory=list)  # width, height, views
    key: object = None
    views: int = 0
    loaded: object = None
    share: float = 1.0  # of a view that a step draws

    def pace(self, share: float) -> None:
        self.share = share

    def settle(self) -> None:
        """Do nothing: what was asked for is drawn at once."""

    def look(self, shot: Shot, frame: int, views: int) -> object:
        list(self.looking(shot, frame, views))
        return self.loaded

    def looking(self, shot: Shot, frame: int, views: int) -> Iterator[str]:
        framing = shot.framing
        assert framing is not None
        is_same = (framing, frame) == self.key
        if is_same and self.views >= views:
            return
        for _ in range(views - self.views if is_same else views):
            left = 1.0
            while left > 0:
                part = min(self.share, left)
                self.now += part * self.per_px_s * framing.width_px * framing.height_px
                left -= part
                yield "view"
        self.key, self.views, self.loaded = (framing, frame), views, object()
        self.drawn.append((framing.width_px, framing.height_px, views))


def moved(step: int) -> Shot:
    assert SHOT.framing is not None
    return replace(SHOT, framing=SHOT.framing.at(Pose((0.1 * step, 0.0, 0.0)), 1))


def sight_of(machine: Machine) -> ScenePreview:
    return ScenePreview(machine, lambda: machine.now)  # type: ignore[arg-type]


def refined(sight: ScenePreview, machine: Machine) -> int:
    """Return frames of the window until the whole picture is there, none of them held up."""
    dearest_s = machine.per_px_s * SIZE[0] * SIZE[1]
    for count in range(1000):
        if sight.is_whole:
            return count
        before = machine.now
        sight.refine(SLICE_S)
        assert machine.now - before <= SLICE_S + dearest_s
    raise AssertionError("never whole")


PRICES = st.sampled_from([1e-9, 3e-8, 1e-7, 4e-7, 1e-5, 1e-4])


@given(PRICES)
def test_the_first_picture_comes_at_once_and_is_whole_without_a_wait(price):
    machine = Machine(price)
    sight = sight_of(machine)
    sight.look(SHOT, 1)
    assert machine.drawn == [(160, 90, 1)] and not sight.is_whole
    refined(sight, machine)
    is_soon = price * SIZE[0] * SIZE[1] * PINHOLE_VIEWS <= 0.25
    steps = [1, PINHOLE_VIEWS] if is_soon else [1, 16, PINHOLE_VIEWS]
    assert machine.drawn[1:] == [(*SIZE, views) for views in steps]
    assert sight.is_good


@given(PRICES, st.lists(st.floats(0.0, 0.1), min_size=2, max_size=12))
def test_while_it_moves_it_fits_the_time_and_at_rest_it_is_whole(price, waits):
    machine = Machine(price)
    sight = sight_of(machine)
    for step, wait in enumerate(waits):
        sight.look(moved(step), 1)
        machine.now += wait
        sight.look(moved(step), 1)  # a frame of the window in which nothing moved
        if step and wait < REST_S:
            count = len(machine.drawn)
            sight.refine(SLICE_S)
            assert len(machine.drawn) == count and not sight.is_whole
    width, height, views = machine.drawn[-1]
    assert price * width * height * views <= 0.031 or (width == SIZE[0] / 4 and views == 1)
    assert views in (1, 2, 4, 8, 16) and (views == 1 or (width, height) == SIZE)
    if price * SIZE[0] * SIZE[1] <= 0.03:
        assert (width, height) == SIZE
    machine.now += sight.seconds_to_rest() + 1e-6
    refined(sight, machine)
    assert machine.drawn[-1] == (*SIZE, PINHOLE_VIEWS)
    count = len(machine.drawn)
    sight.look(moved(len(waits) - 1), 1)
    sight.refine(SLICE_S)
    assert len(machine.drawn) == count and sight.seconds_to_rest() == 0


@given(PRICES, st.lists(st.floats(0.0, 1.0), min_size=1, max_size=12))
def test_what_is_held_is_never_drawn_whole_however_slow_the_window_is(price, waits):
    machine = Machine(price)
    sight = sight_of(machine)
    for step, wait in enumerate(waits):
        sight.look(moved(step), 1, is_held=True)
        machine.now += wait
        sight.look(moved(step), 1, is_held=True)
        sight.refine(SLICE_S)
    assert all(views <= 16 for *_, views in machine.drawn)
    assert len(machine.drawn) == len(waits)


@given(st.floats(1e-7, 2e-6))
def test_between_two_looks_for_input_a_slow_machine_draws_for_a_moment_alone(price):
    machine = Machine(price)
    sight = sight_of(machine)
    sight.look(SHOT, 1)
    longest = []
    while not sight.is_whole:
        before = machine.now
        sight.refine(SLICE_S)
        longest.append(machine.now - before)
    assert max(longest[16:]) <= SLICE_S + MOST_S


def test_a_quick_machine_antialiases_what_moves():
    machine = Machine(1e-9)
    sight = sight_of(machine)
    for step in range(6):
        machine.now += 0.016
        sight.look(moved(step), 1)
    assert machine.drawn[-1] == (*SIZE, 16) and sight.is_good and not sight.is_whole


def test_a_move_ends_what_was_being_refined():
    machine = Machine(1e-6)
    sight = sight_of(machine)
    sight.look(SHOT, 1)
    sight.refine(SLICE_S)
    sight.refine(SLICE_S)
    sight.look(moved(1), 1)
    assert machine.drawn[-1][2] == 1 and not sight.is_good
    machine.now += 1.0
    refined(sight, machine)
    assert [views for *_, views in machine.drawn].count(PINHOLE_VIEWS) == 1
    assert machine.key == (moved(1).framing, 1)


@pytest.mark.parametrize("size", [(1, 1), (3, 16384)])
def test_the_smallest_pictures_are_pictures(size):
    machine = Machine(1.0)
    sight = sight_of(machine)
    for step in range(3):
        sight.look(replace(SHOT, framing=Framing(*size).at(Pose((step, 0.0, 0.0)), 1)), 1)
    assert min(machine.drawn[-1][:2]) == 1


def test_a_change_of_the_lens_that_leaves_the_pinhole_picture_draws_nothing():
    machine = Machine(1e-7)
    sight = sight_of(machine)
    sight.look(SHOT, 1)
    refined(sight, machine)
    count = len(machine.drawn)
    sight.look(replace(SHOT, lens=replace(SHOT.lens, f_stop=8.0, focus_distance_m=1.0)), 1)
    assert len(machine.drawn) == count and sight.is_whole
    sight.look(replace(SHOT, lens=replace(SHOT.lens, focal_length_mm=50.0)), 1)
    assert not sight.is_whole


def test_another_scene_begins_without_a_wait():
    machine = Machine(1e-7)
    sight = sight_of(machine)
    sight.look(SHOT, 1)
    sight.look(moved(1), 1)
    assert sight.seconds_to_rest() > 0
    sight, machine.key = sight_of(machine), None
    sight.look(moved(2), 1)
    assert sight.seconds_to_rest() == 0
    refined(sight, machine)
    assert machine.drawn[-1] == (*SIZE, PINHOLE_VIEWS)
