"""The picture that follows the hand: at once with what fits the time, then whole, bit for bit."""

import math
from collections.abc import Iterator
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
from heatlens.render.preview.level_choice import GPU_WORK_POWER, CostModel, cheaper, soonest
from heatlens.studio.session.pictures import live_picture
from heatlens.studio.session.pictures.live_picture import LivePicture, PlateVersion

SIZE = (1920, 1080)
FILM = DefocusSettings()
LENS = Lens(50.0, 2.0, 2.0, 36.0)
STEPS = 20
SLICE_S = 0.02
BUDGET_S = 0.03


@dataclass
class Machine:
    """A renderer that takes time of its own clock, and a moment of each picture in every step."""

    full_seconds: float  # for a draft of one layer at full size
    now: float = 100.0
    made: list[DefocusSettings] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.ctx = SimpleNamespace(finish=lambda: None)
        self.loaded = SimpleNamespace(color=SimpleNamespace(size=SIZE))

    def clock(self) -> float:
        return self.now

    def seconds(self, wished: DefocusSettings) -> float:
        width, height = proxy_size(SIZE, wished.proxy)
        share = width * height / (SIZE[0] * SIZE[1])
        poles = len(kernel_for(wished).poles) * kernel_for(wished).steps
        return self.full_seconds * share * layers_for(wished) * (1 + poles) / 3

    def steps(self, shot: Shot, frame: int, slot: int) -> Iterator[str]:
        for _ in range(STEPS):
            self.now += self.seconds(shot.defocus) / STEPS
            yield "pass"
        self.made.append(shot.defocus)
        return (shot, frame, slot)


def shots(count: int, defocus: DefocusSettings = FILM) -> list[Shot]:
    """Return the shots of a drag, this many."""
    return [Shot(replace(LENS, focus_distance_m=1.0 + 0.01 * i), defocus) for i in range(count)]


def machine_and_picture(full_seconds: float) -> tuple[Machine, LivePicture]:
    machine = Machine(full_seconds)
    return machine, LivePicture(machine, machine.clock)


def taught(full_seconds: float, wished: DefocusSettings = FILM) -> tuple[Machine, LivePicture]:
    """Return a live picture that knows the time of every preview level."""
    machine, live = machine_and_picture(full_seconds)
    for rung in cheaper(wished):
        width, height = proxy_size(SIZE, rung.proxy)
        live.cost.learn(rung, width * height, machine.seconds(rung))
    return machine, live


def possible(wished: DefocusSettings) -> list[DefocusSettings]:
    """Return the pictures that are large enough to tell anything."""
    rungs = cheaper(wished)
    large = [rung for rung in rungs if proxy_size(SIZE, rung.proxy)[0] >= 160]
    return large or [rung for rung in rungs if rung.proxy == wished.proxy]


def settle(machine: Machine, live: LivePicture) -> None:
    machine.now += 10.0
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


class BuildingMachine(Machine):
    """A machine whose driver builds the programs of each kind of picture for seconds."""

    built = 0
    kinds: ClassVar[set[tuple[Method, Quality]]] = set()

    def steps(self, shot: Shot, frame: int, slot: int) -> Iterator[str]:
        kind = shot.defocus.method, shot.defocus.quality
        if kind not in self.kinds:
            self.kinds = self.kinds | {kind}
            self.built += 1
            self.now += 3.0
        return (yield from super().steps(shot, frame, slot))


@pytest.mark.parametrize("rests", [0, 1, 5])
def test_a_fast_machine_that_builds_programs_slowly_is_known_as_fast(monkeypatch, rests):
    machine = BuildingMachine(0.05 * BUDGET_S)
    monkeypatch.setattr(live_picture, "programs_built", lambda: machine.built)
    live = LivePicture(machine, machine.clock)
    for shot in shots(1 + rests):
        live.request(shot, 0, BUDGET_S)
        settle(machine, live)
    for shot in shots(8 + rests)[1 + rests :]:
        live.request(shot, 0, BUDGET_S)
    assert live.shown.is_whole and machine.built > 1


