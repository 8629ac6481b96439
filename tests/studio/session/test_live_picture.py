"""The picture that follows the hand: at once with what fits the time, then whole, bit for bit."""

import math
from collections.abc import Iterator
from contextlib import AbstractContextManager
from dataclasses import dataclass, field, replace
from types import SimpleNamespace
from typing import ClassVar

import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.settings import Bokeh, DefocusSettings, Method, Quality
from heatlens.core.model.shot.shot import Shot
from heatlens.render.defocus.plate_passes import proxy_size
from heatlens.render.defocus.quality import kernel_for, layers_for
from heatlens.render.gpu.known_programs import KnownPrograms, NewProgramError
from heatlens.render.preview.cost_model import GPU_WORK_POWER, CostModel
from heatlens.render.preview.level_choice import (
    cheaper_levels,
    first_picture_settings,
)
from heatlens.studio.session.pictures import live_picture
from heatlens.studio.session.pictures.elsewhere import ProcessBuilder
from heatlens.studio.session.pictures.live_picture import LivePicture, PlateVersion
from support.fake_renderer import optics_of_widest

SIZE = (1920, 1080)
WIDEST_PX = 30.0  # the largest disc
FILM = DefocusSettings()
LENS = Lens(50.0, 2.0, 2.0, 36.0)
STEPS = 20
SLICE_S = 0.02
BUDGET_S = 0.03


@dataclass
class Machine:
    """Stand-in for a renderer with its own clock: each of the `STEPS` of a picture takes time."""

    full_seconds: float  # for a draft of one layer at full size
    clock_s: float = 100.0
    rendered_settings: list[DefocusSettings] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.ctx, self.has_many_views = SimpleNamespace(finish=lambda: None), False
        self.loaded = SimpleNamespace(color=SimpleNamespace(size=SIZE))

    def optics(self, shot: Shot, frame: int) -> SimpleNamespace:
        return optics_of_widest(WIDEST_PX)

    def clock(self) -> float:
        return self.clock_s

    def seconds(self, settings: DefocusSettings) -> float:
        width, height = proxy_size(SIZE, settings.proxy)
        share = width * height / (SIZE[0] * SIZE[1])
        poles = len(kernel_for(settings).poles) * kernel_for(settings).steps
        return self.full_seconds * share * layers_for(settings) * (1 + poles) / 3

    def light_without_highlights(self, slot: int) -> None:
        return None

    def steps(self, shot: Shot, frame: int, slot: int, enlarges: bool = False) -> Iterator[str]:
        for _ in range(STEPS):
            self.clock_s += self.seconds(shot.defocus) / STEPS
            yield "pass"
        self.rendered_settings.append(shot.defocus)
        return (shot, frame, slot)


def shots(count: int, defocus: DefocusSettings = FILM) -> list[Shot]:
    """Return the shots of a drag, this many."""
    return [Shot(replace(LENS, focus_distance_m=1.0 + 0.01 * i), defocus) for i in range(count)]


def machine_and_picture(full_seconds: float) -> tuple[Machine, LivePicture]:
    machine = Machine(full_seconds)
    return machine, LivePicture(machine, machine.clock)


def measured_machine_and_picture(
    full_seconds: float, wished: DefocusSettings = FILM
) -> tuple[Machine, LivePicture]:
    """Return a machine and a live picture whose cost model knows every preview level."""
    machine, live = machine_and_picture(full_seconds)
    for rung in cheaper_levels(wished):
        width, height = proxy_size(SIZE, rung.proxy)
        live.cost.learn(rung, width * height, machine.seconds(rung))
    return machine, live


def recognizable_levels(wished: DefocusSettings) -> list[DefocusSettings]:
    """Return the preview levels whose pictures are large enough to be recognized."""
    rungs = cheaper_levels(wished)
    large = [rung for rung in rungs if proxy_size(SIZE, rung.proxy)[0] >= 160]
    return large or [rung for rung in rungs if rung.proxy == wished.proxy]


