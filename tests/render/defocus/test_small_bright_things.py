"""Snow: bright things of 1.5 to 8 px before a darker wall, against their exact discs."""

from dataclasses import dataclass
from itertools import product

import numpy as np
import pytest

from heatlens.core.model.shot.settings import DefocusSettings
from heatlens.core.model.shot.shot import Shot
from heatlens.render.frame_renderer import FrameRenderer
from support.plates import FOCUS_M, Image, lens_blurring, plate_of
from support.unrest import display_of

CELL, FINE = 32, 8
SIZES_PX, LIGHTS, LAMP = (1.5, 2.0, 3.0, 5.0, 8.0), (1.0, 2.0, 4.0), 50.0
SHIFT_PX = 0.37  # of a thing from the middle of its cell
BLUR_PX = 24.0


@dataclass(frozen=True)
class Snow:
    """Round things, each in the middle of a cell: wider from left to right, brighter downwards."""

    wall: float
    thing_coc_px: float
    wall_coc_px: float
    lights: tuple[float, ...] = LIGHTS

    @property
    def plate(self):
        """Colours are means over pixels, depth is that at their middles."""
        cells = [self._cell(size_px, light) for light, size_px in product(self.lights, SIZES_PX)]
        grey, depth_m = (in_rows([cell[i] for cell in cells]) for i in range(2))
        return plate_of(np.repeat(grey[..., None], 3, -1), depth_m)

    def _cell(self, size_px: float, light: float) -> tuple[Image, Image]:
        thing = disc_at(CELL / 2 + SHIFT_PX, size_px)
        depth = np.where(thing, depth_at(self.thing_coc_px), depth_at(self.wall_coc_px))
        grey = self.wall + (light - self.wall) * pixels_of(thing)
        return grey.astype(np.float32), depth[FINE // 2 :: FINE, FINE // 2 :: FINE]

    def truth(self, size_px: float, light: float) -> Image:
        """Return the light of a cell above the wall's: each point of a thing is an even disc."""
        lens = disc_at(CELL / 2, abs(self.thing_coc_px))
        spectrum = np.fft.rfft2(disc_at(CELL / 2 + SHIFT_PX, size_px))
        spectrum *= np.fft.rfft2(np.fft.ifftshift(lens)) / lens.sum()
        return (light - self.wall) * pixels_of(np.fft.irfft2(spectrum, lens.shape))


def disc_at(middle_px: float, size_px: float) -> Image:
    at = (np.arange(CELL * FINE) + 0.5) / FINE - middle_px
    return (np.hypot(at[:, None], at) < size_px / 2).astype(np.float32)


def pixels_of(fine: Image) -> Image:
    return fine.reshape(CELL, FINE, CELL, FINE).mean((1, 3))


def in_rows(cells: list[Image]) -> Image:
    columns = len(SIZES_PX)
    return np.block([cells[i : i + columns] for i in range(0, len(cells), columns)])


def depth_at(coc_px: float) -> float:
    """The depth with this coc: coc = 2 BLUR_PX (1 - FOCUS_M / z)."""
    return FOCUS_M / (1.0 - coc_px / (2.0 * BLUR_PX))


@pytest.mark.parametrize("wall", [0.02, 0.18])
@pytest.mark.parametrize(("thing_coc_px", "wall_coc_px"), [(-10.0, 0.0), (10.0, 16.0)])
def test_small_bright_things_are_discs_without_specks(
    renderer: FrameRenderer, wall: float, thing_coc_px: float, wall_coc_px: float
) -> None:
    """Before a sharp wall no rim stays sharp; before a blurred one discs are not as wide as its."""
    snow = Snow(wall, thing_coc_px, wall_coc_px)
    renderer.load(snow.plate)
    lens = lens_blurring(BLUR_PX, CELL * len(SIZES_PX))
    found = renderer.pixels(Shot(lens, DefocusSettings()))[..., 0] - wall
    for (row, light), (column, size_px) in product(enumerate(LIGHTS), enumerate(SIZES_PX)):
        cell = found[CELL * row :, CELL * column :][:CELL, :CELL]
        truth = snow.truth(size_px, light)
        assert np.abs(cell - truth).sum() < 0.25 * truth.sum()
        assert cell.max() < 1.6 * truth.max()


@pytest.mark.parametrize("coc_px", [0.5, 0.75, 1.0])
def test_lamps_nearly_in_focus_are_as_wide_as_their_discs(
    renderer: FrameRenderer, coc_px: float
) -> None:
    """Light far above white shows wherever a little of it reaches, also beside its pixels.

    Drawn as if all light of a pixel came from its middle, lamps nearly in focus were too narrow:
    display values of five differed by 12.7 to 19.3 pixels in all.
    """
    snow = Snow(0.02, coc_px, coc_px, lights=(LAMP,))
    renderer.load(snow.plate)
    lens = lens_blurring(BLUR_PX, CELL * len(SIZES_PX))
    found = renderer.pixels(Shot(lens, DefocusSettings()))[..., 0]
    truth = in_rows([snow.truth(size_px, LAMP) + snow.wall for size_px in SIZES_PX])
    assert np.abs(display_of(found) - display_of(truth)).sum() < 10.0
