"""Opening one scene after another gives back what the one before held on the GPU."""

import pytest

from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.framing import Framing
from heatlens.core.model.shot.settings import DefocusSettings, Method, Quality
from heatlens.core.model.shot.shot import Shot
from heatlens.render.frame_renderer import FrameRenderer
from support.scenes import still_life


@pytest.mark.parametrize("method", [Method.DIFFUSION, Method.ACCUMULATION, Method.RAYTRACED])
def test_loading_scene_releases_images_of_previous_scene(ctx, method):
    scene, renderer = still_life(), FrameRenderer(ctx)
    settings = DefocusSettings(quality=Quality.DRAFT, method=method, views=2)
    shot = Shot(Lens(50, 2, 3, 36), settings, framing=Framing(48, 27))
    renderer.load_scene(scene)
    first = renderer.pixels(shot, 1)
    before = renderer.loaded
    renderer.load_scene(scene)
    assert before.color.is_released
    assert before.depth.is_released
    assert (renderer.pixels(shot, 1) == first).all()
    assert ctx.error == ""
