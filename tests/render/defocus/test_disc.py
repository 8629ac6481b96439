"""A point of light becomes the disc a lens would make of it, down to a few pixels."""

import numpy as np
import pytest

from heatlens.render.defocus.blur_pass import BlurPass, BlurTargets, Diffusion, pole_layers
from heatlens.render.defocus.kernels import Kernel, named_kernel
from heatlens.render.defocus.line_solver import PartitionSolver
from heatlens.render.gpu.device import Device
from heatlens.render.gpu.textures import download, new_array, new_texture, upload
from support.discs import TAILS_PX, Picture, analytic_disc, radius_at_half_height, size_for

DISCS = ["disc_2", "disc_3", "disc_4", "disc_5"]
DIAMETERS = [4.0, 4.5, 5.0, 6.0, 8.0, 11.0, 16.0, 30.0, 75.0, 200.0]


@pytest.fixture(scope="module")
def blur(session_context: Device) -> BlurPass:
    return BlurPass(PartitionSolver(session_context))


def blur_point(ctx: Device, blur: BlurPass, kernel: Kernel, diameter: float) -> Picture:
    side = size_for(diameter)
    x = np.zeros((side, side, 4), np.float32)
    x[side // 2, side // 2] = 1.0
    color, coc, out = (new_texture(ctx, (side, side), channels) for channels in (4, 1, 4))
    poles = new_array(ctx, (side, side), pole_layers(kernel, "f4"), 4)
    upload(color, x)
    blurred = np.zeros((side, side), np.float32)  # the border is in focus, and keeps the light
    blurred[1:-1, 1:-1] = diameter
    upload(coc, blurred)
    blur.run(Diffusion(color, coc, kernel, (1.0, 1.0)), BlurTargets(poles, out))
    picture = download(out)[..., 0].astype(np.float64)
    for texture in (color, coc, out, poles):
        texture.release()
    return picture


@pytest.mark.parametrize("diameter", DIAMETERS)
@pytest.mark.parametrize("name", DISCS)
def test_blurred_point_has_radius_light_and_variance_of_disc(
    ctx: Device, blur: BlurPass, name: str, diameter: float
) -> None:
    picture = blur_point(ctx, blur, named_kernel(name), diameter)
    expected = radius_at_half_height(analytic_disc(diameter), diameter)
    assert radius_at_half_height(picture, diameter) == pytest.approx(expected, rel=0.03)
    assert picture.sum() == pytest.approx(1.0, abs=1e-3)
    if diameter > TAILS_PX:
        return
    offset = np.arange(len(picture)) - len(picture) // 2
    assert (picture.sum(axis=0) * offset**2).sum() == pytest.approx(diameter**2 / 16, rel=0.01)


@pytest.mark.parametrize("diameter", [4.0, 8.0, 30.0])
def test_kernels_of_more_poles_come_closer_to_disc(
    ctx: Device, blur: BlurPass, diameter: float
) -> None:
    disc = analytic_disc(diameter)
    errors = [
        np.linalg.norm(blur_point(ctx, blur, named_kernel(name), diameter) - disc)
        for name in ("heat", "disc_2", "disc_4")
    ]
    assert errors[0] > 2 * errors[1]
    assert errors[1] > 0.9 * errors[2]
    assert errors[2] < 0.2 * np.linalg.norm(disc)
