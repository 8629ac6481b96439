"""Test accumulated views through the lens: a point becomes the disc of the thin lens."""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from demo_street.shapes import moved, quads, scaled
from heatlens.core.model.focus.coc import axial_px, coc_line, coc_px
from heatlens.core.model.lens.disc_shape import DiscShape, PictureField
from heatlens.core.model.lens.lens import Lens, LensModel
from heatlens.core.model.shot.camera_track import Pose
from heatlens.media.scene.material import Material
from heatlens.media.scene.scene import Daylight, Instance, Scene
from heatlens.media.scene.scene_view import SceneView, pupil_of, view_of
from heatlens.render.gpu.device import Device
from heatlens.render.gpu.textures import download, new_texture
from heatlens.render.scene_gpu.accumulation import Accumulation
from heatlens.render.scene_gpu.raster import SceneRaster

SIZE = (48, 40)
LENS = Lens(100.0, 1.0, 2.0, 36.0)
FOCAL_PX = SIZE[0] * 100.0 / 36.0
NIGHT = Daylight(sun=(0, 0, 0), zenith=(0, 0, 0), horizon=(0, 0, 0), ground=(0, 0, 0))
QUAD_PX = 2.0
RADIANCE = 40.0
VIEWS = 256
AT_PX = (4.25, -3.25)  # right of and above the middle, between two pixels' edges


def lamp_at(depth_m: float) -> Scene:
    """Return a square that a pinhole sees QUAD_PX wide around AT_PX, and nothing else."""
    half, metre_px = QUAD_PX / 2, FOCAL_PX / depth_m
    square = quads(
        [np.array([(-half, -half, 0), (half, -half, 0), (half, half, 0), (-half, half, 0)])]
    )
    place = moved(AT_PX[0] / metre_px, -AT_PX[1] / metre_px, -depth_m)
    place = place @ scaled(1 / metre_px, 1 / metre_px, 1.0)
    lit = Material(base_color=(0, 0, 0), emission=(RADIANCE, RADIANCE / 2, 0.0))
    return Scene(Path("lamp"), (square,), (Instance("lamp", 0, place),), (lit,), daylight=NIGHT)


def view_through(lens: Lens) -> SceneView:
    return view_of(Pose(), lens, SIZE, np.array([(-9, -9, -9.0), (9, 9, -0.1)]))


class Lab:
    """A raster with an output texture; each measurement uses new sums unless given."""

    def __init__(self, ctx: Device) -> None:
        self.ctx = ctx
        self.raster = SceneRaster(ctx)
        self.out = new_texture(ctx, SIZE, 4)

    def load(self, depth_m: float) -> None:
        self.raster.load(lamp_at(depth_m))
        self.raster.place(1)

    def seen(self, lens: Lens, *views: int, sums: Accumulation | None = None) -> np.ndarray:
        """Return (H, W, 4) after requesting each number of views in turn."""
        sums = sums or Accumulation(self.ctx, self.raster)
        for count in views:
            self.out.write(np.full((*SIZE, 4), 7, np.float32).tobytes())
            key = (lens, self.raster.buffers.scene)
            steps = list(sums.steps(view_through(lens), pupil_of(lens), count, self.out, key))
            assert set(steps) <= {"view"}
        return download(self.out)

    def seen_in_colors(self, lens: Lens, views: int) -> np.ndarray:
        """Return (H, W, 4) of this many points of the lens, each drawn once for each colour."""
        sums = Accumulation(self.ctx, self.raster)
        list(sums.steps(view_through(lens), pupil_of(lens), views, self.out, lens))
        return download(self.out)


@pytest.fixture(scope="module")
def lab(session_context: Device) -> Iterator[Lab]:
    lab = Lab(session_context)
    yield lab
    lab.raster.release()


