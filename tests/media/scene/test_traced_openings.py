"""The ray tracer against accumulated views, for apertures of every kind."""

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from heatlens.core.model.focus.coc import coc_line
from heatlens.core.model.lens.disc_shape import DiscShape
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.camera_track import Pose
from heatlens.media.scene.scene_view import pupil_of, view_of
from heatlens.render.gpu.device import Device
from heatlens.render.gpu.textures import FloatArray, download, new_texture
from heatlens.render.scene_gpu.accumulation import Accumulation
from heatlens.render.scene_gpu.raster import SceneRaster
from heatlens.render.scene_gpu.ray_tracer import RayTracer
from support.opening_images import letter
from support.scenes import NIGHT, lamp, placement, scene_of, sphere

SIZE = (24, 16)
LENS = Lens(100.0, 1.4, 2.0, 36.0)


@pytest.fixture(scope="module")
def raster(session_context: Device) -> Iterator[SceneRaster]:
    """Return a raster of two large lamps, one in front of the focus and one behind it."""
    raster = SceneRaster(session_context)
    places = [(0, placement(0.12, 0.1, -1.4)), (0, placement(-0.4, -0.3, -5.0))]
    raster.load(scene_of([sphere(0.08, 3)], places, [lamp((8.0, 5.0, 3.0))], daylight=NIGHT))
    raster.place(1)
    yield raster
    raster.release()


@pytest.mark.parametrize(
    "opening",
    [
        {"blades": 3},
        {"blades": 5, "squeeze": 2.0},
        {"cat_eye": 1.0, "rim": -0.8},
        {"axial_colour_mm": 0.6},
        {"aperture_image": letter(), "cat_eye": 0.8, "axial_colour_mm": 0.3},
        {"cat_eye": 1.0, "rim": 0.8, "tilt_deg": 5.0, "tilt_direction_deg": 70.0},
    ],
)
def test_traced_openings_agree_with_accumulated_views(
    session_context: Device, raster: SceneRaster, opening: dict[str, Any]
) -> None:
    lens, rays = replace(LENS, **opening), 256
    view = view_of(Pose(), lens, SIZE, np.array([(-9, -9, -9.0), (9, 9, -0.1)]))
    pictures = []
    for method in (Accumulation(session_context, raster), RayTracer(session_context, raster)):
        out = new_texture(session_context, SIZE, 4)
        list(method.steps(view, pupil_of(lens), rays, out, "key"))
        pictures.append(download(out)[..., :3])
        method.release()
    views, traced = pictures
    assert views.max() > 1.0
    # Noise of independent rays: a few percent of the light of a lamp that half of them meet.
    assert np.abs(means_of_blocks(traced - views)).max() < 0.35
    np.testing.assert_allclose(traced.mean(axis=(0, 1)), views.mean(axis=(0, 1)), rtol=0.03)


@pytest.mark.parametrize("depth_m", [5.0, 1.25])
def test_accumulated_views_show_opening_image_as_disc_does(
    session_context: Device, depth_m: float
) -> None:
    """The image is upright behind the focus, turned by 180 degrees before it, never mirrored."""
    size, rim = (48, 32), 0.6
    lens = replace(LENS, f_stop=0.2, aperture_image=letter())
    raster = SceneRaster(session_context)
    lamps = [sphere(0.012 * depth_m, 3)], [(0, placement(0, 0, -depth_m))], [lamp((8.0, 8.0, 8.0))]
    raster.load(scene_of(*lamps, daylight=NIGHT))
    raster.place(1)
    view = view_of(Pose(), lens, size, np.array([(-9, -9, -9.0), (9, 9, -0.1)]))
    out = new_texture(session_context, size, 4)
    views = Accumulation(session_context, raster)
    list(views.steps(view, pupil_of(replace(lens, rim=rim)), 128, out, "rim"))
    light = float(download(out)[..., 1].sum())
    list(views.steps(view, pupil_of(lens), 128, out, "flat"))
    shown = download(out)[..., 1]
    assert light == pytest.approx(float(shown.sum()), rel=0.03)  # of a rim too
    for owned in (views, raster):
        owned.release()
    line = coc_line(lens, size[0])
    radius_px = (line.at_infinity_px + line.per_dioptre_px / depth_m) / 2
    y, x = np.mgrid[: size[1], : size[0]] + 0.5
    disc = DiscShape(lens.aperture)
    expected = disc.coverage(x - 24, y - 16, radius_px, 1.2)
    assert abs(radius_px) > 9 and np.corrcoef(shown.ravel(), expected.ravel())[0, 1] > 0.93
    for other in (expected[::-1, ::-1], expected[:, ::-1], expected[::-1]):
        assert np.corrcoef(shown.ravel(), other.ravel())[0, 1] < 0.8


def means_of_blocks(picture: FloatArray) -> FloatArray:
    """Return the means of blocks of 4 x 4 pixels."""
    height, width, _ = picture.shape
    return picture.reshape(height // 4, 4, width // 4, 4, 3).mean(axis=(1, 3))
