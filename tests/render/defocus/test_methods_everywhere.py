"""All methods, those that draw scenes included: odd picture sizes, and conservation of light."""

from dataclasses import replace

import numpy as np
import pytest

from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.camera_track import CameraTrack, Pose, PoseKey
from heatlens.core.model.shot.framing import Framing
from heatlens.core.model.shot.settings import DefocusSettings, Method
from heatlens.core.model.shot.shot import Shot
from heatlens.media.scene.material import Material
from heatlens.media.scene.scene import SceneCamera
from heatlens.render.frame_renderer import FrameRenderer
from support.scenes import NIGHT, lamp, placement, plane, scene_of, still_life

LENS = Lens(50.0, 2.0, 2.0, 36.0)
AHEAD = SceneCamera("ahead", CameraTrack((PoseKey(1, Pose((0.0, 0.0, 0.0))),)), 50.0, 36.0)
METHODS = list(Method)


def shot_of(size: tuple[int, int], method: Method, views: int) -> Shot:
    return Shot(LENS, DefocusSettings(method=method, views=views), framing=Framing(*size))


@pytest.fixture(scope="module")
def still(session_context) -> FrameRenderer:
    renderer = FrameRenderer(session_context)
    renderer.load_scene(still_life())
    return renderer


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("size", [(1, 1), (7, 3), (1, 33), (1031, 5)])
def test_picture_of_any_size_is_finite_and_opaque(ctx, still, size, method):
    picture = still.pixels(shot_of(size, method, 4), 1)
    assert picture.shape == (size[1], size[0], 4)
    assert np.isfinite(picture).all() and picture[..., :3].min() >= 0.0
    np.testing.assert_array_equal(picture[..., 3], 1.0)


@pytest.mark.parametrize("method", METHODS)
def test_blur_keeps_light_of_lamp_on_dark_wall(ctx, method):
    """Compare the light with the pinhole picture's; the wall at its depth hides nothing."""
    parts = [(0, placement(z=-6.0)), (1, placement(z=-5.999))]
    materials = [Material(base_color=(0.0, 0.0, 0.0)), lamp((8.0, 4.0, 2.0))]
    meshes = [plane(30.0, "z", 0), plane(0.2, "z", 1)]
    renderer = FrameRenderer(ctx)
    scene = scene_of(meshes, parts, materials, daylight=NIGHT)
    renderer.load_scene(replace(scene, cameras=(AHEAD,)))
    shot = shot_of((96, 64), method, 256)
    light = renderer.pixels(shot, 1)[..., :3].sum(axis=(0, 1), dtype=np.float64)
    before = renderer.load_pinhole(shot, 1).plate.color[..., :3].sum(axis=(0, 1), dtype=np.float64)
    assert before.min() > 50.0
    np.testing.assert_allclose(light, before, rtol=0.02)
