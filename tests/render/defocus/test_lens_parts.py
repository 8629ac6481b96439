"""Sub-apertures of an opening have together the light, middle and variance of the whole opening."""

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from heatlens.core.model.lens.aperture import Aperture
from heatlens.core.model.lens.disc_shape import DiscShape, PictureField
from heatlens.core.model.shot.settings import PARTS
from heatlens.render.defocus.lens_parts import lens_parts, part_centers
from heatlens.render.gpu.shader_constants import PART_GRID_SIDE
from support.opening_images import letter, opening_images

SIZE = 480, 270
MOST = PARTS[-1]
OPENINGS = (
    Aperture(blades=3),
    Aperture(blades=6, blade_rotation_deg=15.0, blade_curvature=0.5, squeeze=1.5),
    Aperture(rim=0.8),
    Aperture(rim=-0.8, blades=5),
    Aperture(cat_eye=0.9),
    Aperture(cat_eye=0.5, stopped_down=1.5, rim=0.5, blades=7),
    Aperture(aperture_image=letter(), blade_rotation_deg=30.0),
    Aperture(aperture_image=letter(), cat_eye=0.6, squeeze=2.0),
)


def disc_of(aperture: Aperture) -> DiscShape:
    return DiscShape(aperture, in_picture=PictureField.of(SIZE))


def sample_opening(
    disc: DiscShape, position_px: tuple[float, float]
) -> tuple[np.ndarray, np.ndarray]:
    """Return the opening's middle and variances in pixels for each pixel of coc, finely sampled."""
    along = (np.arange(400) + 0.5) / 200 - 1
    x, y = (of.ravel() for of in np.meshgrid(along * disc.half_extents[0], -along))
    light = disc.coverage(x, y, 1.0, 0.005, position_px)
    points = np.stack([x, y], 1) / 2
    middle = np.average(points, axis=0, weights=light)
    return middle, np.average((points - middle) ** 2, axis=0, weights=light)


@pytest.mark.parametrize("parts", PARTS)
def test_part_centers_have_mean_and_variance_of_round_opening(parts):
    centers = part_centers(parts)
    assert centers.shape == (parts, 2)
    np.testing.assert_allclose(centers.mean(0), 0, atol=1e-12)
    own = np.eye(2) / (4 * parts)
    np.testing.assert_allclose(centers.T @ centers / parts + own, np.eye(2) / 4, atol=1e-12)


@pytest.mark.parametrize("parts", PARTS)
def test_lens_parts_of_plain_opening_have_equal_area(parts):
    sub_apertures = lens_parts(disc_of(Aperture(squeeze=2.0)), SIZE, parts)
    assert sub_apertures.shape == (parts, 1, 4)
    np.testing.assert_allclose(
        sub_apertures[:, 0, :2], part_centers(parts) * (0.25, -0.5), atol=1e-12
    )
    np.testing.assert_allclose(
        sub_apertures[:, 0, 2:], [(parts**-0.5, 1 / parts)] * parts, rtol=1e-12
    )


@pytest.mark.parametrize("number", range(len(OPENINGS)))
def test_lens_parts_keep_mean_and_variance_of_shaped_opening(number):
    disc = disc_of(OPENINGS[number])
    sub_apertures = lens_parts(disc, SIZE, MOST)
    corners = [0, PART_GRID_SIDE - 1, PART_GRID_SIDE**2 - 1] if sub_apertures.shape[1] > 1 else [0]
    for k in corners:
        position_px = SIZE[0] * (k % PART_GRID_SIDE) / 8, SIZE[1] * (k // PART_GRID_SIDE) / 8
        center, width, light = (
            sub_apertures[:, k, :2],
            sub_apertures[:, k, 2],
            sub_apertures[:, k, 3],
        )
        middle, variances = sample_opening(disc, position_px)
        mean_center = np.average(center, axis=0, weights=light)
        np.testing.assert_allclose(mean_center, middle, atol=0.015)
        spread = np.average((center - mean_center) ** 2, axis=0, weights=light)
        inside = np.average(width**2, weights=light) / 16 * np.square(disc.half_extents)
        np.testing.assert_allclose((spread + inside).sum(), variances.sum(), rtol=0.06)


@settings(max_examples=40)  # each computes the parts at all places of a picture
@given(opening_images(), st.sampled_from((0.0, 0.7)), st.floats(-0.9, 0.9), st.sampled_from(PARTS))
def test_light_of_lens_parts_sums_to_one(image, cat_eye, rim, parts):
    aperture = Aperture(aperture_image=image, cat_eye=cat_eye, rim=rim)
    sub_apertures = lens_parts(disc_of(aperture), SIZE, parts)
    assume(len(sub_apertures))
    assert np.isfinite(sub_apertures).all() and (sub_apertures[..., 2:] >= 0).all()
    np.testing.assert_allclose(sub_apertures[..., 3].sum(axis=0), 1.0, rtol=1e-9)


def test_lens_parts_leaves_out_dark_parts():
    sub_apertures = lens_parts(disc_of(Aperture(aperture_image=letter())), SIZE, MOST)
    assert 1 < len(sub_apertures) < MOST


def test_lens_parts_of_cat_eye_narrow_in_corners_and_round_in_middle():
    found = lens_parts(disc_of(Aperture(cat_eye=0.9)), SIZE, MOST)
    along, across = np.array([SIZE, (-SIZE[1], SIZE[0])]) / np.hypot(*SIZE)

    def ratio(place: int) -> float:
        wide = [
            np.average((found[:, place, :2] @ way) ** 2, weights=found[:, place, 3])
            for way in (along, across)
        ]
        return wide[0] / wide[1]

    assert ratio(PART_GRID_SIDE**2 // 2) == pytest.approx(1.0, abs=0.01)
    assert ratio(0) == pytest.approx(ratio(PART_GRID_SIDE**2 - 1)) and ratio(0) < 0.8
