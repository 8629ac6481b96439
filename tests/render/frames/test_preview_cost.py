"""Preview levels and their cost model: cheaper levels change resolution and poles, not the blur."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from heatlens.core.model.shot.settings import (
    LAYERS_MAX,
    PROXY_MIN,
    Bokeh,
    DefocusSettings,
    Method,
    Quality,
)
from heatlens.core.model.shot.shot import Shot
from heatlens.render.defocus.quality import layers_for
from heatlens.render.preview.cost_model import CostModel
from heatlens.render.preview.level_choice import cheaper_levels, intermediate_level
from support.plates import FAR_M, NEAR_M, lens_blurring, moments, plate_of

SETTINGS = st.builds(
    DefocusSettings,
    st.sampled_from(Bokeh),
    st.sampled_from(Quality),
    st.one_of(st.none(), st.integers(1, LAYERS_MAX)),
    st.one_of(st.just(1.0), st.floats(PROXY_MIN, 1.0)),
)
RANK = list(Quality).index
WIDTH, HEIGHT = 192, 120  # divisible by every proxy scale, so that a pixel stays one pixel


@given(SETTINGS)
def test_cheaper_levels_are_never_better_than_settings(settings):
    levels = cheaper_levels(settings)
    assert levels[0] == settings and len(set(levels)) == len(levels)
    for level in (*levels, intermediate_level(settings)):
        assert level.bokeh is settings.bokeh
        assert RANK(level.quality) <= RANK(settings.quality)
        assert layers_for(level) <= layers_for(settings)
        assert PROXY_MIN <= level.proxy <= settings.proxy


@given(SETTINGS, st.integers(1, 10**7))
def test_cheaper_levels_are_not_predicted_to_cost_more(settings, pixels):
    """Allow 5 percent for rounding; costs of levels never rendered follow from the learned one."""
    cost = CostModel()
    cost.learn(settings, 1000, 1.0)
    levels = cheaper_levels(settings)
    seconds = [cost.predict_seconds(rung, max(1, round(pixels * rung.proxy**2))) for rung in levels]
    assert min(seconds) >= 0 and math.isfinite(max(seconds))
    assert max(seconds) == pytest.approx(seconds[0], rel=0.05)


def test_predict_seconds_is_infinite_before_learning():
    assert CostModel().predict_seconds(DefocusSettings(), 100) == math.inf


@given(SETTINGS, st.integers(1, 10**7), st.floats(1e-6, 10), st.integers(1, 10**7))
def test_predict_seconds_scales_learned_time_by_pixels(settings, pixels, seconds, other_pixels):
    cost = CostModel()
    for _ in range(3):
        cost.learn(settings, pixels, seconds)
    expected = seconds / pixels * other_pixels
    assert cost.predict_seconds(settings, other_pixels) == pytest.approx(expected)


@given(SETTINGS, st.floats(1e-3, 1.0), st.floats(1e-3, 1.0))
def test_cost_model_follows_changed_speed(settings, first_s, later_s):
    cost = CostModel()
    cost.learn(settings, 100, first_s)
    for _ in range(30):
        cost.learn(settings, 100, later_s)
    assert cost.predict_seconds(settings, 100) == pytest.approx(later_s, rel=1e-3)


@given(SETTINGS, st.floats(1e-3, 1.0), st.floats(1.1, 20.0))
def test_cost_model_keeps_ratio_of_sizes_and_shares_speed(settings, seconds, slower):
    """Check that sizes keep their own cost per pixel, and that a slowdown applies to all sizes."""
    cost, small = CostModel(), replace(settings, proxy=PROXY_MIN / 2 + settings.proxy / 2)
    assume(small.proxy < settings.proxy)
    cost.learn(settings, 100, seconds)
    cost.learn(small, 100, 3 * seconds)
    ratio = cost.predict_seconds(small, 100) / cost.predict_seconds(settings, 100)
    assert ratio == pytest.approx(3.0)
    for _ in range(30):
        cost.learn(small, 100, 3 * slower * seconds)
    assert cost.predict_seconds(settings, 100) == pytest.approx(slower * seconds, rel=1e-3)


@given(SETTINGS, SETTINGS)
def test_cost_model_damps_one_slow_picture(settings, other):
    cost = CostModel()
    for _ in range(5):
        cost.learn(settings, 100, 1.0)
    cost.learn(settings, 100, 10.0)
    assert 1.0 < cost.predict_seconds(settings, 100) < 5.5


@pytest.fixture(scope="module", params=[FAR_M, NEAR_M], ids=["behind", "in front"])
def lamp(request, renderer):
    """Load a lamp on a grey so bright that no ripple of the kernel falls below black."""
    color = np.full((HEIGHT, WIDTH, 3), 0.5, np.float32)
    color[60, 96] += 1000.0
    renderer.load(plate_of(color, np.full((HEIGHT, WIDTH), request.param, np.float32)))
    return renderer


@pytest.mark.parametrize("bokeh", list(Bokeh))
def test_lamp_has_same_light_and_variance_at_every_level(ctx, lamp, bokeh):
    """Compare variances in full-size pixels with a disc's, the squared diameter over 16.

    Large pixels add their own extent, once as they gather light and once as they are filled.
    """
    lens = lens_blurring(40.0, WIDTH)
    for level in cheaper_levels(DefocusSettings(bokeh)):
        picture = lamp.pixels(Shot(lens, level)) - np.float32(0.5)
        scale = WIDTH / picture.shape[1]
        light, across, down = moments(picture)
        area = WIDTH * HEIGHT / (picture.shape[0] * picture.shape[1])
        assert light * area == pytest.approx(1000.0, rel=0.01), level
        for width in (across, down):
            assert 98.5 <= width * scale**2 <= 101.5 + (scale**2 - 1) / 6, level


@given(SETTINGS)
def test_levels_differ_in_proxy_and_quality_only(settings):
    layers = layers_for(replace(settings, method=Method.DIFFUSION))
    for level in (*cheaper_levels(settings)[1:], intermediate_level(settings)):
        assert layers_for(level) == layers, "the cuts would move"
        restored = replace(
            level, quality=settings.quality, layers=settings.layers, proxy=settings.proxy
        )
        assert restored == settings
