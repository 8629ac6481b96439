"""What pictures cost and which one is made: no better than wished, never another amount of blur."""

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
from heatlens.render.preview.level_choice import CostModel, between, cheaper
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
def test_a_quicker_picture_is_in_nothing_better_than_the_wished_one(wished):
    rungs = cheaper(wished)
    assert rungs[0] == wished and len(set(rungs)) == len(rungs)
    for rung in (*rungs, between(wished)):
        assert rung.bokeh is wished.bokeh
        assert RANK(rung.quality) <= RANK(wished.quality)
        assert layers_for(rung) <= layers_for(wished)
        assert PROXY_MIN <= rung.proxy <= wished.proxy


@given(SETTINGS, st.integers(1, 10**7))
def test_no_rung_is_predicted_to_cost_more_than_the_wished_picture(wished, pixels):
    """But for rounding: kinds that were not met are guessed from the one that was."""
    cost = CostModel()
    cost.learn(wished, 1000, 1.0)
    rungs = cheaper(wished)
    seconds = [cost.predicted(rung, max(1, round(pixels * rung.proxy**2))) for rung in rungs]
    assert min(seconds) >= 0 and math.isfinite(max(seconds))
    assert max(seconds) == pytest.approx(seconds[0], rel=0.05)


def test_nothing_is_known_before_a_picture_was_made():
    assert CostModel().predicted(DefocusSettings(), 100) == math.inf


@given(SETTINGS, st.integers(1, 10**7), st.floats(1e-6, 10), st.integers(1, 10**7))
def test_what_was_learnt_is_predicted_by_the_pixel(settings, pixels, seconds, other_pixels):
    cost = CostModel()
    for _ in range(3):
        cost.learn(settings, pixels, seconds)
    expected = seconds / pixels * other_pixels
    assert cost.predicted(settings, other_pixels) == pytest.approx(expected)


@given(SETTINGS, st.floats(1e-3, 1.0), st.floats(1e-3, 1.0))
def test_a_machine_that_changes_its_pace_is_followed(settings, before, after):
    cost = CostModel()
    cost.learn(settings, 100, before)
    for _ in range(30):
        cost.learn(settings, 100, after)
    assert cost.predicted(settings, 100) == pytest.approx(after, rel=1e-3)


@given(SETTINGS, st.floats(1e-3, 1.0), st.floats(1.1, 20.0))
def test_sizes_cost_what_they_cost_and_share_the_pace_of_the_machine(settings, seconds, slower):
    """Small pictures may cost more by the pixel; what slows one down slows down all."""
    cost, small = CostModel(), replace(settings, proxy=PROXY_MIN / 2 + settings.proxy / 2)
    assume(small.proxy < settings.proxy)
    cost.learn(settings, 100, seconds)
    cost.learn(small, 100, 3 * seconds)
    ratio = cost.predicted(small, 100) / cost.predicted(settings, 100)
    assert ratio == pytest.approx(3.0)
    for _ in range(30):
        cost.learn(small, 100, 3 * slower * seconds)
    assert cost.predicted(settings, 100) == pytest.approx(slower * seconds, rel=1e-3)


@given(SETTINGS, SETTINGS)
def test_one_slow_picture_does_not_decide(settings, other):
    cost = CostModel()
    for _ in range(5):
        cost.learn(settings, 100, 1.0)
    cost.learn(settings, 100, 10.0)
    assert 1.0 < cost.predicted(settings, 100) < 5.5


@pytest.fixture(scope="module", params=[FAR_M, NEAR_M], ids=["behind", "in front"])
def lamp(request, renderer):
    """Return a point of light over a grey in which no ripple of the kernel falls below black."""
    color = np.full((HEIGHT, WIDTH, 3), 0.5, np.float32)
    color[60, 96] += 1000.0
    renderer.load(plate_of(color, np.full((HEIGHT, WIDTH), request.param, np.float32)))
    return renderer


@pytest.mark.parametrize("bokeh", list(Bokeh))
def test_light_and_width_of_a_point_are_the_same_on_every_rung(ctx, lamp, bokeh):
    """In full-size pixels, against a disc's variance: the diameter squared over 16.

    Large pixels add their own extent, once as they gather light and once as they are filled.
    """
    lens = lens_blurring(40.0, WIDTH)
    for rung in cheaper(DefocusSettings(bokeh)):
        picture = lamp.pixels(Shot(lens, rung)) - np.float32(0.5)
        scale = WIDTH / picture.shape[1]
        light, across, down = moments(picture)
        area = WIDTH * HEIGHT / (picture.shape[0] * picture.shape[1])
        assert light * area == pytest.approx(1000.0, rel=0.01), rung
        for width in (across, down):
            assert 98.5 <= width * scale**2 <= 101.5 + (scale**2 - 1) / 6, rung


@given(SETTINGS)
def test_levels_differ_in_resolution_and_poles_alone(wished):
    layers = layers_for(replace(wished, method=Method.DIFFUSION))
    for rung in (*cheaper(wished)[1:], between(wished)):
        assert layers_for(rung) == layers, "the cuts would move"
        same = replace(rung, quality=wished.quality, layers=wished.layers, proxy=wished.proxy)
        assert same == wished
