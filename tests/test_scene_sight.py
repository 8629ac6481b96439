"""How large a scene is drawn while it moves, on a clock of the test's own."""

from dataclasses import dataclass, field, replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from heatlens.errors import InputError
from heatlens.model.framing import Framing, Pose
from heatlens.model.lens import Lens
from heatlens.model.shot import Shot
from heatlens.ui.picture.scene_sight import SceneSight

SIZE = (640, 360)
SHOT = Shot(Lens(35.0, 2.0, 3.0, 36.0), framing=Framing(*SIZE))


@dataclass
class Machine:
    """A renderer that draws at a price, and nothing where the picture is there already."""

    per_px_s: float
    now: float = 100.0
    drawn: list[tuple[int, int, int]] = field(default_factory=list)  # width, height, passes
    key: object = None
    passes: int = 0
    held: object = None

    @property
    def loaded(self) -> object:
        if self.held is None:
            raise InputError("No plate is loaded.")
        return self.held

    def look(self, shot: Shot, frame: int, passes: int | None = None) -> object:
        framing = shot.framing
        assert framing is not None
        if (framing, frame) != self.key or self.passes < (passes or 0):
            self.key, self.passes = (framing, frame), passes or 0
            self.held = object()
            self.now += self.per_px_s * framing.width_px * framing.height_px * (passes or 1)
            self.drawn.append((framing.width_px, framing.height_px, passes or 0))
        return self.held


def moved(step: int) -> Shot:
    assert SHOT.framing is not None
    return replace(SHOT, framing=SHOT.framing.at(Pose((0.1 * step, 0.0, 0.0)), 1))


def sight_of(machine: Machine) -> SceneSight:
    return SceneSight(machine, lambda: machine.now)  # type: ignore[arg-type]


PRICES = st.sampled_from([1e-9, 3e-8, 1e-7, 4e-7, 1e-5])


@given(PRICES)
def test_the_first_picture_is_whole(price):
    machine = Machine(price)
    sight = sight_of(machine)
    sight.look(SHOT, 1)
    assert machine.drawn == [(*SIZE, 4)] and sight.is_whole


@given(PRICES, st.lists(st.floats(0.0, 0.1), min_size=1, max_size=12))
def test_while_it_moves_it_fits_the_time_and_at_rest_it_is_whole(price, waits):
    machine = Machine(price)
    sight = sight_of(machine)
    sight.look(SHOT, 1)
    for step, wait in enumerate(waits):
        machine.now += wait
        sight.look(moved(step), 1)
        sight.look(moved(step), 1)  # a frame of the window in which nothing moved
        assert not sight.is_whole
    width, height, passes = machine.drawn[-1]
    assert passes == 1
    if len(waits) == 1:  # nothing is known yet
        assert (width, height) == (160, 90)
    else:
        assert price * width * height <= 0.031 or width == SIZE[0] / 8
    if len(waits) > 1 and price * SIZE[0] * SIZE[1] <= 0.03:
        assert (width, height) == SIZE
    machine.now += sight.seconds_to_rest() + 1e-6
    sight.look(moved(len(waits) - 1), 1)
    assert machine.drawn[-1] == (*SIZE, 4) and sight.is_whole
    count = len(machine.drawn)
    sight.look(moved(len(waits) - 1), 1)
    assert len(machine.drawn) == count and sight.seconds_to_rest() == 0


@pytest.mark.parametrize("size", [(1, 1), (3, 16384)])
def test_the_smallest_pictures_are_pictures(size):
    machine = Machine(1.0)
    sight = sight_of(machine)
    for step in range(3):
        sight.look(replace(SHOT, framing=Framing(*size).at(Pose((step, 0.0, 0.0)), 1)), 1)
    assert min(machine.drawn[-1][:2]) == 1 or size[0] == 3


def test_a_change_of_the_lens_that_leaves_the_pinhole_picture_draws_nothing():
    machine = Machine(1e-7)
    sight = sight_of(machine)
    sight.look(SHOT, 1)
    sight.look(replace(SHOT, lens=replace(SHOT.lens, f_stop=8.0, focus_distance_m=1.0)), 1)
    assert len(machine.drawn) == 1 and sight.is_whole
    sight.look(replace(SHOT, lens=replace(SHOT.lens, focal_length_mm=50.0)), 1)
    assert not sight.is_whole


def test_another_scene_begins_whole():
    machine = Machine(1e-7)
    sight = sight_of(machine)
    sight.look(SHOT, 1)
    sight.look(moved(1), 1)
    sight.begin()
    machine.key = None
    sight.look(moved(2), 1)
    assert machine.drawn[-1] == (*SIZE, 4)
