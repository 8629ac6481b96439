"""Lamps behind near things, known to the last pixel, against many views through the lens."""

from dataclasses import dataclass

import numpy as np
import pytest

from heatlens.core.model.shot.settings import DefocusSettings
from heatlens.core.model.shot.shot import Shot
from heatlens.media.plate.behind import with_behind
from heatlens.media.plate.plate import Plate
from heatlens.render.frame_renderer import FrameRenderer
from support.plates import FAR_M, FOCUS_M, Image, lens_blurring, plate_of

WIDTH, HEIGHT, FINE = 128, 96, 4
BLUR_PX = 20.0  # at FAR_M
DARK, LAMP = 0.05, 60.0
Y, X = (np.mgrid[: HEIGHT * FINE, : WIDTH * FINE] + 0.5) / FINE


@dataclass(frozen=True)
class Surface:
    """A flat surface: its coc, where it is (finely sampled), and its grey."""

    coc_px: float
    is_there: np.ndarray
    grey: float
    blur_px: float = BLUR_PX  # at FAR_M

    @property
    def depth_m(self) -> float:
        """The depth with this coc: coc = 2 blur_px (1 - FOCUS_M / z)."""
        return FOCUS_M / (1.0 - self.coc_px / (2.0 * self.blur_px))


EVERYWHERE = np.ones_like(X, bool)
WALL = Surface(0.0, EVERYWHERE, DARK)


def pixels_of(fine: np.ndarray) -> np.ndarray:
    return fine.reshape(HEIGHT, FINE, WIDTH, FINE).mean((1, 3))


def seen_through_lens(surfaces: list[Surface]) -> np.ndarray:
    """Return the mean of the views from 300 points of the lens; `surfaces` are near to far."""
    golden = np.pi * (3.0 - np.sqrt(5.0))
    total = np.zeros((HEIGHT, WIDTH))
    for i in range(300):
        radius = 0.5 * np.sqrt((i + 0.5) / 300)
        point = radius * np.cos(i * golden), radius * np.sin(i * golden)
        view = np.zeros_like(X)
        for surface in reversed(surfaces):
            moved = [round(FINE * surface.coc_px * part) for part in (point[1], point[0])]
            view[np.roll(surface.is_there, moved, (0, 1))] = surface.grey
        total += pixels_of(view) / 300
    return total


