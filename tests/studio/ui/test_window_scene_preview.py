"""Pictures through many points of the lens refine as they come, and each goes on from the last."""

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from itertools import pairwise
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.settings import PROXY_MIN, VIEWS_MAX, DefocusSettings, Method
from heatlens.core.model.shot.shot import Shot
from heatlens.core.model.view.view import Against, Compare
from heatlens.render.defocus.plate_passes import proxy_size
from heatlens.render.frame_renderer import FrameRenderer
from heatlens.render.gpu.textures import download
from heatlens.render.preview.level_choice import CostModel, cheaper, on_the_way
from heatlens.studio.session.pictures.live_picture import LivePicture
from support.gui import gui_of
from support.scenes import still_life
from support.window_plates import displayed, region

OF_SCENES = [method for method in Method if method.needs_scene]
SIZE = (1280, 720)
LENS = Lens(50.0, 2.0, 2.0, 36.0)
SETTINGS = st.builds(
    DefocusSettings,
    proxy=st.sampled_from([1.0, 0.5, 1 / 3, PROXY_MIN]),
    method=st.sampled_from(OF_SCENES),
    views=st.integers(1, VIEWS_MAX),
)


def work_of(settings: DefocusSettings) -> float:
    return settings.views * settings.proxy**2


@given(SETTINGS)
def test_rungs_go_from_the_wished_picture_to_ever_less_work_of_the_same_method(wished):
    rungs = cheaper(wished)
    assert rungs[0] == wished
    assert all(rung.method is wished.method for rung in rungs)
    assert all(PROXY_MIN <= rung.proxy <= wished.proxy for rung in rungs)
    work = [work_of(rung) for rung in rungs]
    assert all(b < a for a, b in pairwise(work))
    assert on_the_way(wished) == rungs[:0:-1]


@given(SETTINGS)
def test_on_the_way_little_more_work_is_done_than_for_the_whole(wished):
    """At full size each picture goes on from the one before; smaller ones are made for nothing."""
    smaller = [rung for rung in on_the_way(wished) if rung.proxy < wished.proxy]
    full = replace(wished, views=min(wished.views, 16))
    assert sum(work_of(rung) for rung in smaller) <= 0.5 * work_of(full)


@given(SETTINGS, st.integers(1, 4096), st.floats(1e-5, 1.0))
def test_cost_scales_with_the_views(settings, views, seconds):
    cost = CostModel()
    cost.learn(DefocusSettings(), 1000, 1.0)
    assert cost.predicted(settings, 1000) == float("inf")  # diffusion tells nothing of it
    cost.learn(settings, 1000, seconds)
    expected = seconds * views / settings.views * 3
    assert cost.predicted(replace(settings, views=views), 3000) == pytest.approx(expected)
    assert cost.predicted(DefocusSettings(), 1000) == pytest.approx(1.0)


@dataclass
class Machine:
    """A renderer with a clock of its own, which keeps its sums as the real one does."""

    per_view_s: float  # at full size
    now: float = 100.0
    made: list[DefocusSettings] = field(default_factory=list)
    sums: dict[tuple[int, int], int] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.ctx = SimpleNamespace(finish=lambda: None)
        self.loaded = SimpleNamespace(color=SimpleNamespace(size=SIZE))

    def steps(self, shot: Shot, frame: int, slot: int) -> Iterator[str]:
        size = proxy_size(SIZE, shot.defocus.proxy)
        share = size[0] * size[1] / (SIZE[0] * SIZE[1])
        while self.sums.get(size, 0) < shot.defocus.views:
            self.sums[size] = self.sums.get(size, 0) + 1
            self.now += self.per_view_s * share
            yield "view"
        self.made.append(shot.defocus)
        return slot

    def views_drawn(self) -> float:
        """Return the drawing work so far, in views of full size."""
        return (self.now - 100.0) / self.per_view_s


def settle(machine: Machine, live: LivePicture) -> list[DefocusSettings]:
    """Return what is seen one after the other until the whole picture is there."""
    seen = [live.shown.settings]
    machine.now += live.seconds_to_rest()
    for _ in range(10_000):
        if not live.is_working:
            return seen
        live.work(0.02)
        if live.shown.settings != seen[-1]:
            seen.append(live.shown.settings)
    raise AssertionError("the whole picture never came")


