"""The depth of a few pixels of a scene at any frame: a cut of the whole; nothing is disturbed."""

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
from heatlens.render.frame_renderer import FrameRenderer, drained
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
def test_it_is_what_a_click_on_the_whole_picture_finds(loaded, shot, x, y, frame):
    plate = loaded.look(shot, frame).plate
    found = loaded.scene_depth_m(shot, frame, x, y)
    around = plate.depth_m[max(0, y - 3) : y + 4, max(0, x - 3) : x + 4]
    if np.ptp(np.where(np.isinf(around), 1e3, around)) < 0.1:  # no silhouette near
        assert found == pytest.approx(depth_at_m(plate, x, y), rel=1e-6)
    else:
        assert np.isclose(around, found, rtol=1e-6).any()


def test_the_square_moves_away(loaded, shot):
    distances_m = [loaded.scene_depth_m(shot, frame, 40, 24) for frame in FRAMES]
    assert distances_m[0] < distances_m[1] < distances_m[2]


def test_what_is_on_the_gpu_stays(loaded, shot):
    """Also between two views of one picture, all of which see the things at its frame."""
    expected = loaded.pixels(shot, 1)
    again = FrameRenderer(loaded.ctx)
    again.load_scene(loaded.scene)
    held = again.look(shot, 1)
    before = download(held.color), download(held.depth)
    steps = again.steps(shot, 1)
    next(steps)
    assert again.scene_depth_m(shot, 17, 40, 24) > 3.5
    assert again.loaded is held
    np.testing.assert_array_equal(download(held.color), before[0])
    np.testing.assert_array_equal(download(held.depth), before[1])
    np.testing.assert_array_equal(download(drained(steps)), expected)


def test_beside_the_picture_and_without_a_scene_there_is_none(loaded, shot, ctx):
    with pytest.raises(InputError, match="Pixel 80,3 is outside the picture"):
        loaded.scene_depth_m(shot, 1, 80, 3)
    with pytest.raises(InputError, match="No scene"):
        FrameRenderer(ctx).scene_depth_m(shot, 1, 8, 3)
    small = replace(shot, framing=replace(shot.framing, width_px=1, height_px=1))
    assert loaded.scene_depth_m(small, 1, 0, 0) == pytest.approx(3.0, rel=1e-5)
