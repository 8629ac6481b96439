"""Focus breathing: a plate is cropped or scaled; cameras and headers get the effective length."""

from dataclasses import replace

import numpy as np
import pytest

from heatlens.core.model.curves.frames import FrameRange
from heatlens.core.model.lens.breathing import view_ratio
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.lens_parameter import LensParameter
from heatlens.core.model.shot.settings import Bokeh, DefocusSettings, Quality
from heatlens.core.model.shot.shot import Shot
from heatlens.media.plate.of_arrays import plate_of_arrays
from heatlens.media.plate.picture.picture_write import lens_header
from heatlens.render.frame_renderer import FrameRenderer
from heatlens.render.source.named import camera_of_shot

PINHOLE = Lens(50.0, 1e5, 0.5, 36.0, close_focus_m=0.5)
QUICK = DefocusSettings(bokeh=Bokeh.HEAT, quality=Quality.DRAFT, layers=1)
HEIGHT, WIDTH = 48, 80


@pytest.fixture(scope="module")
def renderer(session_context):
    return FrameRenderer(session_context)


def gradient() -> np.ndarray:
    """Return (H, W, 3): red is x and green is y, from the middle of the picture."""
    y, x = np.mgrid[:HEIGHT, :WIDTH].astype(np.float32) + 0.5
    return np.dstack([10 + x - WIDTH / 2 + WIDTH, 10 + y - HEIGHT / 2 + HEIGHT, np.ones_like(x)])


def render_gradient(renderer, lens: Lens) -> np.ndarray:
    renderer.load(plate_of_arrays(gradient(), np.full((HEIGHT, WIDTH), 0.5, np.float32)))
    return renderer.pixels(Shot(lens, QUICK))


@pytest.mark.parametrize("ratio", [0.9, 0.75])
def test_breathing_crops_plate_about_its_middle(renderer, ratio):
    still = render_gradient(renderer, PINHOLE)
    cut = render_gradient(renderer, replace(PINHOLE, breathing=ratio))
    for channel in (0, 1):
        middle = float(still[..., channel].mean())
        expected = middle + ratio * (still[..., channel] - middle)
        np.testing.assert_allclose(cut[4:-4, 4:-4, channel], expected[4:-4, 4:-4], atol=2e-2)


def test_breathing_at_infinity_changes_nothing(renderer):
    far = replace(PINHOLE, focus_distance_m=float("inf"))
    np.testing.assert_array_equal(
        render_gradient(renderer, replace(far, breathing=0.9)), render_gradient(renderer, far)
    )


def test_breathing_above_one_enlarges_picture_at_infinity(renderer):
    far = replace(PINHOLE, focus_distance_m=float("inf"), breathing=1.1)
    still, enlarged = render_gradient(renderer, PINHOLE), render_gradient(renderer, far)
    middle = float(still[..., 0].mean())
    expected = middle + (still[..., 0] - middle) / 1.1
    np.testing.assert_allclose(enlarged[4:-4, 4:-4, 0], expected[4:-4, 4:-4], atol=2e-2)
    at_close = replace(far, focus_distance_m=0.5)
    np.testing.assert_array_equal(render_gradient(renderer, at_close), still)


def test_camera_of_breathing_lens_has_effective_focal_lengths():
    shot = Shot(Lens(50.0, 2.0, 2.0, 36.0, close_focus_m=0.5, breathing=0.9))
    shot = shot.with_key(1, LensParameter.FOCUS_DISTANCE, 0.5)
    shot = shot.with_key(11, LensParameter.FOCUS_DISTANCE, 5.0)
    camera = camera_of_shot(shot, "c", FrameRange(1, 11), sensor_height_mm=24.0)
    lengths = [50.0 / view_ratio(shot.lens_at(frame)) for frame in range(1, 12)]
    assert camera.focal_length_mm == pytest.approx(lengths)
    assert lengths[0] == pytest.approx(50 / 0.9) and lengths == sorted(lengths, reverse=True)
    openings = [mm / n for mm, n in zip(camera.focal_length_mm, camera.f_stop, strict=True)]
    assert openings == pytest.approx([25.0] * 11)


def test_header_of_breathing_lens_has_effective_focal_length():
    plate = plate_of_arrays(gradient(), np.full((HEIGHT, WIDTH), 0.5, np.float32))
    header = lens_header(plate, replace(PINHOLE, breathing=0.8))
    assert header["pinholeFocalLength"] == pytest.approx(62.5)
