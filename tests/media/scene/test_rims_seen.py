"""Test views and rays with an uneven aperture rim: light and uniform brightness are kept."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest

from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.camera_track import Pose
from heatlens.media.scene.scene_view import pupil_of, view_of
from heatlens.render.gpu.device import Device
from heatlens.render.gpu.textures import FloatArray, download, new_texture
from heatlens.render.scene_gpu.accumulation import Accumulation
from heatlens.render.scene_gpu.raster import SceneRaster
from heatlens.render.scene_gpu.ray_tracer import RayTracer
from support.scenes import NIGHT, lamp, placement, scene_of, sphere

SIZE = (32, 24)
LENS = Lens(100.0, 1.4, 2.0, 36.0)
NEAR_LAMP = (0, placement(0.02, 0.0, -1.5))  # about as large as its disc
FAR_LAMP = (0, placement(-0.05, 0.0, -3.0))


@pytest.fixture
def raster(session_context: Device) -> Iterator[SceneRaster]:
    raster = SceneRaster(session_context)
    yield raster
    raster.release()


def render_lamps(
    raster: SceneRaster,
    kind: type[Accumulation] | type[RayTracer],
    lens: Lens,
    views: int,
    *places: tuple[int, np.ndarray],
) -> FloatArray:
    raster.load(scene_of([sphere(0.1, 3)], places, [lamp((1.0, 1.0, 1.0))], daylight=NIGHT))
    raster.place(1)
    view = view_of(Pose(), lens, SIZE, np.array([(-9, -9, -9.0), (9, 9, -0.1)]))
    method, out = kind(raster._ctx, raster), new_texture(raster._ctx, SIZE, 4)
    list(method.steps(view, pupil_of(lens), views, out, "key"))
    method.release()
    return download(out)[..., :3]


@pytest.mark.parametrize("rim", [-0.8, 0.8])
def test_rim_keeps_light_of_lamp_before_and_behind_focus(raster: SceneRaster, rim: float) -> None:
    for place in (NEAR_LAMP, FAR_LAMP):
        flat, rimmed = (
            render_lamps(raster, Accumulation, replace(LENS, rim=r), 128, place) for r in (0.0, rim)
        )
        assert rimmed.sum() == pytest.approx(flat.sum(), rel=0.03)
        assert np.abs(rimmed - flat).max() > 0.05


@pytest.mark.parametrize("kind", [Accumulation, RayTracer])
def test_rim_keeps_uniform_brightness(
    raster: SceneRaster, kind: type[Accumulation] | type[RayTracer]
) -> None:
    """Lamps as bright as the wall behind them cannot be seen, whatever the rim."""
    lens, wall = replace(LENS, rim=0.8), (0, placement(0.0, 0.0, -15.0, 100.0))
    picture = render_lamps(raster, kind, lens, 16, wall, NEAR_LAMP, FAR_LAMP)
    np.testing.assert_allclose(picture, 1.0, atol=1e-4)