def settle(machine: Machine, live: LivePicture) -> None:
    """Let the input rest for ten seconds and work until the whole picture is there."""
    machine.clock_s += 10.0
    for _ in range(10_000):
        if not live.is_working:
            return
        live.work(SLICE_S)
    raise AssertionError("the whole picture never came")


SPEEDS = st.floats(1e-4, 1.0)
WISHES = st.builds(
    DefocusSettings,
    st.sampled_from(Bokeh),
    st.sampled_from(Quality),
    st.one_of(st.none(), st.integers(1, 7)),
    st.sampled_from([1.0, 0.5, 0.25]),
)


def test_same_request_begins_the_answer_that_waits_behind_an_older_one():
    _, live = measured_machine_and_picture(1.0)
    old, new = shots(2)
    live.request(old, 0, BUDGET_S, within_s=1e-6)
    live.request(new, 0, BUDGET_S, within_s=1e6)
    assert live.output.shot.lens == old.lens and live.is_unanswered
    assert live.request(new, 0, BUDGET_S, within_s=1e6)
    assert live.output.shot.lens == new.lens and not live.is_answering
    assert not live.request(new, 0, BUDGET_S, within_s=1e6)


class BuildingMachine(Machine):
    """A machine whose driver builds the programs of each kind of picture for seconds."""

    built = 0
    kinds: ClassVar[set[tuple[Method, Quality]]] = set()

    def steps(self, shot: Shot, frame: int, slot: int, enlarges: bool = False) -> Iterator[str]:
        kind = shot.defocus.method, shot.defocus.quality
        if kind not in self.kinds:
            self.kinds = self.kinds | {kind}
            self.built += 1
            self.clock_s += 3.0
        return (yield from super().steps(shot, frame, slot))


@pytest.mark.parametrize("rests", [0, 1, 5])
def test_time_to_build_programs_does_not_count_as_render_cost(monkeypatch, rests):
    machine = BuildingMachine(0.05 * BUDGET_S)
    monkeypatch.setattr(live_picture, "programs_built", lambda: machine.built)
    live = LivePicture(machine, machine.clock)
    for shot in shots(1 + rests):
        live.request(shot, 0, BUDGET_S)
        settle(machine, live)
    for shot in shots(8 + rests)[1 + rests :]:
        live.request(shot, 0, BUDGET_S)
    assert live.output.is_whole and machine.built > 1


class Gpu(BuildingMachine):
    """A machine on which the passes themselves take time, whatever the size of the picture."""

    def seconds(self, settings: DefocusSettings) -> float:
        return 0.2 * BUDGET_S + super().seconds(settings)


def test_one_drag_on_a_gpu_reaches_the_whole_picture(monkeypatch):
    machine = Gpu(0.02 * BUDGET_S)
    monkeypatch.setattr(live_picture, "programs_built", lambda: machine.built)
    live = LivePicture(machine, machine.clock, cost=CostModel(work_power=GPU_WORK_POWER))
    for shot in shots(20):
        live.request(shot, 0, BUDGET_S)
    assert live.output.is_whole


@given(SPEEDS, WISHES)
def test_each_request_shows_a_picture_of_its_shot_at_once(full_seconds, wished):
    _, live = machine_and_picture(full_seconds)
    for shot in shots(12, wished):
        previous = live.output
        live.request(shot, 7, BUDGET_S)
        assert (live.output.shot, live.output.frame) == (shot, 7) and live.output is not previous


@given(SPEEDS, WISHES)
def test_first_picture_uses_the_level_with_the_fewest_programs(full_seconds, wished):
    """The second picture, for the next change, measures how fast the machine is."""
    machine, live = machine_and_picture(full_seconds)
    first, second = shots(2, wished)
    live.request(first, 0, BUDGET_S)
    (coarse,) = machine.rendered_settings
    assert coarse.method is Method.GATHER and coarse.proxy <= wished.proxy
    assert not live.output.is_whole and not live.cost.seconds_per_px
    live.request(second, 0, BUDGET_S)
    assert (
        machine.rendered_settings[1] == recognizable_levels(wished)[-1] and live.cost.seconds_per_px
    )


