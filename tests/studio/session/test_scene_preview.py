"""How large a scene is drawn while it moves, on a clock of the test's own."""

from collections.abc import Iterator
from dataclasses import dataclass, field, replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.camera_track import Pose
from heatlens.core.model.shot.framing import Framing
from heatlens.core.model.shot.shot import Shot
from heatlens.render.scene_gpu.pinhole_draw import FIRST_VIEWS, PINHOLE_VIEWS
from heatlens.studio.session.opened.scene_preview import SLOW_S, ScenePreview

SIZE = (640, 360)
REST_S, SLICE_S = 0.08, 0.012
SHOT = Shot(Lens(35.0, 2.0, 3.0, 36.0), framing=Framing(*SIZE))


@dataclass
class Machine:
    """Stand-in for a renderer that takes `per_px_s` for a pixel and draws each picture once."""

    per_px_s: float
    clock_s: float = 100.0
    drawn_pictures: list[tuple[int, int, int]] = field(default_factory=list)  # width, height, views
    key: object = None
    views: int = 0
    loaded: object = None
    share: float = 1.0  # of a view that a step draws

    def set_step_size(self, share: float) -> None:
        self.share = share

    def settle(self) -> None:
        """Do nothing: what was asked for is drawn at once."""

    def load_pinhole(self, shot: Shot, frame: int, views: int) -> object:
        list(self.load_pinhole_steps(shot, frame, views))
        return self.loaded

    def load_pinhole_steps(self, shot: Shot, frame: int, views: int) -> Iterator[str]:
        framing = shot.framing
        assert framing is not None
        is_same = (framing, frame) == self.key
        if is_same and self.views >= views:
            return
        for _ in range(views - self.views if is_same else views):
            remaining = 1.0
            while remaining > 0:
                fraction = min(self.share, remaining)
                self.clock_s += fraction * self.per_px_s * framing.width_px * framing.height_px
                remaining -= fraction
                yield "view"
        self.key, self.views, self.loaded = (framing, frame), views, object()
        self.drawn_pictures.append((framing.width_px, framing.height_px, views))


def shot_after_move(step: int) -> Shot:
    assert SHOT.framing is not None
    return replace(SHOT, framing=SHOT.framing.with_pose(Pose((0.1 * step, 0.0, 0.0)), 1))


def preview_of(machine: Machine) -> ScenePreview:
    return ScenePreview(machine, lambda: machine.clock_s)  # type: ignore[arg-type]


def refine_until_whole(preview: ScenePreview, machine: Machine) -> int:
    """Refine until the picture is whole; return how many frames of the window that took.

    Each frame may take one slice and the time of the slowest view.
    """
    dearest_s = machine.per_px_s * SIZE[0] * SIZE[1]
    for count in range(1000):
        if preview.is_whole:
            return count
        before = machine.clock_s
        preview.refine(SLICE_S)
        assert machine.clock_s - before <= SLICE_S + dearest_s
    raise AssertionError("never whole")


SECONDS_PER_PX = st.sampled_from([1e-9, 3e-8, 1e-7, 4e-7, 1e-5, 1e-4])


@given(SECONDS_PER_PX)
def test_first_scene_preview_is_drawn_at_once_and_refined_without_wait(per_px_s):
    machine = Machine(per_px_s)
    preview = preview_of(machine)
    preview.draw(SHOT, 1)
    assert machine.drawn_pictures == [(160, 90, 1)] and not preview.is_whole
    refine_until_whole(preview, machine)
    is_soon = per_px_s * SIZE[0] * SIZE[1] * PINHOLE_VIEWS <= 0.25
    steps = [1, PINHOLE_VIEWS] if is_soon else [1, FIRST_VIEWS, PINHOLE_VIEWS]
    assert machine.drawn_pictures[1:] == [(*SIZE, views) for views in steps]
    assert preview.is_good