def plates_of(surfaces: list[Surface]) -> list[Plate]:
    """Return a plate of each surface: a pixel has the depth at its middle, a mean as its grey.

    A plate behind continues what is farther than the one before it; a rim of a surface lies on
    the depth of the next one, as renderers write it.
    """
    plates: list[Plate] = []
    for first in range(len(surfaces)):
        fine, depth_m = np.zeros_like(X), np.zeros_like(X)
        for surface in reversed(surfaces[first:]):
            fine[surface.is_there], depth_m[surface.is_there] = surface.grey, surface.depth_m
        grey = pixels_of(fine).astype(np.float32)[..., None].repeat(3, -1)
        middle = depth_m[FINE // 2 :: FINE, FINE // 2 :: FINE].astype(np.float32)
        is_beyond = np.zeros_like(middle, bool)  # all surfaces of the pixel are told already
        for nearer in plates:
            is_beyond |= nearer.depth_m == middle
        middle[is_beyond] = np.inf
        plates.append(plate_of(grey, middle))
    return plates


def known_plate(surfaces: list[Surface]) -> Plate:
    """Return the plate of the nearest surfaces, with all others behind it."""
    visible, *behind = plates_of(surfaces)
    return with_behind(visible, behind)


def rendered(renderer: FrameRenderer, plate: Plate, blur_px: float = BLUR_PX) -> Image:
    renderer.load(plate)
    return renderer.pixels(Shot(lens_blurring(blur_px, WIDTH), DefocusSettings()))[..., 0]


def disc_at(x: float, y: float, radius_px: float) -> np.ndarray:
    return np.hypot(X - x, Y - y) < radius_px


def test_lamp_behind_edge_of_near_card_has_no_dots(renderer: FrameRenderer) -> None:
    """The rim of the hidden lamp lies on the depth of the wall behind it, which is in focus."""
    card = Surface(-40.0, X < 70, DARK)
    lamp = Surface(-3.5, disc_at(58.3, 47.6, 7.2), LAMP)
    surfaces = [card, lamp, WALL]
    found, truth = rendered(renderer, known_plate(surfaces)), seen_through_lens(surfaces)
    inside = disc_at(58.3, 47.6, 7.2 + 3)[FINE // 2 :: FINE, FINE // 2 :: FINE]
    assert np.abs(found - truth)[~inside].max() < 0.1
    assert np.abs(found - truth)[inside].max() < 0.12 * LAMP
    assert found[inside].sum() == pytest.approx(truth[inside].sum(), rel=0.05)


@pytest.mark.parametrize("coc_px", [-0.6, -3.5, 3.0])
def test_lamp_is_seen_evenly_through_near_grating(renderer: FrameRenderer, coc_px: float) -> None:
    """Half of the lens sees each point of the lamp: no stripes, whatever the grating's place."""
    grating = Surface(-60.0, (X % 10) < 5, DARK)
    lamp = Surface(coc_px, disc_at(63.4, 48.2, 8.3), LAMP)
    surfaces = [grating, lamp, WALL] if coc_px < 0 else [grating, WALL, lamp]
    if coc_px > 0:
        surfaces[1] = Surface(0.0, disc_at(63.4, 48.2, 30.0) == 0, DARK)  # a hole before the lamp
        surfaces.append(Surface(BLUR_PX, EVERYWHERE, DARK))
    found, truth = rendered(renderer, known_plate(surfaces)), seen_through_lens(surfaces)
    inside = disc_at(63.4, 48.2, 5.0)[FINE // 2 :: FINE, FINE // 2 :: FINE]
    assert truth[inside].std() < 0.05 * LAMP
    assert found[inside].mean() == pytest.approx(truth[inside].mean(), rel=0.12)
    assert found[inside].std() < 0.07 * LAMP


def test_small_lamp_behind_near_grating_has_no_jumps_in_pull(renderer: FrameRenderer) -> None:
    """Steps of a hundredth of a pixel of coc hardly change the lamp, however many rays test it.

    With whole numbers of rays this pull jumped by .12 of the lamp.
    """
    grating = Surface(-60.0, (X % 10) < 5, DARK)
    pictures = []
    for coc_px in np.arange(-1.62, -1.38, 0.01):
        lamp = Surface(float(coc_px), (X // 1 == 63) & (Y // 1 == 48), LAMP)
        pictures.append(rendered(renderer, known_plate([grating, lamp, WALL])))
    jumps = np.abs(np.diff(pictures, axis=0)).max((1, 2))
    assert jumps.max() < 0.05 * np.max(pictures)


def test_lamp_before_bright_window_has_no_dark_ring(renderer: FrameRenderer) -> None:
    """Diffused, a lamp would take light from the window around it: its kernel ripples."""
    color = np.full((HEIGHT, WIDTH, 3), 3.0, np.float32)
    depth_m = np.full((HEIGHT, WIDTH), FAR_M, np.float32)
    color[44:52, 60:68] = 80.0
    assert rendered(renderer, plate_of(color, depth_m)).min() > 0.98 * 3.0


CLOSE_BLUR_PX, CLOSE_X, CLOSE_Y, CLOSE_SLOPE = 75.0, 64.3, 48.2, 0.12
COLUMNS = np.arange(40, 89)


def card_and_lamp(grey: float) -> list[Surface]:
    """Return a lamp, its wall and a card whose edge the disc of the lamp magnifies by 5."""
    edge = CLOSE_Y + 3.0 + CLOSE_SLOPE * (X - CLOSE_X) < Y
    return [
        Surface(64.0, edge, grey, CLOSE_BLUR_PX),
        Surface(80.0, disc_at(CLOSE_X, CLOSE_Y, 1.5), 4e4, CLOSE_BLUR_PX),
        Surface(80.0, EVERYWHERE, DARK, CLOSE_BLUR_PX),
    ]


def strays_px(picture: Image) -> Image:
    """Return for each of COLUMNS how far the disc ends from where rays to the lamp's middle do."""
    first_row = 48
    below = picture[first_row:, COLUMNS]
    ends_at = first_row + (below / np.median(below[0])).sum(0)
    return np.abs(ends_at - (CLOSE_Y + 5.0 * 3.0 + CLOSE_SLOPE * (COLUMNS + 0.5 - CLOSE_X)))


@pytest.mark.parametrize(("grey", "most_px"), [(0.3, 0.75), (DARK, 1.0)])
@pytest.mark.parametrize("is_known", [False, True])
def test_card_close_before_lamp_cuts_its_disc_straight(
    renderer: FrameRenderer, is_known: bool, grey: float, most_px: float
) -> None:
    """The disc shows the pixels of the card's edge five times as large: no stairs, no dashes.

    A card as DARK as the wall has no mixed pixels: only its depths tell where its edge is (2.4 px
    where each pixel's coverage came from its 3 x 3 depths).
    """
    surfaces = card_and_lamp(grey)
    plate = known_plate(surfaces) if is_known else plates_of(surfaces)[0]
    assert strays_px(rendered(renderer, plate, CLOSE_BLUR_PX)).max() < most_px


def test_cut_goes_on_straight_behind_something_in_focus(renderer: FrameRenderer) -> None:
    """Where a post hides the edge of the card, the list says how the edge goes on behind it.

    Taken to be as wide as the post there, the card cut 4.6 px off the disc.
    """
    post = Surface(0.0, (np.abs(X - CLOSE_X) < 2.0) & (CLOSE_Y < Y), DARK, CLOSE_BLUR_PX)
    plate = known_plate([post, *card_and_lamp(DARK)])
    strays = strays_px(rendered(renderer, plate, CLOSE_BLUR_PX))
    assert strays[np.abs(COLUMNS - CLOSE_X) > 4.0].max() < 2.0