@pytest.mark.parametrize("size", [(1280, 720), (3840, 2160)])
def test_large_plate_gets_a_quick_picture_before_the_whole_one(size):
    machine, live = machine_and_picture(0.1)
    machine.loaded.color.size = size
    live.request(shots(1)[0], 0, BUDGET_S)
    machine.clock_s += 1.0
    live.work(math.inf)
    assert machine.rendered_settings[1] == (
        FILM if size[0] < 1920 else recognizable_levels(FILM)[-1]
    )


@given(SPEEDS, st.integers(1, 640))
def test_proxy_of_a_small_plate_stays_recognizable(full_seconds, width):
    """A scene may be drawn small already while it moves."""
    machine, live = machine_and_picture(full_seconds)
    machine.loaded.color.size = width, width
    live.request(shots(1)[0], 0, BUDGET_S)
    assert proxy_size((width, width), machine.rendered_settings[0].proxy)[0] >= min(width, 160)


@given(SPEEDS, WISHES)
def test_request_renders_the_best_level_within_the_budget(full_seconds, wished):
    machine, live = measured_machine_and_picture(full_seconds, wished)
    assume(
        all(
            abs(machine.seconds(rung) / BUDGET_S - 1) > 1e-3 for rung in recognizable_levels(wished)
        )
    )
    live.request(shots(1, wished)[0], 0, BUDGET_S)
    fitting = [rung for rung in recognizable_levels(wished) if machine.seconds(rung) <= BUDGET_S]
    assert machine.rendered_settings == [fitting[0] if fitting else recognizable_levels(wished)[-1]]


@given(SPEEDS, WISHES)
def test_unmeasured_machine_converges_to_levels_within_the_budget(full_seconds, wished):
    machine, live = machine_and_picture(full_seconds)
    for shot in shots(40, wished):
        live.request(shot, 0, BUDGET_S)
    rungs, last = recognizable_levels(wished), machine.rendered_settings[-1]
    assert machine.seconds(last) <= 1.3 * BUDGET_S or last == rungs[-1]
    assert machine.rendered_settings[-5:] == [last] * 5


@given(SPEEDS, WISHES, st.floats(1e-4, 0.2))
def test_request_and_work_return_within_their_time_limit(full_seconds, wished, within_s):
    """The last step may exceed the limit: the first step of a driver may build a program."""
    machine, live = machine_and_picture(full_seconds)
    longest_s = max(machine.seconds(rung) for rung in recognizable_levels(wished)) / STEPS + 1e-9
    shot = shots(1, wished)[0]
    before, _ = machine.clock_s, live.request(shot, 7, BUDGET_S, within_s=within_s)
    while live.is_answering:
        assert machine.clock_s - before <= within_s + longest_s
        assert live.has_work(is_plate_whole=False) and live.seconds_to_rest() == 0.0
        before, _ = machine.clock_s, live.work(within_s, is_plate_whole=False)
    assert (live.output.shot, live.output.frame) == (shot, 7)
    assert machine.rendered_settings == [first_picture_settings(wished, SIZE, WIDEST_PX)]