@given(SECONDS_PER_PX, st.lists(st.floats(0.0, 0.1), min_size=2, max_size=12))
def test_scene_preview_fits_the_budget_while_moving_and_is_whole_at_rest(per_px_s, waits):
    machine = Machine(per_px_s)
    preview = preview_of(machine)
    for step, wait in enumerate(waits):
        preview.draw(shot_after_move(step), 1)
        machine.clock_s += wait
        preview.draw(shot_after_move(step), 1)  # a frame of the window in which nothing moved
        if step and wait < REST_S:
            count = len(machine.drawn_pictures)
            preview.refine(SLICE_S)
            assert len(machine.drawn_pictures) == count and not preview.is_whole
    width, height, views = machine.drawn_pictures[-1]
    assert per_px_s * width * height * views <= 0.031 or (width == SIZE[0] / 4 and views == 1)
    assert views in (1, 2, 4, 8, 16) and (views == 1 or (width, height) == SIZE)
    if per_px_s * SIZE[0] * SIZE[1] <= 0.03:
        assert (width, height) == SIZE
    machine.clock_s += preview.seconds_to_rest() + 1e-6
    refine_until_whole(preview, machine)
    assert machine.drawn_pictures[-1] == (*SIZE, PINHOLE_VIEWS)
    count = len(machine.drawn_pictures)
    preview.draw(shot_after_move(len(waits) - 1), 1)
    preview.refine(SLICE_S)
    assert len(machine.drawn_pictures) == count and preview.seconds_to_rest() == 0


@given(SECONDS_PER_PX, st.lists(st.floats(0.0, 1.0), min_size=1, max_size=12))
def test_scene_preview_is_never_refined_while_the_mouse_is_held(per_px_s, waits):
    machine = Machine(per_px_s)
    preview = preview_of(machine)
    for step, wait in enumerate(waits):
        preview.draw(shot_after_move(step), 1, is_moving=True)
        machine.clock_s += wait
        preview.draw(shot_after_move(step), 1, is_moving=True)
        preview.refine(SLICE_S)
    assert all(views <= 16 for *_, views in machine.drawn_pictures)
    assert len(machine.drawn_pictures) == len(waits)


@given(st.floats(1e-7, 2e-6))
def test_scene_preview_slices_become_short_on_a_slow_machine(per_px_s):
    machine = Machine(per_px_s)
    preview = preview_of(machine)
    preview.draw(SHOT, 1)
    times_s = []
    while not preview.is_whole:
        before = machine.clock_s
        preview.refine(SLICE_S)
        times_s.append(machine.clock_s - before)
    assert max(times_s[16:]) <= SLICE_S + SLOW_S


def test_scene_preview_draws_16_views_while_moving_on_a_quick_machine():
    machine = Machine(1e-9)
    preview = preview_of(machine)
    for step in range(6):
        machine.clock_s += 0.016
        preview.draw(shot_after_move(step), 1)
    assert machine.drawn_pictures[-1] == (*SIZE, 16) and preview.is_good and not preview.is_whole


def test_camera_move_cancels_refinement_of_the_scene_preview():
    machine = Machine(1e-6)
    preview = preview_of(machine)
    preview.draw(SHOT, 1)
    preview.refine(SLICE_S)
    preview.refine(SLICE_S)
    preview.draw(shot_after_move(1), 1)
    assert machine.drawn_pictures[-1][2] == 1 and not preview.is_good
    machine.clock_s += 1.0
    refine_until_whole(preview, machine)
    assert [views for *_, views in machine.drawn_pictures].count(PINHOLE_VIEWS) == 1
    assert machine.key == (shot_after_move(1).framing, 1)


@pytest.mark.parametrize("size", [(1, 1), (3, 16384)])
def test_scene_preview_of_the_smallest_sizes_has_a_pixel(size):
    machine = Machine(1.0)
    preview = preview_of(machine)
    for step in range(3):
        preview.draw(replace(SHOT, framing=Framing(*size).with_pose(Pose((step, 0.0, 0.0)), 1)), 1)
    assert min(machine.drawn_pictures[-1][:2]) == 1


def test_scene_preview_redraws_only_for_changed_focal_length():
    machine = Machine(1e-7)
    preview = preview_of(machine)
    preview.draw(SHOT, 1)
    refine_until_whole(preview, machine)
    count = len(machine.drawn_pictures)
    preview.draw(replace(SHOT, lens=replace(SHOT.lens, f_stop=8.0, focus_distance_m=1.0)), 1)
    assert len(machine.drawn_pictures) == count and preview.is_whole
    preview.draw(replace(SHOT, lens=replace(SHOT.lens, focal_length_mm=50.0)), 1)
    assert not preview.is_whole


def test_scene_preview_of_another_scene_is_refined_without_a_wait():
    machine = Machine(1e-7)
    preview = preview_of(machine)
    preview.draw(SHOT, 1)
    preview.draw(shot_after_move(1), 1)
    assert preview.seconds_to_rest() > 0
    preview, machine.key = preview_of(machine), None
    preview.draw(shot_after_move(2), 1)
    assert preview.seconds_to_rest() == 0
    refine_until_whole(preview, machine)
    assert machine.drawn_pictures[-1] == (*SIZE, PINHOLE_VIEWS)
