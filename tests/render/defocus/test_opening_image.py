"""An image as the lens opening: Python against GLSL, and both against the expected properties."""

from collections.abc import Iterator

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from heatlens.core.model.lens.aperture import Aperture
from heatlens.core.model.lens.disc_shape import DiscShape, PictureField
from heatlens.core.model.lens.opening_image import IMAGE_SIDE, ImageGrid, OpeningImage
from heatlens.render.gpu.device import Device
from heatlens.render.gpu.textures import OpeningTextures
from support.opening_images import image_of, letter, opening_images
from support.shader_questions import ShaderQuestions

Array = NDArray[np.float64]
# xy an offset or a point of the unit square, z the radius, w the ramp
_QUESTIONS = """
uniform vec2 place;
void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i >= uint(questions.length())) return;
    vec4 q = questions[i];
    answers[i] = vec4(aperture_coverage(q.xy, q.z, q.w, place).g, aperture_light(q.z, q.w, place).g,
                      image_point(q.xy));
}
"""
COUNT = 16
seeds = st.integers(0, 2**32 - 1)
rotations = st.sampled_from((0.0, 37.0, -90.0))


class ImageOnGpu:
    """The functions of lib/aperture.lib.glsl for an opening with an image."""

    def __init__(self, ctx: Device) -> None:
        self._textures = OpeningTextures(ctx)
        defines = {"SHAPED": 1, "IMAGED": 1}
        self._library = ShaderQuestions(ctx, "lib/aperture.lib.glsl", _QUESTIONS, defines)

    def answers(self, disc: DiscShape, questions: Array, place: tuple[float, float]) -> Array:
        """Return coverage, light and a point of the opening (n, 4) for questions (n, 4).

        A question is an offset from the disc (2), its radius and its ramp, all in pixels; `place`
        is the position of the disc in the picture, in pixels.
        """
        textures = self._textures.of(disc.aperture)
        return self._library.ask(questions, disc.uniforms | {"place": place}, textures)[:, 0]

    def release(self) -> None:
        self._textures.release()
        self._library.release()


@pytest.fixture(scope="module")
def on_gpu(session_context: Device) -> Iterator[ImageOnGpu]:
    image_on_gpu = ImageOnGpu(session_context)
    yield image_on_gpu
    image_on_gpu.release()


@settings(max_examples=8)
@given(opening_images(), rotations, st.sampled_from((0.0, 0.6)), st.floats(-1, 1), seeds)
def test_opening_image_in_glsl_agrees_with_python(
    on_gpu: ImageOnGpu, image: OpeningImage, rotation: float, cat_eye: float, rim: float, seed: int
) -> None:
    """Compare coverage, light and points for discs of either sign and radii of 0.5 to 300 px."""
    rng = np.random.default_rng(seed)
    aperture = Aperture(
        squeeze=1.5, rim=rim, blade_rotation_deg=rotation, cat_eye=cat_eye, aperture_image=image
    )
    disc = DiscShape(aperture, pixel_aspect_ratio=1.2, in_picture=PictureField.of((200, 120), 1.2))
    position_px = tuple(np.float32(rng.uniform(0, (200, 120))).astype(float).tolist())
    radii = np.exp(rng.uniform(np.log(0.5), np.log(300.0), COUNT)) * rng.choice([-1, 1], COUNT)
    square, ramps = rng.random((COUNT, 2)), rng.uniform(0.5, 3.0, COUNT)
    offsets = (2.4 * square - 1.2) * np.abs(radii)[:, None] * disc.half_extents
    questions = np.column_stack([offsets, radii, ramps]).astype(np.float32).astype(np.float64)
    answers = on_gpu.answers(disc, questions, position_px)
    brightest = max(float(aperture.grid.cells.max()), 1.0) * 3  # that of a bright rim
    for (x, y, radius, ramp), (cover, light, _, _) in zip(questions, answers, strict=True):
        expected = float(disc.coverage(x, y, radius, ramp, position_px))
        assert cover == pytest.approx(expected, rel=5e-3, abs=2e-3 * brightest)
        area = radius**2 * 1.2 / 1.5
        assert light / area == pytest.approx(disc.light(radius, ramp, position_px) / area, abs=0.06)
    questions[:, :2] = square
    points = on_gpu.answers(disc, questions, position_px)[:, 2:]
    assert_cdf(aperture.grid, points, square)
    assert_cdf(aperture.grid, aperture.points(square) * (1.5, 1.0), square)


def assert_cdf(grid: ImageGrid, points: Array, square: Array) -> None:
    """Check that a point's coordinates are the shares of light above and left of it."""
    cells = grid.cells
    column, row = (points * (1, -1) + 1).T * IMAGE_SIDE / 2
    for x, y, (expected_x, expected_y) in zip(column, row, square, strict=True):
        # Between rows without light float32 may stand on either side of a line.
        j = next(j for j in (int(y), int(y - 1e-3), int(y + 1e-3)) if cells[j].any())
        above = cells[:j].sum() + (y - j) * cells[j].sum()
        i = min(int(x), IMAGE_SIDE - 1)
        left = cells[j, :i].sum() + (x - i) * cells[j, i]
        assert above / cells.sum() == pytest.approx(expected_y, abs=1e-4)
        assert left / cells[j].sum() == pytest.approx(expected_x, abs=1e-3)