@settings(max_examples=30)
@given(SPEEDS, st.floats(1e-4, 0.1), st.integers(1, 8))
def test_endless_drag_still_shows_one_picture_after_the_other(full_seconds, within_s, plates):
    _, live = machine_and_picture(full_seconds)
    shown_pictures = []
    for number, shot in enumerate(shots(8 * STEPS)):
        live.request(shot, 0, BUDGET_S, PlateVersion(number * plates // (8 * STEPS)), within_s)
        live.work(within_s)
        if live.output is not None and live.output not in shown_pictures:
            shown_pictures.append(live.output)
    assert len(shown_pictures) >= 8
    while live.is_answering:
        live.work(within_s)
    assert live.output.shot == shot and live.output.plate == plates - 1


@given(st.integers(2, 9))
def test_constantly_changing_plate_is_shown_at_most_two_versions_late(plates):
    _, live = machine_and_picture(1.0)
    for number, shot in enumerate(shots(plates)):
        live.request(shot, number, BUDGET_S, PlateVersion(number), within_s=1e-6)
    assert live.output.plate >= plates - 2


def test_paused_answer_is_resumed_and_rendered_once():
    machine, live = machine_and_picture(1.0)
    shot = shots(1)[0]
    live.request(shot, 0, BUDGET_S, within_s=1e-6)
    live.drop_work()
    assert live.is_answering and live.has_work()
    while live.is_answering:
        live.work(1e-6)
    assert live.output.shot == shot and len(machine.rendered_settings) == 1


def test_request_s_sums_the_time_of_requests():
    machine, live = machine_and_picture(1.0)
    before = machine.clock_s
    for shot in shots(5):
        live.request(shot, 0, BUDGET_S, within_s=0.01)
    assert live.request_s == machine.clock_s - before > 0


@given(st.lists(st.floats(0.8, 1.25), min_size=5, max_size=30))
def test_small_changes_of_speed_do_not_change_the_level(paces):
    machine, live = measured_machine_and_picture(0.02)
    usual = machine.full_seconds
    for shot, pace in zip(shots(len(paces)), paces, strict=True):
        machine.full_seconds = usual * pace
        live.request(shot, 0, 1.02 * usual_seconds_of_second_rung(usual))
    assert len(set(machine.rendered_settings)) == 1


def usual_seconds_of_second_rung(full_seconds: float) -> float:
    return Machine(full_seconds).seconds(cheaper_levels(FILM)[1])


def test_level_gets_quicker_on_slower_machine_and_recovers():
    machine, live = measured_machine_and_picture(0.002)
    before, slow, after = [], [], []
    for rendered, pace in ((before, 1.0), (slow, 20.0), (after, 1.0)):
        machine.full_seconds, machine.rendered_settings = 0.002 * pace, rendered
        for shot in shots(80):
            live.request(replace(shot, frames_per_second=24.0 + pace), 0, BUDGET_S)
    rank = cheaper_levels(FILM).index
    assert rank(slow[-1]) > rank(before[-1])
    machine.full_seconds = 0.04
    assert machine.seconds(slow[-1]) <= 1.3 * BUDGET_S
    assert rank(after[-1]) < rank(slow[-1])


@given(SPEEDS, WISHES)
def test_whole_picture_is_rendered_at_rest_after_at_most_three_levels(full_seconds, wished):
    machine, live = measured_machine_and_picture(full_seconds, wished)
    shot = shots(1, wished)[0]
    live.request(shot, 3, BUDGET_S)
    settle(machine, live)
    assert live.output.is_whole and live.output.settings == wished
    assert (live.output.shot, live.output.frame) == (shot, 3)
    assert len(machine.rendered_settings) <= 3  # the quick one, one between, the whole
    ranks = [cheaper_levels(wished).index(rendered) for rendered in machine.rendered_settings]
    assert ranks == sorted(ranks, reverse=True)


@given(st.floats(1e-3, 1.0))
def test_slice_of_work_ends_within_its_time(full_seconds):
    """Only the last step of the slice may exceed the limit."""
    machine, live = measured_machine_and_picture(full_seconds)
    live.request(shots(1)[0], 0, BUDGET_S)
    machine.clock_s += 1.0
    longest_step = machine.seconds(FILM) / STEPS
    while live.is_working:
        before = machine.clock_s
        live.work(SLICE_S)
        assert machine.clock_s - before <= SLICE_S + longest_step + 1e-9


def test_work_waits_until_the_input_rests():
    machine, live = measured_machine_and_picture(0.1)
    live.request(shots(1)[0], 0, BUDGET_S)
    shown, start_s = live.output, machine.clock_s
    assert live.is_working and live.seconds_to_rest() > 0
    live.work(SLICE_S)
    assert live.output is shown and machine.clock_s == start_s
    machine.clock_s += live.seconds_to_rest()
    live.work(SLICE_S)
    assert machine.clock_s > start_s + SLICE_S


def test_rest_counts_from_the_frame_that_shows_the_answer():
    """Otherwise a slow frame of the window would use the rest up, and a drag would seem at rest."""
    machine, live = measured_machine_and_picture(0.1)
    live.request(shots(1)[0], 0, BUDGET_S)
    shown = live.output
    machine.clock_s += 10.0  # the window draws its frame
    live.begin_rest()
    assert live.seconds_to_rest() > 0
    live.work(SLICE_S)
    assert live.output is shown and live.is_working


def test_new_request_drops_the_picture_in_progress():
    machine, live = measured_machine_and_picture(0.3)
    first, second = shots(2)
    live.request(first, 0, BUDGET_S)
    machine.clock_s += 1.0
    live.work(SLICE_S)
    live.request(second, 0, BUDGET_S)
    assert live.output.shot == second
    settle(machine, live)
    assert live.output.shot == second and live.output.is_whole
    assert machine.rendered_settings.count(FILM) == 1


def test_same_request_again_renders_nothing():
    machine, live = measured_machine_and_picture(0.1)
    shot = shots(1)[0]
    live.request(shot, 0, BUDGET_S)
    settle(machine, live)
    rendered = list(machine.rendered_settings)
    for _ in range(5):
        live.request(replace(shot), 0, BUDGET_S)
        live.work(SLICE_S)
    assert machine.rendered_settings == rendered and not live.is_working


def test_restart_renders_the_same_shot_again():
    machine, live = measured_machine_and_picture(0.001)
    shot = shots(1)[0]
    live.request(shot, 0, BUDGET_S)
    live.restart()
    assert live.output is None and not live.is_working
    live.request(shot, 0, BUDGET_S)
    assert live.output.shot == shot and len(machine.rendered_settings) == 2


@given(SPEEDS)
def test_picture_stays_until_finer_plate_is_rendered_whole(full_seconds):
    machine, live = measured_machine_and_picture(full_seconds)
    shot = shots(1)[0]
    live.request(shot, 0, BUDGET_S, PlateVersion(1))
    settle(machine, live)
    before, count = live.output, len(machine.rendered_settings)
    assert not live.request(shot, 0, BUDGET_S, PlateVersion(2, is_finer=True))
    assert live.output is before and live.is_working
    settle(machine, live)
    assert machine.rendered_settings[count:] == [FILM] and live.output.plate == 2
    assert live.request(shot, 0, BUDGET_S, PlateVersion(3)) and live.output.plate == 3


@given(SPEEDS)
def test_only_quick_levels_are_rendered_while_plate_becomes_finer(full_seconds):
    machine, live = measured_machine_and_picture(full_seconds)
    live.request(shots(1)[0], 0, BUDGET_S)
    machine.clock_s += 1.0
    count = len(machine.rendered_settings)
    for _ in range(10_000):
        if not live.has_work(is_plate_whole=False):
            break
        live.work(SLICE_S, is_plate_whole=False)
    assert not live.has_work(is_plate_whole=False)
    assert all(
        machine.seconds(rendered) <= machine.seconds(FILM) / 3 or machine.seconds(rendered) <= 0.25
        for rendered in machine.rendered_settings[count:]
    )
    if live.is_working:
        assert machine.seconds(FILM) > 0.25
        settle(machine, live)
    assert live.output.settings == FILM


def test_shown_picture_is_never_drawn_over():
    """There are two slots: the next picture is drawn into the one that is not shown."""
    machine, live = measured_machine_and_picture(0.3)
    for shot in shots(6):
        before = None if live.output is None else live.output.texture[2]
        live.request(shot, 0, BUDGET_S)
        assert live.output.texture[2] != before
        machine.clock_s += 1.0
        while live.is_working:
            shown_picture = live.output
            live.work(SLICE_S)
            assert (
                live.output is shown_picture or live.output.texture[2] != shown_picture.texture[2]
            )


class Builder(ProcessBuilder):
    """Builds the programs of one kind of picture after another, when it is told to."""

    def __init__(self) -> None:
        self.version, self.built, self.requests = 0, set(), []

    def refuse_new(self, shot: Shot) -> AbstractContextManager[None]:
        return KnownPrograms().refuse_new()

    def request(self, shot: Shot, frame: int) -> None:
        self.requests.append(shot)

    def build(self, settings: DefocusSettings) -> None:
        self.built.add(settings)
        self.version += 1


class RefusingMachine(Machine):
    """A machine that refuses pictures whose programs its builder has not built."""

    builder: Builder

    def steps(self, shot: Shot, frame: int, slot: int, enlarges: bool = False) -> Iterator[str]:
        settings = shot.defocus
        if settings.method is not Method.GATHER and settings not in self.builder.built:
            yield "pass"
            raise NewProgramError("blur")
        return (yield from super().steps(shot, frame, slot))


def test_only_what_was_refused_waits_for_the_process_at_work_on_it():
    """The process may still have to render the whole picture, which this one can since before."""
    machine = RefusingMachine(0.1)
    machine.builder = builder = Builder()
    live = LivePicture(machine, machine.clock, builder=builder)
    builder.built.add(FILM)
    builder.is_pending = lambda level: True
    live.request(shots(1)[0], 1, BUDGET_S)
    settle(machine, live)
    assert live.output.is_whole
    refused = replace(FILM, quality=Quality.PREVIEW)
    live.request(shots(1, refused)[0], 1, BUDGET_S)
    machine.clock_s += 10.0
    for _ in range(5 * STEPS):
        live.work(SLICE_S)
        builder.version += 1  # another picture of the process is ready
    assert live.is_working
    builder.built.add(refused)
    builder.is_pending = lambda level: False
    settle(machine, live)
    assert live.output.settings == refused


@settings(max_examples=30)
@given(st.lists(st.sampled_from(cheaper_levels(FILM)), max_size=6), SPEEDS)
def test_pictures_wait_for_programs_of_another_process_while_one_program_answers(
    order, full_seconds
):
    """Only what is built is rendered, each change is answered, and what comes next is shown."""
    machine = RefusingMachine(full_seconds)
    machine.builder = builder = Builder()
    live = LivePicture(machine, machine.clock, builder=builder)
    for shot, level in zip(shots(len(order) + 1), [*order, FILM], strict=True):
        live.request(shot, 1, BUDGET_S, within_s=2 * BUDGET_S)
        for _ in range(10_000):
            machine.clock_s += 1.0
            if not live.has_work():
                break
            live.work(SLICE_S)
        assert not live.is_answering and live.output.shot == shot
        assert live.output.settings in builder.built | {
            first_picture_settings(FILM, SIZE, WIDEST_PX)
        }
        builder.build(level)
    settle(machine, live)
    assert live.output.is_whole and (builder.requests or FILM in builder.built)


@given(SPEEDS, WISHES, st.sampled_from([2 * BUDGET_S, math.inf]))
def test_coarser_picture_never_follows_a_finer_one_of_the_same_focus(
    full_seconds, wished, within_s
):
    machine, live = machine_and_picture(full_seconds)
    ladder = [*reversed(cheaper_levels(wished))]  # a gathered picture is below them
    for shot in shots(3, wished):
        live.request(shot, 1, BUDGET_S, within_s=within_s)
        ranks = []
        while live.is_working:
            machine.clock_s += 0.1
            live.work(SLICE_S)
            if live.output is not None and live.output.shot == shot:
                level = live.output.settings
                ranks.append(ladder.index(level) if level in ladder else -1)
        assert ranks == sorted(ranks)