class Gpu(BuildingMachine):
    """A machine on which the passes themselves take time, whatever the size of the picture."""

    def seconds(self, wished: DefocusSettings) -> float:
        return 0.2 * BUDGET_S + super().seconds(wished)


def test_one_drag_on_a_gpu_climbs_to_the_whole_picture(monkeypatch):
    machine = Gpu(0.02 * BUDGET_S)
    monkeypatch.setattr(live_picture, "programs_built", lambda: machine.built)
    live = LivePicture(machine, machine.clock, cost=CostModel(work_power=GPU_WORK_POWER))
    for shot in shots(20):
        live.request(shot, 0, BUDGET_S)
    assert live.shown.is_whole


@given(SPEEDS, WISHES)
def test_every_change_is_answered_at_once(full_seconds, wished):
    _, live = machine_and_picture(full_seconds)
    for shot in shots(12, wished):
        before = live.shown
        live.request(shot, 7, BUDGET_S)
        assert (live.shown.shot, live.shown.frame) == (shot, 7) and live.shown is not before


@given(SPEEDS, WISHES)
def test_the_first_picture_of_a_machine_needs_the_fewest_programs(full_seconds, wished):
    """The next, for the next change, tells how fast the machine is."""
    machine, live = machine_and_picture(full_seconds)
    first, second = shots(2, wished)
    live.request(first, 0, BUDGET_S)
    (coarse,) = machine.made
    assert coarse.method is Method.PYRAMID and coarse.proxy < wished.proxy
    assert not live.shown.is_whole and not live.cost.seconds_per_px
    live.request(second, 0, BUDGET_S)
    assert machine.made[1] == possible(wished)[-1] and live.cost.seconds_per_px


@pytest.mark.parametrize("size", [(1280, 720), (3840, 2160)])
def test_a_plate_that_may_take_long_has_a_quick_picture_before_the_whole_one(size):
    machine, live = machine_and_picture(0.1)
    machine.loaded.color.size = size
    live.request(shots(1)[0], 0, BUDGET_S)
    machine.now += 1.0
    live.work(math.inf)
    assert machine.made[1] == (FILM if size[0] < 1920 else possible(FILM)[-1])


@given(SPEEDS, st.integers(1, 640))
def test_a_small_plate_is_not_made_so_small_that_nothing_can_be_told(full_seconds, width):
    """A scene may be drawn small already while it moves."""
    machine, live = machine_and_picture(full_seconds)
    machine.loaded.color.size = width, width
    live.request(shots(1)[0], 0, BUDGET_S)
    assert proxy_size((width, width), machine.made[0].proxy)[0] >= min(width, 160)


@given(SPEEDS, WISHES)
def test_the_best_picture_that_fits_the_time_is_made(full_seconds, wished):
    machine, live = taught(full_seconds, wished)
    assume(all(abs(machine.seconds(rung) / BUDGET_S - 1) > 1e-3 for rung in possible(wished)))
    live.request(shots(1, wished)[0], 0, BUDGET_S)
    fitting = [rung for rung in possible(wished) if machine.seconds(rung) <= BUDGET_S]
    assert machine.made == [fitting[0] if fitting else possible(wished)[-1]]


@given(SPEEDS, WISHES)
def test_an_untaught_machine_comes_to_pictures_that_fit(full_seconds, wished):
    machine, live = machine_and_picture(full_seconds)
    for shot in shots(40, wished):
        live.request(shot, 0, BUDGET_S)
    rungs, last = possible(wished), machine.made[-1]
    assert machine.seconds(last) <= 1.3 * BUDGET_S or last == rungs[-1]
    assert machine.made[-5:] == [last] * 5


@given(SPEEDS, WISHES, st.floats(1e-4, 0.2))
def test_an_answer_never_keeps_the_window_longer_than_it_may(full_seconds, wished, within_s):
    """But for the step that it ends with: the first of a driver may build a program."""
    machine, live = machine_and_picture(full_seconds)
    longest_s = max(machine.seconds(rung) for rung in possible(wished)) / STEPS + 1e-9
    shot = shots(1, wished)[0]
    before, _ = machine.now, live.request(shot, 7, BUDGET_S, within_s=within_s)
    while live.is_answering:
        assert machine.now - before <= within_s + longest_s
        assert live.wants_work(is_plate_whole=False) and live.seconds_to_rest() == 0.0
        before, _ = machine.now, live.work(within_s, is_plate_whole=False)
    assert (live.shown.shot, live.shown.frame) == (shot, 7)
    assert machine.made == [soonest(wished, SIZE)]


