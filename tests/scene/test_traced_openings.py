"""Rays through openings of every kind, against the same openings accumulated."""

from collections.abc import Iterator
from dataclasses import replace

import moderngl
import numpy as np
import pytest

from heatlens.gpu.textures import FloatArray, download, new_texture
from heatlens.model.framing import Pose
from heatlens.model.lens import Lens
from heatlens.scene.scene_view import pupil_of, view_of
from heatlens.scene_gpu.accumulation import Accumulation
from heatlens.scene_gpu.raster import SceneRaster
from heatlens.scene_gpu.ray_tracer import RayTracer
from support.scenes import NIGHT, lamp, moved, scene_of, sphere

SIZE = (24, 16)
LENS = Lens(100.0, 1.4, 2.0, 36.0)


@pytest.fixture(scope="module")
def raster(session_context: moderngl.Context) -> Iterator[SceneRaster]:
    """Large lamps in front of the focus and behind it."""
    held = SceneRaster(session_context)
    places = [(0, moved(0.12, 0.1, -1.4)), (0, moved(-0.4, -0.3, -5.0))]
    held.load(scene_of([sphere(0.08, 3)], places, [lamp((8.0, 5.0, 3.0))], daylight=NIGHT))
    held.place(1)
    yield held
    held.release()


@pytest.mark.parametrize(
    "opening",
    [
        {"blades": 3},
        {"blades": 5, "squeeze": 2.0},
        {"cat_eye": 1.0, "rim": -0.8},
        {"axial_colour_mm": 0.6},
    ],
)
def test_rays_agree_with_views(
    session_context: moderngl.Context, raster: SceneRaster, opening: dict[str, float]
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
    assert np.abs(smoothed(traced - views)).max() < 0.35
    np.testing.assert_allclose(traced.mean(axis=(0, 1)), views.mean(axis=(0, 1)), rtol=0.03)


def smoothed(picture: FloatArray) -> FloatArray:
    """Return the means of blocks of 4 x 4 pixels."""
    height, width, _ = picture.shape
    return picture.reshape(height // 4, 4, width // 4, 4, 3).mean(axis=(1, 3))
