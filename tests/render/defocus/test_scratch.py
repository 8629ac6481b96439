"""Scratch memory: lifetimes that share memory do not overlap; no pass reads memory after them."""

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


def lifetimes_overlap(first: Lifetime, second: Lifetime) -> bool:
    """Return True if both lifetimes have the same memory and overlap in the order of the passes."""
    if first.memory != second.memory:
        return False
    return _pass_index(first.first) <= _pass_index(second.last) and _pass_index(
        second.first
    ) <= _pass_index(first.last)


def _pass_index(name: str) -> int:
    return len(ORDER) if name == AFTER_THE_PICTURE else ORDER.index(name)


def test_lifetimes_with_same_memory_do_not_overlap() -> None:
    for (a, first), (b, second) in combinations(LIFETIMES.items(), 2):
        assert not lifetimes_overlap(first, second), (a, b)


def test_lifetimes_overlap_on_declared_lifetimes() -> None:
    hidden, tiles = LIFETIMES["hidden list"], LIFETIMES["tile mask"]
    assert lifetimes_overlap(hidden, hidden) and not lifetimes_overlap(hidden, tiles)
    highlights, layer = LIFETIMES["highlights"], LIFETIMES["layer"]
    assert highlights.memory == layer.memory  # one after the other
    assert not lifetimes_overlap(highlights, layer)


def test_lifetimes_overlap_on_made_up_lifetimes() -> None:
    first, second, third = ORDER[:3]
    early, late = (
        Lifetime(memory="m", first=first, last=second),
        Lifetime(memory="m", first=third, last=third),
    )
    assert not lifetimes_overlap(early, late) and not lifetimes_overlap(late, early)
    touching = Lifetime("m", second, third)  # written by the pass that reads the other last
    assert (
        lifetimes_overlap(early, touching)
        and lifetimes_overlap(touching, early)
        and lifetimes_overlap(early, early)
    )
    assert not lifetimes_overlap(early, replace(touching, memory="n"))
    forever = Lifetime(memory="m", first=first, last=AFTER_THE_PICTURE)
    assert lifetimes_overlap(forever, late) and lifetimes_overlap(late, forever)


def test_lifetimes_begin_before_they_end() -> None:
    for life in LIFETIMES.values():
        assert not life.last or ORDER.index(life.first) <= ORDER.index(life.last)


def test_scratch_buffer_refuses_second_owner_until_pass_ends(ctx: Device) -> None:
    scratch = Scratch(ctx)
    rims = scratch.buffer("rim list", 64)
    with pytest.raises(RuntimeError, match=r"'pixel list' still belongs to 'rim list'"):
        scratch.buffer("hidden list", 64)
    scratch.end_pass("fragments")
    assert scratch.buffer("hidden list", 64) is rims
    scratch.begin_picture()
    assert scratch.buffer("rim list", 64) is rims
    scratch.release()


def test_scratch_releases_only_what_no_name_owns(ctx: Device) -> None:
    scratch = Scratch(ctx)
    owned, ended = scratch.texture("coc", (4, 4), 1), scratch.buffer("rim list", 64)
    array = scratch.array("far poles", (4, 4), 1, 4, "u4")
    for name in ("fragments", LIFETIMES["far poles"].last):
        scratch.end_pass(name)
    scratch.release_unowned()
    assert scratch.texture("coc", (4, 4), 1) is owned
    assert scratch.buffer("rim list", 64) is not ended
    assert scratch.array("far poles", (4, 4), 1, 4, "u4") is not array
    scratch.release()


def test_scratch_texture_refuses_second_owner_until_last_reader(ctx: Device) -> None:
    scratch = Scratch(ctx)
    by_memory: dict[str, list[str]] = {}
    for name, lifetime in LIFETIMES.items():
        if lifetime.last:
            by_memory.setdefault(lifetime.memory, []).append(name)
    first, second, *_ = next(names for names in by_memory.values() if len(names) > 1)
    texture = scratch.texture(first, (4, 4), 4)
    assert scratch.texture(first, (4, 4), 4) is texture
    with pytest.raises(RuntimeError, match=second):
        scratch.texture(second, (4, 4), 4)
    assert scratch.end_pass(LIFETIMES[first].last) == LIFETIMES[first].last
    scratch.texture(second, (4, 4), 4)
    scratch.release()
    scratch.texture(first, (4, 4), 4)  # nobody owns what was released
    scratch.release()


def test_scratch_poisons_memory_after_its_lifetime(
    ctx: Device, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv(POISON_VARIABLE, "1")
    scratch = Scratch(ctx)
    state = scratch.texture("layer state", (3, 2), 2)
    coc = scratch.texture("layer coc", (3, 2), 1)
    for texture in (state, coc):
        texture.write(bytes(3 * 2 * texture.components * 4))
    scratch.end_pass("coc fill")
    assert np.isnan(download(state)).all() and not np.isnan(download(coc)).any()
    scratch.release()


@pytest.fixture(scope="module")
def pictures(session_context: Device) -> dict[str, dict[str, np.ndarray]]:
    """Return the pictures of all settings by whether scratch is poisoned: "" no, "1" yes."""
    color, depth = room(160, 96)
    alpha = np.linspace(0.2, 1.0, 160, dtype=np.float32) * np.ones((96, 1, 1), np.float32)
    rgba = np.concatenate([color, alpha.reshape(96, 160, 1)], axis=2)
    plate, pictures_by_poison = plate_of(rgba, depth, has_alpha=True), defaultdict(dict)
    for value in ("", "1"):
        with pytest.MonkeyPatch.context() as patch:
            patch.setenv(POISON_VARIABLE, value)
            renderer = FrameRenderer(session_context)
            renderer.load(plate)
            for name, settings in SETTINGS.items():
                pictures_by_poison[value][name] = renderer.pixels(Shot(LENS, settings))
            renderer.unload()
    return pictures_by_poison


@pytest.mark.parametrize("name", SETTINGS)
def test_picture_is_unchanged_by_poisoned_scratch(
    pictures: dict[str, dict[str, np.ndarray]], name: str
) -> None:
    poisoned = pictures["1"][name]
    assert np.isfinite(poisoned).all()
    np.testing.assert_array_equal(poisoned, pictures[""][name])