@settings(max_examples=30)
@given(SPEEDS, st.floats(1e-4, 0.1), st.integers(1, 8))
def test_a_hand_that_never_rests_sees_one_picture_after_the_other(full_seconds, within_s, plates):
    _, live = machine_and_picture(full_seconds)
    seen = []
    for number, shot in enumerate(shots(8 * STEPS)):
        live.request(shot, 0, BUDGET_S, PlateVersion(number * plates // (8 * STEPS)), within_s)
        live.work(within_s)
        if live.shown is not None and live.shown not in seen:
            seen.append(live.shown)
    assert len(seen) >= 8
    while live.is_answering:
        live.work(within_s)
    assert live.shown.shot == shot and live.shown.plate == plates - 1


@given(st.integers(2, 9))
def test_a_plate_that_changes_all_the_time_is_seen_every_second_time(plates):
    _, live = machine_and_picture(1.0)
    for number, shot in enumerate(shots(plates)):
        live.request(shot, number, BUDGET_S, PlateVersion(number), within_s=1e-6)
    assert live.shown.plate >= plates - 2


def test_an_answer_that_was_left_off_for_others_begins_anew():
    machine, live = machine_and_picture(1.0)
    shot = shots(1)[0]
    live.request(shot, 0, BUDGET_S, within_s=1e-6)
    live.pause()
    assert live.is_answering and live.wants_work()
    while live.is_answering:
        live.work(1e-6)
    assert live.shown.shot == shot and len(machine.made) == 1


def test_the_time_spent_on_answers_is_told():
    machine, live = machine_and_picture(1.0)
    before = machine.now
    for shot in shots(5):
        live.request(shot, 0, BUDGET_S, within_s=0.01)
    assert live.request_s == machine.now - before > 0


@given(st.lists(st.floats(0.8, 1.25), min_size=5, max_size=30))
def test_a_pace_that_wavers_does_not_change_the_picture(paces):
    machine, live = taught(0.02)
    usual = machine.full_seconds
    for shot, pace in zip(shots(len(paces)), paces, strict=True):
        machine.full_seconds = usual * pace
        live.request(shot, 0, 1.02 * usual_seconds_of_second_rung(usual))
    assert len(set(machine.made)) == 1


def usual_seconds_of_second_rung(full_seconds: float) -> float:
    return Machine(full_seconds).seconds(cheaper(FILM)[1])


def test_a_machine_that_slows_down_gets_quicker_pictures_and_comes_back():
    machine, live = taught(0.002)
    before, slow, after = [], [], []
    for made, pace in ((before, 1.0), (slow, 20.0), (after, 1.0)):
        machine.full_seconds, machine.made = 0.002 * pace, made
        for shot in shots(80):
            live.request(replace(shot, frames_per_second=24.0 + pace), 0, BUDGET_S)
    rank = cheaper(FILM).index
    assert rank(slow[-1]) > rank(before[-1])
    machine.full_seconds = 0.04
    assert machine.seconds(slow[-1]) <= 1.3 * BUDGET_S
    assert rank(after[-1]) < rank(slow[-1])


@given(SPEEDS, WISHES)
def test_rest_brings_the_whole_picture(full_seconds, wished):
    machine, live = taught(full_seconds, wished)
    shot = shots(1, wished)[0]
    live.request(shot, 3, BUDGET_S)
    settle(machine, live)
    assert live.shown.is_whole and live.shown.settings == wished
    assert (live.shown.shot, live.shown.frame) == (shot, 3)
    assert len(machine.made) <= 3  # the quick one, one between, the whole
    ranks = [cheaper(wished).index(made) for made in machine.made]
    assert ranks == sorted(ranks, reverse=True)


@given(st.floats(1e-3, 1.0))
def test_a_slice_of_work_is_no_longer_than_it_may_be(full_seconds):
    """But for the step that it ends with."""
    machine, live = taught(full_seconds)
    live.request(shots(1)[0], 0, BUDGET_S)
    machine.now += 1.0
    longest_step = machine.seconds(FILM) / STEPS
    while live.is_working:
        before = machine.now
        live.work(SLICE_S)
        assert machine.now - before <= SLICE_S + longest_step + 1e-9


def test_nothing_is_worked_on_while_the_hand_moves():
    machine, live = taught(0.1)
    live.request(shots(1)[0], 0, BUDGET_S)
    shown, now = live.shown, machine.now
    assert live.is_working and live.seconds_to_rest() > 0
    live.work(SLICE_S)
    assert live.shown is shown and machine.now == now
    machine.now += live.seconds_to_rest()
    live.work(SLICE_S)
    assert machine.now > now + SLICE_S


def test_a_change_drops_what_was_coming_about():
    machine, live = taught(0.3)
    first, second = shots(2)
    live.request(first, 0, BUDGET_S)
    machine.now += 1.0
    live.work(SLICE_S)
    live.request(second, 0, BUDGET_S)
    assert live.shown.shot == second
    settle(machine, live)
    assert live.shown.shot == second and live.shown.is_whole
    assert machine.made.count(FILM) == 1


def test_the_same_wish_again_costs_nothing():
    machine, live = taught(0.1)
    shot = shots(1)[0]
    live.request(shot, 0, BUDGET_S)
    settle(machine, live)
    made = list(machine.made)
    for _ in range(5):
        live.request(replace(shot), 0, BUDGET_S)
        live.work(SLICE_S)
    assert machine.made == made and not live.is_working


def test_another_plate_is_another_picture_of_the_same_shot():
    machine, live = taught(0.001)
    shot = shots(1)[0]
    live.request(shot, 0, BUDGET_S)
    live.restart()
    assert live.shown is None and not live.is_working
    live.request(shot, 0, BUDGET_S)
    assert live.shown.shot == shot and len(machine.made) == 2


@given(SPEEDS)
def test_the_picture_of_a_plate_that_became_finer_stays_until_the_next_is_whole(full_seconds):
    machine, live = taught(full_seconds)
    shot = shots(1)[0]
    live.request(shot, 0, BUDGET_S, PlateVersion(1))
    settle(machine, live)
    before, count = live.shown, len(machine.made)
    assert not live.request(shot, 0, BUDGET_S, PlateVersion(2, is_finer=True))
    assert live.shown is before and live.is_working
    settle(machine, live)
    assert machine.made[count:] == [FILM] and live.shown.plate == 2
    assert live.request(shot, 0, BUDGET_S, PlateVersion(3)) and live.shown.plate == 3


@given(SPEEDS)
def test_of_a_plate_that_will_be_finer_only_what_comes_soon_is_made(full_seconds):
    machine, live = taught(full_seconds)
    live.request(shots(1)[0], 0, BUDGET_S)
    machine.now += 1.0
    count = len(machine.made)
    for _ in range(10_000):
        if not live.wants_work(is_plate_whole=False):
            break
        live.work(SLICE_S, is_plate_whole=False)
    assert not live.wants_work(is_plate_whole=False)
    assert all(
        machine.seconds(made) <= machine.seconds(FILM) / 3 or machine.seconds(made) <= 0.25
        for made in machine.made[count:]
    )
    if live.is_working:
        assert machine.seconds(FILM) > 0.25
        settle(machine, live)
    assert live.shown.settings == FILM


def test_a_picture_that_is_looked_at_is_not_drawn_over():
    """Two slots: the next one comes about in the other."""
    machine, live = taught(0.3)
    for shot in shots(6):
        before = None if live.shown is None else live.shown.texture[2]
        live.request(shot, 0, BUDGET_S)
        assert live.shown.texture[2] != before
        machine.now += 1.0
        while live.is_working:
            looked_at = live.shown
            live.work(SLICE_S)
            assert live.shown is looked_at or live.shown.texture[2] != looked_at.texture[2]
