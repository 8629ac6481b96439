"""Compare the opening of the lens on the GPU with that on the processor and closed forms."""

from collections.abc import Iterator

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from heatlens.core.model.lens import opening
from heatlens.core.model.lens.aperture import Aperture
from heatlens.core.model.lens.disc_shape import DiscShape, PictureField
from heatlens.core.model.lens.pupil import Pupil
from heatlens.render.gpu.device import Device
from support.apertures import apertures
from support.shader_questions import ShaderQuestions

# What the library answers to one question (xy an offset or a point of the unit square, z the
# radius, w the ramp): a number for each of its functions.
_QUESTIONS = """
uniform vec2 place;
void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i >= uint(questions.length())) return;
    vec4 q = questions[i];
    answers[3u * i] = vec4(green_of(aperture_coverage(q.xy, q.z, q.w, place)),
                           green_of(aperture_light(q.z, q.w, place)),
                           float(is_one_pixel(q.z)), 0.0);
    answers[3u * i + 1u] = vec4(aperture_reach(q.z, q.w), aperture_variances(q.z));
    answers[3u * i + 2u] = vec4(aperture_point(q.xy), 0.0, 0.0);
#ifdef SHAPED
    Cover cover = aperture_coverage(q.xy, q.z, q.w, place), light = aperture_light(q.z, q.w, place);
    answers[3u * i] = vec4(cover.rb, light.rb);
    float weight = aperture_weight(q.xy / 200.0, place, q.z > 0.0);
    answers[3u * i + 1u] = vec4(cover.g, light.g, weight, 0.0);
#endif
}
"""
ROUNDS = 40
squeezes = st.floats(1.0, 2.0)
aspects = st.floats(0.25, 4.0)
seeds = st.integers(0, 2**32 - 1)


class ApertureOnGpu:
    """The functions of lib/aperture.lib.glsl, with an opening of any shape if SHAPED."""

    def __init__(self, ctx: Device, *defines: str) -> None:
        self._library = ShaderQuestions(
            ctx, "lib/aperture.lib.glsl", _QUESTIONS, dict.fromkeys(defines, 1), answers=3
        )

    def answers(
        self,
        shape: DiscShape | Pupil,
        questions: np.ndarray,
        place: tuple[float, float] = (0.0, 0.0),
    ) -> np.ndarray:
        """Return three answers (n, 3, 4), as `_QUESTIONS` writes them, for questions (n, 4).

        A question is an offset from the disc (2), its radius and its ramp, all in pixels; `place`
        is the position of the disc in the picture, in pixels.
        """
        uniforms = shape.uniforms((64, 64)) if isinstance(shape, Pupil) else shape.uniforms
        return self._library.ask(questions, uniforms | {"place": place})

    def release(self) -> None:
        self._library.release()


@pytest.fixture(scope="module")
def on_gpu(session_context: Device) -> Iterator[ApertureOnGpu]:
    gpu_aperture = ApertureOnGpu(session_context)
    yield gpu_aperture
    gpu_aperture.release()


@pytest.fixture(scope="module")
def shaped_on_gpu(session_context: Device) -> Iterator[ApertureOnGpu]:
    gpu_aperture = ApertureOnGpu(session_context, "SHAPED", "COLORED")
    yield gpu_aperture
    gpu_aperture.release()


@settings(max_examples=25)
@given(apertures(), aspects, st.floats(-20, 20), seeds)
def test_gpu_aperture_equals_cpu_for_every_shape(
    shaped_on_gpu: ApertureOnGpu, aperture: Aperture, aspect: float, axial_px: float, seed: int
) -> None:
    """Blades, barrel, rim and colours, anywhere in a picture and in discs of either side."""
    rng, field = np.random.default_rng(seed), PictureField.of((200, 120), aspect).moved((10, 5))
    disc = DiscShape(aperture, pixel_aspect_ratio=aspect, in_picture=field, axial_px=axial_px)
    place = tuple(np.float32(rng.uniform(0, (220, 130))).astype(float).tolist())
    radii = np.exp(rng.uniform(np.log(0.5), np.log(150.0), ROUNDS)) * rng.choice([-1, 1], ROUNDS)
    ramps = rng.uniform(0.5, 3.0, ROUNDS)
    offsets = 1.3 * rng.uniform(-1, 1, (ROUNDS, 2)) * np.abs(radii)[:, None]
    offsets *= np.array(disc.half_extents)
    questions = np.column_stack([offsets, radii, ramps]).astype(np.float32).astype(np.float64)
    gpu_results = shaped_on_gpu.answers(disc, questions, place)
    for (x, y, radius, ramp), (outer, green, _) in zip(questions, gpu_results, strict=True):
        for color, cover, light in ((-1, outer[0], outer[2]), (0, *green[:2]), (1, *outer[1::2])):
            color_radius = radius + color * axial_px / 2
            if abs(color_radius) < 0.1:
                continue
            # At a corner of the blades float32 may take the gradient of either edge.
            expected_cover = float(disc.coverage(x, y, color_radius, ramp, place))
            assert cover == pytest.approx(expected_cover, abs=2e-3)
            assert light == pytest.approx(disc.light(color_radius, ramp, place), rel=1e-2, abs=1e-2)
        barrel = field.barrel(aperture, place, aspect)
        expected = expected_weight_at(aperture, barrel, x / 200, y / 200, radius > 0)
        if expected is not None:
            assert green[2] == pytest.approx(expected, abs=1e-4)


