"""Memory between passes: what shares it never lives at one time, and nobody reads what is dead."""

from collections import defaultdict
from itertools import combinations

import moderngl
import numpy as np
import pytest

from heatlens.defocus.pass_list import PASSES
from heatlens.defocus.scratch import POISON_VARIABLE, Scratch, lifetimes
from heatlens.gpu.textures import download
from heatlens.model.lens.lens import Lens
from heatlens.model.shot.settings import Bokeh, DefocusSettings, Method, Quality
from heatlens.model.shot.shot import Shot
from heatlens.render import FrameRenderer
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


def test_what_shares_memory_never_lives_at_one_time() -> None:
    for (a, one), (b, other) in combinations(LIFETIMES.items(), 2):
        assert not one.meets(other), (a, b)


def test_lifetimes_that_meet_are_told_from_those_that_do_not() -> None:
    hidden, tiles = LIFETIMES["hidden list"], LIFETIMES["tile mask"]
    assert hidden.meets(hidden) and not hidden.meets(tiles)
    assert not LIFETIMES["high"].meets(LIFETIMES["surroundings blurred"])  # other reductions


def test_a_life_begins_before_it_ends() -> None:
    for life in LIFETIMES.values():
        assert not life.last or ORDER.index(life.first) <= ORDER.index(life.last)


def test_memory_has_one_owner_at_a_time(ctx: moderngl.Context) -> None:
    scratch = Scratch(ctx)
    rims = scratch.buffer("rim list", 64)
    with pytest.raises(RuntimeError, match=r"'pixel list' still belongs to 'rim list'"):
        scratch.buffer("hidden list", 64)
    scratch.passed("fragments")
    assert scratch.buffer("hidden list", 64) is rims
    scratch.begin_picture()
    assert scratch.buffer("rim list", 64) is rims
    scratch.release()


def test_what_is_over_is_poisoned(ctx: moderngl.Context, monkeypatch: pytest.MonkeyPatch) -> None:
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
def pictures(session_context: moderngl.Context) -> dict[str, dict[str, np.ndarray]]:
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