def spread(light: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return mean and variance of light along x and y, in pixels from the middle of the image."""
    weights = light / light.sum()
    places = [np.arange(n) + 0.5 - n / 2 for n in SIZE]
    sums = [weights.sum(axis=0), weights.sum(axis=1)]
    means = np.array([at @ share for at, share in zip(places, sums, strict=True)])
    squares = np.array([at**2 @ share for at, share in zip(places, sums, strict=True)])
    return means, squares - means**2


@pytest.mark.parametrize("depth_m", [0.8, 1.2, 2.0, 3.0, 8.0])
@pytest.mark.parametrize(
    ("squeeze", "model"),
    [(1.0, LensModel.PHOTOGRAPHIC), (1.0, LensModel.RENDERER), (1.8, LensModel.PHOTOGRAPHIC)],
)
def test_accumulated_lamp_is_disc_of_thin_lens(
    ctx: Device, lab: Lab, depth_m: float, squeeze: float, model: LensModel
) -> None:
    lens = replace(LENS, squeeze=squeeze, model=model)
    lab.load(depth_m)
    light = lab.seen(lens, VIEWS)[..., 0].astype(np.float64)
    diameter = abs(float(coc_px(depth_m, coc_line(lens, SIZE[0]))))
    means, variances = spread(light)
    # A disc's variance is (d / 4)^2 along each axis, a box's its width squared over 12, but for
    # what pixels as coarse as the light make of it.
    lamp_variance = (QUAD_PX**2 + 1.0) / 12
    expected = [(diameter / squeeze / 4) ** 2 + lamp_variance, (diameter / 4) ** 2 + lamp_variance]
    np.testing.assert_allclose(variances, expected, rtol=0.02, atol=0.1)
    np.testing.assert_allclose(means, AT_PX, atol=0.05)
    np.testing.assert_allclose(light.sum(), RADIANCE * QUAD_PX**2, rtol=0.01)


def test_accumulated_disc_is_even_and_ends_at_its_radius(ctx: Device, lab: Lab) -> None:
    lab.load(0.8)
    light = lab.seen(LENS, 1024)[..., 0].astype(np.float64)
    radius = abs(float(coc_px(0.8, coc_line(LENS, SIZE[0])))) / 2
    y, x = np.indices(light.shape) + 0.5
    distance_px = np.hypot(x - SIZE[0] / 2 - AT_PX[0], y - SIZE[1] / 2 - AT_PX[1])
    reach = (QUAD_PX + 1) / np.sqrt(2)
    assert light[distance_px > radius + reach].max() == 0
    inside = light[distance_px < radius - reach]
    expected = RADIANCE * QUAD_PX**2 / (np.pi * radius**2)
    np.testing.assert_allclose(inside, expected, rtol=0.25)
    np.testing.assert_allclose(inside.mean(), expected, rtol=0.01)


def test_accumulated_object_in_focus_is_as_sharp_as_pinhole(ctx: Device, lab: Lab) -> None:
    lab.load(LENS.focus_distance_m)
    through_lens = lab.seen(LENS, VIEWS)
    pinhole = lab.seen(replace(LENS, f_stop=1e5), VIEWS)
    np.testing.assert_array_equal(through_lens, pinhole)
    assert np.count_nonzero(through_lens[..., 0]) <= (QUAD_PX + 1) ** 2


def test_accumulated_edge_pixels_have_covered_share(ctx: Device, lab: Lab) -> None:
    lab.load(LENS.focus_distance_m)
    light = lab.seen(LENS, 1024)[..., 0]
    shares = []
    for side, at in zip(SIZE, AT_PX, strict=True):
        left = np.arange(side) - side / 2 - at
        overlap = np.minimum(left + 1, QUAD_PX / 2) - np.maximum(left, -QUAD_PX / 2)
        shares.append(np.clip(overlap, 0, 1))
    np.testing.assert_allclose(light, RADIANCE * np.outer(shares[1], shares[0]), atol=0.4)


def test_accumulation_keeps_colors_and_alpha(ctx: Device, lab: Lab) -> None:
    lab.load(1.2)
    picture = lab.seen(LENS, 50)
    np.testing.assert_allclose(picture[..., 1], picture[..., 0] / 2, rtol=1e-6)
    assert not picture[..., 2].any()
    np.testing.assert_array_equal(picture[..., 3], 1)


def test_accumulation_continues_with_more_views(ctx: Device, lab: Lab) -> None:
    lab.load(0.8)
    at_once = lab.seen(LENS, 64)
    assert np.any(lab.seen(LENS, 16) != at_once)
    np.testing.assert_array_equal(lab.seen(LENS, 16, 64), at_once)
    np.testing.assert_array_equal(lab.seen(LENS, 5, 64, 64), at_once)
    np.testing.assert_array_equal(lab.seen(LENS, 300, 64), at_once)


def test_accumulation_draws_only_new_views(ctx: Device, lab: Lab) -> None:
    lab.load(0.8)
    sums = Accumulation(ctx, lab.raster)
    requested_views = [4, 4, 9, 2]
    counts = [
        len(list(sums.steps(view_through(LENS), pupil_of(LENS), views, lab.out, "same")))
        for views in requested_views
    ]
    assert counts == [4, 0, 5, 2]


def test_accumulation_restarts_for_another_key(ctx: Device, lab: Lab) -> None:
    sums = Accumulation(ctx, lab.raster)
    lab.load(0.8)
    lab.seen(LENS, 32, sums=sums)
    lab.load(3.0)
    np.testing.assert_array_equal(lab.seen(LENS, 32, sums=sums), lab.seen(LENS, 32))


def test_accumulation_continues_after_interrupted_steps(ctx: Device, lab: Lab) -> None:
    lab.load(1.2)
    sums = Accumulation(ctx, lab.raster)
    key = (LENS, lab.raster.buffers.scene)
    steps = sums.steps(view_through(LENS), pupil_of(LENS), 32, lab.out, key)
    for _ in range(10):
        next(steps)
    so_far = download(lab.out)
    np.testing.assert_array_equal(so_far, lab.seen(LENS, 10))
    steps.close()
    np.testing.assert_array_equal(lab.seen(LENS, 32, sums=sums), lab.seen(LENS, 32))


OPENINGS: dict[str, dict[str, float]] = {
    "six blades": {"blades": 6, "blade_rotation_deg": 15.0},
    "three curved blades": {"blades": 3, "blade_curvature": 0.5},
    "cat's eye": {"cat_eye": 1.0},
    "bright rim": {"rim": 1.0},
    "five blades, squeezed": {"blades": 5, "squeeze": 2.0},
    "colours": {"axial_colour_mm": 0.6},
}


@pytest.mark.parametrize("depth_m", [1.1, 6.0])
@pytest.mark.parametrize("opening", OPENINGS.values(), ids=OPENINGS.keys())
def test_accumulated_lamp_is_disc_of_shaped_opening(
    lab: Lab, opening: dict[str, float], depth_m: float
) -> None:
    """Compare mean position and variance of both colors with those of the shape alone."""
    lens = replace(LENS, f_stop=1.4, **opening)
    lab.load(depth_m)
    light = lab.seen_in_colors(lens, VIEWS)
    radius = float(coc_px(depth_m, coc_line(lens, SIZE[0]))) / 2
    place = SIZE[0] / 2 + AT_PX[0], SIZE[1] / 2 + AT_PX[1]
    shape = DiscShape(lens.aperture, pixel_aspect_ratio=1.0, in_picture=PictureField.of(SIZE))
    y, x = np.mgrid[: SIZE[1], : SIZE[0]] + 0.5
    for color, radius_px in ((0, radius - axial_px(lens, SIZE[0]) / 2), (1, radius)):
        expected = shape.coverage(x - place[0], y - place[1], radius_px, 0.5, place)
        means, variances = spread(light[..., color].astype(np.float64))
        expected_means, expected_variances = spread(expected)
        np.testing.assert_allclose(means, expected_means, atol=0.15)
        # The lamp has a size of its own, and the shape a ramp all around.
        np.testing.assert_allclose(
            np.sqrt(variances), np.sqrt(expected_variances + (QUAD_PX**2 + 1) / 12), atol=0.12
        )