def expected_weight_at(
    aperture: Aperture, barrel: opening.Barrel | None, x: float, y: float, is_behind: bool
) -> float | None:
    """Return by definition how much light passes a point; None for a point on the edge itself."""
    past = float(opening.past_blades(np.array(x), np.array(y), aperture.diaphragm)[0])
    if barrel is not None:
        past = max(past, float(opening.past_barrel(np.array(x), np.array(y), barrel)[0]))
    if abs(past) < 1e-5:
        return None
    rim = aperture.rim if is_behind else -aperture.rim
    return 0.0 if past > 0 else float(opening.profile(min(x * x + y * y, 1.0), rim))


@given(squeezes, aspects, seeds)
def test_gpu_aperture_equals_cpu_for_disc(
    on_gpu: ApertureOnGpu, squeeze: float, aspect: float, seed: int
) -> None:
    """At random offsets from discs of random radii and ramps, of either side of the focus."""
    rng, disc = np.random.default_rng(seed), DiscShape(Aperture(squeeze=squeeze), aspect)
    radii = np.exp(rng.uniform(np.log(0.1), np.log(200.0), ROUNDS)) * rng.choice([-1, 1], ROUNDS)
    ramps = rng.uniform(0.5, 3.0, ROUNDS)
    offsets = 1.3 * rng.uniform(-1, 1, (ROUNDS, 2)) * np.abs(radii)[:, None]
    offsets *= np.array(disc.half_extents)
    offsets[0] = 0.0  # the centre has a rule of its own
    questions = np.column_stack([offsets, radii, ramps]).astype(np.float32).astype(np.float64)
    gpu_results = on_gpu.answers(disc, questions)
    for (x, y, radius, ramp), (first, reach_variances, _) in zip(
        questions, gpu_results, strict=True
    ):
        assert first[0] == pytest.approx(float(disc.coverage(x, y, radius, ramp)), abs=2e-4)
        assert first[1] == pytest.approx(disc.light(radius, ramp), rel=1e-5)
        extents = np.abs(radius) * np.array(disc.half_extents)
        assert first[2] == (extents.max() <= 0.5)
        np.testing.assert_allclose(reach_variances[:2], extents + ramp, rtol=1e-5)
        np.testing.assert_allclose(
            reach_variances[2:], (radius * np.array(disc.spreads)) ** 2 / 4, rtol=1e-5
        )


@given(squeezes, st.floats(1e-3, 1.0), seeds)
def test_gpu_and_cpu_lens_points_lie_in_same_opening(
    on_gpu: ApertureOnGpu, squeeze: float, radius_m: float, seed: int
) -> None:
    """Both maps of the unit square keep areas; that of the GPU, for rays, is polar."""
    pupil = Pupil(Aperture(squeeze=squeeze), radius_m)
    square = np.random.default_rng(seed).random((64, 2)).astype(np.float32).astype(np.float64)
    questions = np.column_stack([square, np.ones(64), np.ones(64)])
    points_m = on_gpu.answers(pupil, questions)[:, 2, :2]
    u, v = (points_m / pupil.radius_m).T
    assert np.all(pupil.aperture.covers(0.99999 * u, 0.99999 * v))
    assert np.all(pupil.aperture.covers(*(0.99999 * pupil.points_m(square) / radius_m).T))
    round_u, round_v = (points_m / pupil.half_extents_m).T
    np.testing.assert_allclose(round_u**2 + round_v**2, square[:, 0], atol=1e-5)
    turns = np.exp(2j * np.pi * square[:, 1]) * np.sqrt(square[:, 0])
    np.testing.assert_allclose(round_u + 1j * round_v, turns, atol=1e-5)


@pytest.mark.parametrize("squeeze", [1.0, 1.33, 2.0])
def test_evenly_spaced_numbers_fill_aperture_evenly(on_gpu: ApertureOnGpu, squeeze: float) -> None:
    """Each cell of a grid over the aperture gets points in proportion to its open area."""
    side, pupil = 256, Pupil(Aperture(squeeze=squeeze), 1.0)
    at = (np.arange(side) + 0.5) / side
    square = np.stack(np.meshgrid(at, at), axis=-1).reshape(-1, 2)
    questions = np.column_stack([square, np.ones(side**2), np.ones(side**2)])
    across, up = pupil.half_extents_m
    box = [[-across, across], [-up, up]]
    fine = (2 * square - 1) * (across, up)
    cells = np.histogram2d(*fine[pupil.aperture.covers(*fine.T)].T, 8, box)[0]
    expected = cells / cells.sum() * side**2
    for points in (on_gpu.answers(pupil, questions)[:, 2, :2], pupil.points_m(square)):
        found = np.histogram2d(*points.T, 8, box)[0]
        np.testing.assert_allclose(found, expected, atol=0.06 * expected.max())
