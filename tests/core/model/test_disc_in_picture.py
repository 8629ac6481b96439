"""Test discs in a picture: light, spread and shader uniforms, on both sides of focus."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from heatlens.core.model.lens import opening
from heatlens.core.model.lens.aperture import Aperture, shape_uniforms
from heatlens.core.model.lens.disc_shape import DiscShape, PictureField, field_variances
from heatlens.core.model.lens.opening import Barrel
from heatlens.core.model.lens.pupil import PINHOLE, Pupil
from support.opening_images import letter

SHAPES = [
    Aperture(blades=5, blade_rotation_deg=20.0),
    Aperture(blades=6, blade_curvature=0.5, rim=-0.7),
    Aperture(rim=0.6, squeeze=1.5),
    Aperture(cat_eye=0.8, stopped_down=1.3),
    Aperture(aperture_image=letter()),
    Aperture(squeeze=2.0),
]


@settings(max_examples=25)
@given(
    st.sampled_from(SHAPES),
    st.sampled_from([-20.0, 20.0]),
    st.sampled_from([1.0, 2.0]),
    st.floats(-100, 100),
)
def test_sum_of_disc_coverage_equals_disc_light(aperture, radius_px, aspect, offset_px):
    shape = DiscShape(aperture, pixel_aspect_ratio=aspect, in_picture=PictureField.of((200, 200)))
    y, x = np.mgrid[-50:51, -30:31] + 0.25
    position_px = (100.0 + offset_px, 100.0)
    total_coverage = shape.coverage(x, y, radius_px, 0.75, position_px).sum()
    assert total_coverage == pytest.approx(shape.light(radius_px, 0.75, position_px), rel=0.03)


@pytest.mark.parametrize("aperture", SHAPES)
def test_aperture_spreads_match_deviation_of_its_points(aperture):
    """Compare with the standard deviation of many points of the aperture, weighted by `rim`."""
    square = (np.stack(np.meshgrid(*[np.arange(300)] * 2), -1).reshape(-1, 2) + 0.5) / 300
    points = aperture.points(square) / aperture.half_extents
    for rim, spread in zip((-aperture.rim, aperture.rim), aperture.spreads, strict=True):
        weights = opening.profile(np.minimum((points**2).sum(axis=1), 1.0), rim)
        variance = ((points**2).sum(axis=1) * weights).sum() / weights.sum() / 2
        assert spread == pytest.approx(math.sqrt(4 * variance), rel=0.01)
    shape = DiscShape(aperture, 2.0)
    across, down = aperture.half_extents
    least = min(aperture.spreads)
    assert shape.spreads == pytest.approx((across * least, 2.0 * down * least))
    assert shape.side_variances == pytest.approx([spread**2 for spread in aperture.spreads])


@pytest.mark.parametrize("aperture", [a for a in SHAPES if a.aperture_image is None])
def test_points_of_shaped_aperture_are_covered_and_even(aperture):
    square = (np.stack(np.meshgrid(*[np.arange(200)] * 2), -1).reshape(-1, 2) + 0.5) / 200
    points = aperture.points(square * 0.998 + 0.001, 3.0)
    assert aperture.covers(*(points / 3.0).T).all()
    x, y = np.meshgrid(*[np.linspace(-1, 1, 401)] * 2)
    x, y = x * aperture.half_extents[0], y * aperture.half_extents[1]
    covered = aperture.covers(x, y)
    assert covered.mean() * 4 * np.prod(aperture.half_extents) == pytest.approx(
        aperture.area, rel=0.01
    )
    quarter = (points[:, 0] > 0) & (points[:, 1] > 0)
    assert quarter.mean() == pytest.approx(
        (covered & (x > 0) & (y > 0)).sum() / covered.sum(), abs=0.01
    )


def test_plain_disc_has_only_the_axes_uniform():
    uniform_disc = DiscShape(Aperture(squeeze=2.0), 1.5)
    assert uniform_disc.is_plain and uniform_disc.uniforms == {"aperture_axes": (0.5, 1.5)}
    assert not any(uniform_disc.switches.values()) and uniform_disc.wider_px == 0.0


def test_shaped_disc_uniforms_hold_shape_position_and_color():
    field = PictureField.of((60, 40), 2.0)
    aperture = Aperture(blades=6, cat_eye=0.5, stopped_down=1.2, rim=0.3)
    shape = DiscShape(aperture, pixel_aspect_ratio=2.0, in_picture=field, axial_px=-3.0)
    uniforms = shape.uniforms
    assert uniforms["aperture_axial_px"] == -3.0 and shape.wider_px == 3.0
    assert uniforms["aperture_blades"] == 6 and uniforms["aperture_rim"] == 0.3
    assert uniforms["aperture_lights"] == (aperture.light(-0.3), aperture.light(0.3))
    assert "aperture_image_scale" not in uniforms
    half, most = math.hypot(60, 20) / 2, 0.5 / 2 * 1.2
    assert uniforms["aperture_middle_px"] == (30, 20)
    assert uniforms["aperture_shift_per_px"] == pytest.approx((most / half, -most / half / 2))
    assert uniforms["aperture_shift_most"] == most and uniforms["aperture_barrel"] == 1.2
    assert field.uniforms(Aperture())["aperture_barrel"] == 0.0
    assert shape.switches == {"SHAPED": True, "COLORED": True, "IMAGED": False}
    assert DiscShape(axial_px=1.0).switches == shape.switches
    diffused = shape.diffusion_uniforms
    assert diffused["field_per_px"] == pytest.approx((1 / half, 1 / half / 2))
    assert diffused["field_middle_px"] == (30, 20)
    assert diffused["field_variances"] == field_variances(most, 1.2)
    assert diffused["side_variances"] == shape.side_variances


def test_scaled_or_moved_picture_keeps_disc_shape_at_each_pixel():
    shape = DiscShape(Aperture(cat_eye=0.5), 1.0, PictureField.of((60, 40)), axial_px=4.0)
    half = shape.scaled(0.5)
    assert half.axial_px == 2.0 and half.in_picture == PictureField.of((30, 20))
    moved = shape.moved((7.0, 5.0)).in_picture
    assert moved.middle_px == (37.0, 25.0)
    assert moved.half_diagonal_px == shape.in_picture.half_diagonal_px
    aperture, field = shape.aperture, shape.in_picture
    assert moved.barrel(aperture, (17.0, 9.0)) == field.barrel(aperture, (10.0, 4.0))


def test_field_variances_shrink_towards_picture_corner():
    steps = field_variances(0.6, 1.1)
    assert len(steps) == 9 and steps[0] == pytest.approx((1.0, 1.0), rel=1e-3)
    along, across = zip(*steps, strict=True)
    assert list(along) == sorted(along, reverse=True) and along[-1] < across[-1]
    expected = opening.variances(Barrel((0.6 * 5 / 8, 0.0), 1.1))
    assert steps[5] == pytest.approx((4 * expected[0], 4 * expected[1]))


def test_pupil_uniforms_and_extents_are_in_meters():
    pupil = Pupil(Aperture(blades=6, squeeze=2.0), 0.01)
    assert pupil.half_extents_m == (0.005, 0.01) and not pupil.is_plain
    assert pupil.switches == {"SHAPED": True, "IMAGED": False}
    assert Pupil(Aperture(aperture_image=letter()), 0.01).switches["IMAGED"]
    uniforms = pupil.uniforms((60, 40))
    assert uniforms["aperture_axes"] == (0.005, 0.01)
    shape = shape_uniforms(pupil.aperture)
    assert {name: uniforms[name] for name in shape} == shape
    assert uniforms["aperture_middle_px"] == (30, 20)
    assert PINHOLE.uniforms((60, 40)) == {"aperture_axes": (0.0, 0.0)} and PINHOLE.is_plain
    assert not any(PINHOLE.switches.values()) and PINHOLE.radius_m == 0.0
    square = np.random.default_rng(2).random((20, 2))
    np.testing.assert_array_equal(pupil.points_m(square), pupil.aperture.points(square, 0.01))
