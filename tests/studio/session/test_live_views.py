"""Pictures of several lens views refine step by step; each adds views to the last one."""

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from itertools import pairwise
from types import SimpleNamespace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.settings import PROXY_MIN, VIEWS_MAX, DefocusSettings, Method
from heatlens.core.model.shot.shot import Shot
from heatlens.render.defocus.plate_passes import proxy_size
from heatlens.render.preview.cost_model import CostModel
from heatlens.render.preview.level_choice import cheaper_levels, intermediate_levels
from heatlens.studio.session.pictures.live_picture import LivePicture
from support.fake_renderer import optics_of_widest

SCENE_METHODS = [method for method in Method if method.needs_scene]
SIZE = (1280, 720)
LENS = Lens(50.0, 2.0, 2.0, 36.0)
SETTINGS = st.builds(
    DefocusSettings,
    proxy=st.sampled_from([1.0, 0.5, 1 / 3, PROXY_MIN]),
    method=st.sampled_from(SCENE_METHODS),
    views=st.integers(1, VIEWS_MAX),
)


def work_of(settings: DefocusSettings) -> float:
    return settings.views * settings.proxy**2


@given(SETTINGS)
def test_cheaper_levels_of_scene_methods_need_ever_less_work(requested):
    levels = cheaper_levels(requested)
    assert levels[0] == requested
    assert all(rung.method is requested.method for rung in levels)
    assert all(PROXY_MIN <= rung.proxy <= requested.proxy for rung in levels)
    work = [work_of(rung) for rung in levels]
    assert all(b < a for a, b in pairwise(work))
    assert intermediate_levels(requested) == levels[:0:-1]


@given(SETTINGS)
def test_intermediate_levels_add_at_most_half_the_work_of_16_views(requested):
    """Smaller pictures are extra work; at full size each picture adds views to the last one."""
    smaller = [rung for rung in intermediate_levels(requested) if rung.proxy < requested.proxy]
    full = replace(requested, views=min(requested.views, 16))
    assert sum(work_of(rung) for rung in smaller) <= 0.5 * work_of(full)


@given(SETTINGS, st.integers(1, 4096), st.floats(1e-5, 1.0))
def test_predicted_cost_scales_with_the_number_of_views(settings, views, seconds):
    cost = CostModel()
    cost.learn(DefocusSettings(), 1000, 1.0)
    assert cost.predict_seconds(settings, 1000) == float("inf")  # diffusion tells nothing of it
    cost.learn(settings, 1000, seconds)
    expected = seconds * views / settings.views * 3
    assert cost.predict_seconds(replace(settings, views=views), 3000) == pytest.approx(expected)
    assert cost.predict_seconds(DefocusSettings(), 1000) == pytest.approx(1.0)


@dataclass
class Machine:
    """Stand-in for a renderer with its own clock, which keeps sums of views as the real one."""

    per_view_s: float  # at full size
    now: float = 100.0
    made: list[DefocusSettings] = field(default_factory=list)
    sums: dict[tuple[int, int], int] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.ctx = SimpleNamespace(finish=lambda: None)
        self.loaded = SimpleNamespace(color=SimpleNamespace(size=SIZE))
        self.has_many_views = True

    def optics(self, shot: Shot, frame: int) -> SimpleNamespace:
        return optics_of_widest(0.0)

    def light_without_highlights(self, slot: int) -> None:
        return None

    def steps(self, shot: Shot, frame: int, slot: int, enlarges: bool = False) -> Iterator[str]:
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
    """Work until the whole picture is there; return the settings shown one after the other."""
    shown_settings = [live.output.settings]
    machine.now += live.seconds_to_rest()
    for _ in range(10_000):
        if not live.is_working:
            return shown_settings
        live.work(0.02)
        if live.output.settings != shown_settings[-1]:
            shown_settings.append(live.output.settings)
    raise AssertionError("the whole picture never came")


@pytest.mark.parametrize("method", SCENE_METHODS)
def test_slow_picture_refines_in_steps_for_little_extra_work(method):
    machine = Machine(0.2)
    live = LivePicture(machine, lambda: machine.now)
    requested = DefocusSettings(method=method, views=1000)
    live.request(Shot(LENS, requested), 0, 0.03)
    shown_settings = settle(machine, live)
    assert shown_settings[0] == cheaper_levels(requested)[-1] and shown_settings[-1] == requested
    views = [settings.views for settings in shown_settings if settings.proxy == 1.0]
    assert views == [16, 66, 256, 1000]
    assert machine.views_drawn() < 1010


def test_more_views_are_added_to_the_shown_picture():
    machine = Machine(0.01)
    live = LivePicture(machine, lambda: machine.now)
    with_64_views = DefocusSettings(method=Method.ACCUMULATION, views=64)
    live.request(Shot(LENS, with_64_views), 0, 0.03)
    settle(machine, live)
    with_100_views = replace(with_64_views, views=100)
    before, picture_count = machine.views_drawn(), len(machine.made)
    assert not live.request(Shot(LENS, with_100_views), 0, 0.03)
    assert (
        live.output.settings == with_64_views
        and live.is_working
        and len(machine.made) == picture_count
    )
    assert settle(machine, live)[-1] == with_100_views
    assert machine.views_drawn() - before == pytest.approx(36 + 8)  # and a rest of 0.08 s
    assert live.cost.predict_seconds(with_100_views, SIZE[0] * SIZE[1]) == pytest.approx(
        1.0, rel=0.1
    )
    live.request(Shot(LENS, replace(with_64_views, views=8)), 0, 0.03)  # fewer: another picture
    assert live.output.settings.views <= 8