@settings(max_examples=8)
@given(opening_images(), seeds)
def test_image_grid_points_follow_light_of_image(image: OpeningImage, seed: int) -> None:
    """Check that each sixteenth of the bounding box gets the share of points of its light."""
    grid = image.grid()
    at = (np.arange(128) + np.random.default_rng(seed).random()) / 128
    square = np.stack(np.meshgrid(at, at), axis=-1).reshape(-1, 2)
    x, y = grid.points(square).T
    point_shares = np.histogram2d(-y, x, 4, [[-1, 1], [-1, 1]])[0] / len(square)
    light = grid.cells.reshape(4, 64, 4, 64).sum(axis=(1, 3))
    np.testing.assert_allclose(point_shares, light / light.sum(), atol=0.015)


@settings(max_examples=10)
@given(
    opening_images(),
    st.floats(0.3, 60.0),
    st.sampled_from((-1, 1)),
    st.floats(-0.5, 0.5),
    st.floats(-0.5, 0.5),
)
def test_coverage_of_image_disc_sums_to_disc_light(
    image: OpeningImage, radius_px: float, side: int, x_px: float, y_px: float
) -> None:
    """Check the sum of the coverage for any subpixel position of the center."""
    disc = DiscShape(Aperture(aperture_image=image))
    y, x = np.mgrid[-62:63, -62:63]
    total = float(disc.coverage(x + x_px, y + y_px, side * radius_px, 0.5).sum())
    assert total == pytest.approx(disc.light(radius_px, 0.5), rel=1e-9)
    assert disc.light(radius_px, 0.5) == pytest.approx(np.pi * radius_px**2)


def test_white_opening_image_equals_round_opening() -> None:
    white, plain = DiscShape(Aperture(aperture_image=image_of(np.ones((2, 2))))), DiscShape()
    y, x = np.mgrid[-60:61, -60:61]
    for radius in (3.0, 20.0, 55.0):
        coverage, expected = (disc.coverage(x, y, radius, 0.5) for disc in (white, plain))
        np.testing.assert_allclose(coverage, expected, atol=0.16)  # at the rim: a box and a ramp
        assert np.abs(coverage - expected).mean() < 2e-3
    np.testing.assert_allclose(white.aperture.spreads, 1.0, rtol=1e-3)


def test_opening_image_is_upright_behind_focus_and_rotated_before_it() -> None:
    """Check both orientations; rows of the image and offsets of the disc both run downwards."""
    image = letter()
    disc = DiscShape(Aperture(aperture_image=image))
    assert image.light is not None
    y, x = np.mgrid[0:64, 0:64] * 1.0 - 31.5
    behind, front = (disc.coverage(x, y, radius, 0.5) for radius in (32.0, -32.0))
    image_light = image.light.reshape(64, 4, 64, 4).mean(axis=(1, 3))
    np.testing.assert_allclose(behind > 0, image_light > 0)
    np.testing.assert_allclose(front, behind[::-1, ::-1], atol=1e-9)


def test_opening_image_turns_counterclockwise_with_blade_rotation() -> None:
    """Check the counterclockwise turn: a mark on top is at the left after 90 degrees."""
    top = np.zeros((8, 8), np.float32)
    top[1, 3:5] = 1.0
    for degrees, (x, y) in ((0, (0, -1)), (90, (-1, 0)), (-90, (1, 0)), (180, (0, 1))):
        disc = DiscShape(Aperture(blade_rotation_deg=degrees, aperture_image=image_of(top)))
        lit = [float(disc.coverage(70 * a, 70 * b, 100.0, 0.5)) for a, b in ((x, y), (-x, -y))]
        assert lit[0] > 1.0 and lit[1] == 0.0


def test_opening_image_overrides_blades() -> None:
    image = letter()
    y, x = np.mgrid[-20:21, -20:21]
    alone, both = (
        DiscShape(Aperture(blades=blades, blade_curvature=0.3, aperture_image=image))
        for blades in (0, 5)
    )
    np.testing.assert_array_equal(alone.coverage(x, y, 9.0, 0.5), both.coverage(x, y, 9.0, 0.5))
    assert alone.light(9.0, 0.5) == both.light(9.0, 0.5)
    assert alone.spreads == both.spreads


def test_opening_textures_are_reused_until_unused(session_context: Device) -> None:
    """Check that two alternating openings upload nothing, and that unused textures are dropped."""
    textures = OpeningTextures(session_context)
    one, other = (Aperture(aperture_image=letter(), blade_rotation_deg=d) for d in (0.0, 5.0))
    first, second = textures.of(one), textures.of(other)
    assert first != second
    assert textures.of(one) == first and textures.of(other) == second
    assert textures.of(Aperture(aperture_image=letter(), rim=0.5)) == first
    assert textures.of(Aperture(squeeze=5.0 / 4)) == {}
    for degrees in range(10, 15):
        textures.of(Aperture(aperture_image=letter(), blade_rotation_deg=float(degrees)))
    assert textures.of(one)["aperture_image_tx"] is not first["aperture_image_tx"]
    textures.release()
