"""Alpha of plates with fragment lists (deep samples): the coverage of all blurred surfaces."""

import numpy as np
import pytest

from heatlens.core.model.shot.settings import Bokeh, DefocusSettings
from heatlens.core.model.shot.shot import Shot
from heatlens.media.plate.plate import Plate
from support.alpha_plates import Layer, plate_of_layers
from support.plates import FAR_M, FOCUS_M, NEAR_M, Image, lens_blurring

HEIGHT, WIDTH = 48, 72


def everywhere(value: float) -> Image:
    return np.full((HEIGHT, WIDTH), value, np.float32)


def card(cover: float, first: int = 24, last: int = 48) -> Image:
    out = everywhere(0.0)
    out[:, first:last] = cover
    return out


def ramp() -> Image:
    return np.broadcast_to(np.linspace(0.1, 0.9, WIDTH, dtype=np.float32), (HEIGHT, WIDTH)).copy()


def render_through_lens(
    renderer, plate: Plate, coc_px: float, bokeh: Bokeh = Bokeh.DISC, **settings
) -> Image:
    renderer.load(plate)
    return renderer.pixels(Shot(lens_blurring(coc_px, WIDTH), DefocusSettings(bokeh, **settings)))


def smoke_and_cards(light: float) -> list[Layer]:
    return [
        (light, 0.6 * ramp(), NEAR_M),
        (light, card(0.8, 10, 30), 3.0),
        (light, card(1.0, 40, 60), FAR_M),
    ]


@pytest.mark.parametrize("coc_px", [0.5, 9.0, 25.0])
@pytest.mark.parametrize("bokeh", [Bokeh.HEAT, Bokeh.GAUSSIAN])
def test_alpha_of_white_lists_equals_their_light(ctx, renderer, bokeh, coc_px):
    """Check white elements, whose premultiplied light equals their alpha for every lens."""
    picture = render_through_lens(renderer, plate_of_layers(smoke_and_cards(1.0)), coc_px, bokeh)
    np.testing.assert_allclose(picture[..., 3], np.minimum(picture[..., 0], 1.0), atol=1e-5)
    assert 0.05 < picture[..., 3].min() and picture[..., 3].max() > 0.9


@pytest.mark.parametrize("coc_px", [6.0, 20.0])
def test_alpha_of_lists_with_opaque_background_is_one(ctx, renderer, coc_px):
    layers = [(0.8, ramp(), NEAR_M), (0.3, card(0.5), 3.0), (0.1, everywhere(1.0), FAR_M)]
    alpha = render_through_lens(renderer, plate_of_layers(layers), coc_px)[..., 3]
    np.testing.assert_allclose(alpha, 1.0, atol=1e-3)


def test_splitting_an_opaque_fragment_keeps_alpha(ctx, renderer):
    whole = [(0.4, card(1.0), NEAR_M), (0.2, 0.7 * ramp(), FAR_M)]
    split = [(0.4, card(0.25), NEAR_M), *whole]
    pictures = [
        render_through_lens(renderer, plate_of_layers(layers), 12.0) for layers in (whole, split)
    ]
    np.testing.assert_allclose(*pictures, atol=1e-3)


@pytest.mark.parametrize("coc_px", [4.0, 15.0])
def test_even_veils_before_nothing_keep_alpha_and_light(ctx, renderer, coc_px):
    """Put two veils before nothing: alpha is 0.7, the light that of both veils composited."""
    veils = [(0.5, everywhere(0.5), NEAR_M), (0.9, everywhere(0.4), FAR_M)]
    picture = render_through_lens(renderer, plate_of_layers(veils), coc_px)
    np.testing.assert_allclose(picture[..., 3], 0.7, atol=2e-3)
    np.testing.assert_allclose(picture[..., :3], 0.5 * 0.5 + 0.5 * 0.4 * 0.9, atol=2e-3)


def test_alpha_behind_blurred_veil_keeps_sharp_edge(ctx, renderer):
    """Compare with the closed form of even smoke before a card in focus, over nothing."""
    layers = [(0.5, everywhere(0.3), NEAR_M), (0.8, card(1.0), FOCUS_M)]
    picture = render_through_lens(renderer, plate_of_layers(layers), 16.0)
    np.testing.assert_allclose(picture[..., 3], 0.3 + 0.7 * card(1.0), atol=0.01)


def test_alpha_under_blurred_card_includes_uncovered_veil(ctx, renderer):
    """Composite the blurred alpha of a card alone over the veil's 0.5 and compare."""
    veil = (0.8, everywhere(0.5), FOCUS_M)
    picture = render_through_lens(renderer, plate_of_layers([(0.2, card(1.0), NEAR_M), veil]), 12.0)
    alone = render_through_lens(renderer, plate_of_layers([(0.2, card(1.0), NEAR_M)]), 12.0)[..., 3]
    np.testing.assert_allclose(picture[..., 3], alone + (1 - alone) * 0.5, atol=0.02)
