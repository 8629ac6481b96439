"""Memory between passes: what shares it never lives at one time, and nobody reads what is dead."""

from collections import defaultdict
from dataclasses import replace
from itertools import combinations

import numpy as np
import pytest

from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.settings import Bokeh, DefocusSettings, Method, Quality
from heatlens.core.model.shot.shot import Shot
from heatlens.render.defocus.pass_list import PASSES
from heatlens.render.defocus.scratch import (
    AFTER_THE_PICTURE,
    POISON_VARIABLE,
    Lifetime,
    Scratch,
    lifetimes,
)
from heatlens.render.frame_renderer import FrameRenderer
from heatlens.render.gpu.device import Device
from heatlens.render.gpu.textures import download
from support.plates import plate_of, room

SETTINGS = {
    "film": DefocusSettings(quality=Quality.FILM),
    "gaussian at a proxy": DefocusSettings(Bokeh.GAUSSIAN, Quality.DRAFT, proxy=0.5),
    "heat": DefocusSettings(method=Method.HEAT),
    "gather": DefocusSettings(method=Method.GATHER),
    "scatter": DefocusSettings(method=Method.SCATTER),
    "pyramid": DefocusSettings(method=Method.PYRAMID),
}
LIFETIMES, ORDER = lifetimes(), [one.name for one in PASSES]
LENS = Lens(85.0, 1.0, 1.6, 36.0)  # so much blur that some layers are worked on at half size


def meet(one: Lifetime, other: Lifetime) -> bool:
    """Return True if both use the same memory at the same time."""
    if one.memory != other.memory:
        return False
    return _place(one.first) <= _place(other.last) and _place(other.first) <= _place(one.last)


def _place(name: str) -> int:
    return len(ORDER) if name == AFTER_THE_PICTURE else ORDER.index(name)


def test_what_shares_memory_never_lives_at_one_time() -> None:
    for (a, one), (b, other) in combinations(LIFETIMES.items(), 2):
        assert not meet(one, other), (a, b)


def test_lifetimes_that_meet_are_told_from_those_that_do_not() -> None:
    hidden, tiles = LIFETIMES["hidden list"], LIFETIMES["tile mask"]
    assert meet(hidden, hidden) and not meet(hidden, tiles)
    high, layer = LIFETIMES["high"], LIFETIMES["layer"]
    assert high.memory == layer.memory and not meet(high, layer)  # one after the other


def test_two_names_that_share_memory_may_follow_but_not_meet() -> None:
    first, second, third = ORDER[:3]
    early, late = Lifetime("m", first, second), Lifetime("m", third, third)
    assert not meet(early, late) and not meet(late, early)
    touching = Lifetime("m", second, third)  # written by the pass that reads the other last
    assert meet(early, touching) and meet(touching, early) and meet(early, early)
    assert not meet(early, replace(touching, memory="n"))
    forever = Lifetime("m", first, AFTER_THE_PICTURE)
    assert meet(forever, late) and meet(late, forever)


def test_a_life_begins_before_it_ends() -> None:
    for life in LIFETIMES.values():
        assert not life.last or ORDER.index(life.first) <= ORDER.index(life.last)


def test_memory_has_one_owner_at_a_time(ctx: Device) -> None:
    scratch = Scratch(ctx)
    rims = scratch.buffer("rim list", 64)
    with pytest.raises(RuntimeError, match=r"'pixel list' still belongs to 'rim list'"):
        scratch.buffer("hidden list", 64)
    scratch.passed("fragments")
    assert scratch.buffer("hidden list", 64) is rims
    scratch.begin_picture()
    assert scratch.buffer("rim list", 64) is rims
    scratch.release()


def test_scratch_memory_has_one_owner_until_its_last_reader(ctx: Device) -> None:
    scratch = Scratch(ctx)
    by_memory: dict[str, list[str]] = {}
    for name, one in LIFETIMES.items():
        if one.last:
            by_memory.setdefault(one.memory, []).append(name)
    first, second, *_ = next(names for names in by_memory.values() if len(names) > 1)
    held = scratch.texture(first, (4, 4), 4)
    assert scratch.texture(first, (4, 4), 4) is held
    with pytest.raises(RuntimeError, match=second):
        scratch.texture(second, (4, 4), 4)
    assert scratch.passed(LIFETIMES[first].last) == LIFETIMES[first].last
    scratch.texture(second, (4, 4), 4)
    scratch.release()
    scratch.texture(first, (4, 4), 4)  # nobody owns what was released
    scratch.release()


def test_what_is_over_is_poisoned(ctx: Device, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(POISON_VARIABLE, "1")
    scratch = Scratch(ctx)
    state = scratch.texture("layer state", (3, 2), 2)
    coc = scratch.texture("layer coc", (3, 2), 1)
    for texture in (state, coc):
        texture.write(bytes(3 * 2 * texture.components * 4))
    scratch.passed("coc fill")
    assert np.isnan(download(state)).all() and not np.isnan(download(coc)).any()
    scratch.release()


@pytest.fixture(scope="module")
def pictures(session_context: Device) -> dict[str, dict[str, np.ndarray]]:
    """Return the pictures of all settings by whether scratch is poisoned: "" no, "1" yes."""
    color, depth = room(160, 96)
    alpha = np.linspace(0.2, 1.0, 160, dtype=np.float32) * np.ones((96, 1, 1), np.float32)
    rgba = np.concatenate([color, alpha.reshape(96, 160, 1)], axis=2)
    plate, found = plate_of(rgba, depth, has_alpha=True), defaultdict(dict)
    for value in ("", "1"):
        with pytest.MonkeyPatch.context() as patch:
            patch.setenv(POISON_VARIABLE, value)
            renderer = FrameRenderer(session_context)
            renderer.load(plate)
            for name, settings in SETTINGS.items():
                found[value][name] = renderer.pixels(Shot(LENS, settings))
            renderer.let_go()
    return found


@pytest.mark.parametrize("name", SETTINGS)
def test_no_pass_reads_what_is_dead(pictures: dict[str, dict[str, np.ndarray]], name: str) -> None:
    poisoned = pictures["1"][name]
    assert np.isfinite(poisoned).all()
    np.testing.assert_array_equal(poisoned, pictures[""][name])