@pytest.mark.parametrize("method", OF_SCENES)
def test_a_slow_picture_refines_step_by_step_for_little_more_work(method):
    machine = Machine(0.2)
    live = LivePicture(machine, lambda: machine.now)
    wished = DefocusSettings(method=method, views=1000)
    live.request(Shot(LENS, wished), 0, 0.03)
    seen = settle(machine, live)
    assert seen[0] == cheaper(wished)[-1] and seen[-1] == wished
    views = [settings.views for settings in seen if settings.proxy == 1.0]
    assert views == [16, 66, 256, 1000]
    assert machine.views_drawn() < 1010


def test_further_views_are_added_to_the_picture_that_is_there():
    machine = Machine(0.01)
    live = LivePicture(machine, lambda: machine.now)
    few = DefocusSettings(method=Method.ACCUMULATION, views=64)
    live.request(Shot(LENS, few), 0, 0.03)
    settle(machine, live)
    more = replace(few, views=100)
    before, made = machine.views_drawn(), len(machine.made)
    assert not live.request(Shot(LENS, more), 0, 0.03)
    assert live.shown.settings == few and live.is_working and len(machine.made) == made
    assert settle(machine, live)[-1] == more
    assert machine.views_drawn() - before == pytest.approx(36 + 8)  # and a rest of 0.08 s
    assert live.cost.predicted(more, SIZE[0] * SIZE[1]) == pytest.approx(1.0, rel=0.1)
    live.request(Shot(LENS, replace(few, views=8)), 0, 0.03)  # fewer: another picture
    assert live.shown.settings.views <= 8


# In the window


@pytest.fixture
def scene_gui(ctx, small_demo):
    """Return a window with a small scene, looked at in few pixels."""
    quick = DefocusSettings(layers=1, views=8)
    with gui_of(ctx, "demo", defocus=quick) as gui:
        gui.do("1:1")
        gui.settled()
        yield gui


def test_a_and_b_through_the_whole_lens_are_what_each_is_alone(scene_gui):
    gui = scene_gui
    defocus = replace(gui.session.facts.shot.defocus, method=Method.ACCUMULATION)
    gui.session.editing.edit(replace(gui.session.facts.shot, defocus=defocus))
    gui.session.pictures.view.state = replace(
        gui.session.facts.view,
        against=Against.METHOD,
        b_method=Method.RAYTRACED,
        compare=Compare.FLIP,
    )
    gui.frame(3)
    gui.settled()
    own = FrameRenderer(gui.ctx)
    own.load_scene(still_life())
    shot, frame = gui.session.facts.shot, gui.session.editing.frame
    a = own.pixels(shot, frame)
    np.testing.assert_allclose(
        download(gui.session.pictures.live.shown.texture), a, rtol=1e-4, atol=1e-5
    )
    b_shot = replace(shot, defocus=replace(defocus, method=Method.RAYTRACED))
    b = displayed(gui, own.pixels(b_shot, frame)).astype(int)
    assert np.abs(region(gui) - b).max() <= 1
    assert np.abs(b - displayed(gui, a)).max() > 1


def test_views_are_chosen_by_hand_where_the_method_has_them(scene_gui):
    gui = scene_gui
    gui.ui.panels = {panel: panel == "Lens" for panel in gui.ui.panels}
    gui.frame(3)
    gui.click(gui.middle("method"))
    gui.frame(2)
    gui.click(gui.middle("method: accumulation"))
    gui.frame(3)
    assert gui.session.facts.shot.defocus.method is Method.ACCUMULATION
    x0, y0, _, y1 = gui.rect("views")
    gui.drag((x0 + 60, (y0 + y1) / 2), (x0 + 90, (y0 + y1) / 2))
    assert 8 < gui.session.facts.shot.defocus.views < 256
    gui.settled()
    assert gui.session.pictures.live.shown.settings == gui.session.facts.shot.defocus
