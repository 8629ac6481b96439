"""Test the depth of a few pixels of a scene at any frame, without changing GPU state."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from heatlens.core.base.errors import InputError
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.framing import Framing
from heatlens.core.model.shot.settings import DefocusSettings, Method, Quality
from heatlens.core.model.shot.shot import Shot
from heatlens.media.plate.coc_line import depth_at_m
from heatlens.media.scene.scene import Scene
from heatlens.media.scene.scene_read import read_scene
from heatlens.render.frame_renderer import FrameRenderer, run_all_steps
from heatlens.render.gpu.textures import download
from support.session_files import write_scene

SIZE = (80, 48)
FRAMES = (1, 9, 17)


@pytest.fixture(scope="module")
def scene(tmp_path_factory) -> Scene:
    """Return a square that moves away, before another."""
    return read_scene(write_scene(tmp_path_factory.mktemp("scene") / "scene.glb"))


@pytest.fixture(scope="module")
def shot(scene) -> Shot:
    settings = DefocusSettings(quality=Quality.DRAFT, method=Method.ACCUMULATION, views=4)
    return Shot(Lens(50.0, 2.0, 3.0, 36.0), settings, framing=Framing(*SIZE))


@pytest.fixture(scope="module")
def loaded(session_context, scene) -> FrameRenderer:
    renderer = FrameRenderer(session_context)
    renderer.load_scene(scene)
    return renderer


@given(st.integers(0, SIZE[0] - 1), st.integers(0, SIZE[1] - 1), st.sampled_from(FRAMES))
def test_scene_depth_m_equals_depth_of_whole_image(loaded, shot, x, y, frame):
    plate = loaded.load_pinhole(shot, frame).plate
    depth_m = loaded.scene_depth_m(shot, frame, x, y)
    neighborhood_m = plate.depth_m[max(0, y - 3) : y + 4, max(0, x - 3) : x + 4]
    if np.ptp(np.where(np.isinf(neighborhood_m), 1e3, neighborhood_m)) < 0.1:  # no silhouette near
        assert depth_m == pytest.approx(depth_at_m(plate, x, y), rel=1e-6)
    else:
        assert np.isclose(neighborhood_m, depth_m, rtol=1e-6).any()


def test_scene_depth_m_grows_as_object_moves_away(loaded, shot):
    distances_m = [loaded.scene_depth_m(shot, frame, 40, 24) for frame in FRAMES]
    assert distances_m[0] < distances_m[1] < distances_m[2]


def test_scene_depth_m_leaves_loaded_image_unchanged(loaded, shot):
    """This holds between two views of one image as well, which all use its frame."""
    expected = loaded.pixels(shot, 1)
    renderer = FrameRenderer(loaded.ctx)
    renderer.load_scene(loaded.scene)
    loaded_before = renderer.load_pinhole(shot, 1)
    textures_before = download(loaded_before.color), download(loaded_before.depth)
    steps = renderer.steps(shot, 1)
    next(steps)
    assert renderer.scene_depth_m(shot, 17, 40, 24) > 3.5
    assert renderer.loaded is loaded_before
    np.testing.assert_array_equal(download(loaded_before.color), textures_before[0])
    np.testing.assert_array_equal(download(loaded_before.depth), textures_before[1])
    np.testing.assert_array_equal(download(run_all_steps(steps)), expected)


def test_scene_depth_m_outside_image_or_without_scene_raises_error(loaded, shot, ctx):
    with pytest.raises(InputError, match="Pixel 80,3 is outside the picture"):
        loaded.scene_depth_m(shot, 1, 80, 3)
    with pytest.raises(InputError, match="No scene"):
        FrameRenderer(ctx).scene_depth_m(shot, 1, 8, 3)
    tiny_shot = replace(shot, framing=replace(shot.framing, width_px=1, height_px=1))
    assert loaded.scene_depth_m(tiny_shot, 1, 0, 0) == pytest.approx(3.0, rel=1e-5)
