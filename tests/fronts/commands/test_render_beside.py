"""Test two renderers in one OpenGL context, whose alternating steps must not disturb each other."""

from dataclasses import replace

import numpy as np
import pytest

from heatlens.core.base.errors import InputError
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.framing import Framing
from heatlens.core.model.shot.settings import DefocusSettings, Method, Quality
from heatlens.core.model.shot.shot import Shot
from heatlens.render.frame_renderer import FrameRenderer
from support.plates import lens_blurring, plate_of, room
from support.scenes import still_life

SHOT = Shot(lens_blurring(8.0, 96), DefocusSettings(quality=Quality.DRAFT))


@pytest.fixture
def renderers(ctx):
    first_renderer = FrameRenderer(ctx)
    return first_renderer, first_renderer.make_sibling()


def _plates():
    color, depth = room(96, 64)
    return plate_of(color, depth), plate_of(np.ascontiguousarray(color[::-1]), depth)


def _alternate_steps(*step_generators):
    """Run several renderings by turns, one step of each. Return their pictures as flat arrays."""
    pictures = [None] * len(step_generators)
    while any(picture is None for picture in pictures):
        for index, steps in enumerate(step_generators):
            if pictures[index] is None:
                try:
                    next(steps)
                except StopIteration as end:
                    pictures[index] = np.frombuffer(end.value.read(), np.float32)
    return pictures


def test_alternating_steps_of_two_renderers_give_same_pictures(renderers):
    first_renderer, second_renderer = renderers
    first_plate, second_plate = _plates()
    first_renderer.load(first_plate)
    expected = first_renderer.pixels(SHOT)
    second_renderer.load(second_plate)
    expected_other = second_renderer.pixels(SHOT)
    assert not np.array_equal(expected, expected_other)
    pictures = _alternate_steps(first_renderer.steps(SHOT), second_renderer.steps(SHOT))
    np.testing.assert_array_equal(pictures[0], expected.ravel())
    np.testing.assert_array_equal(pictures[1], expected_other.ravel())


def test_plate_loaded_in_bands_renders_same_picture(renderers, monkeypatch):
    monkeypatch.setattr("heatlens.render.gpu.textures._BAND_BYTES", 1000)
    first_renderer, second_renderer = renderers
    plate, _ = _plates()
    first_renderer.load(plate)
    assert len(list(second_renderer.load_steps(plate))) > 50
    np.testing.assert_array_equal(second_renderer.pixels(SHOT), first_renderer.pixels(SHOT))


def test_renderer_with_half_loaded_plate_refuses_to_render(renderers):
    _, renderer = renderers
    first_plate, second_plate = _plates()
    renderer.load(first_plate)
    steps = renderer.load_steps(second_plate)
    next(steps)
    steps.close()
    with pytest.raises(InputError):
        renderer.render(SHOT)
    renderer.load(first_plate)
    assert renderer.loaded.plate is first_plate


def test_released_plate_can_be_loaded_again(renderers):
    _, renderer = renderers
    plate, _ = _plates()
    renderer.load(plate)
    pixels_before = renderer.pixels(SHOT)
    renderer.unload()
    with pytest.raises(InputError):
        renderer.render(SHOT)
    renderer.load(plate)
    np.testing.assert_array_equal(renderer.pixels(SHOT), pixels_before)


def _moving_scene():
    """Return a scene of two spheres and a box that move over the table."""
    scene = still_life()
    matrices = np.stack([instance.to_world for instance in scene.instances])

    def motion(frame):
        moved_matrices = matrices.copy()
        moved_matrices[1:, 0, 3] += 0.02 * frame
        return moved_matrices

    return replace(scene, motion=motion)


@pytest.mark.parametrize("method", [Method.DIFFUSION, Method.ACCUMULATION, Method.RAYTRACED])
def test_two_renderers_share_moving_scene_at_different_frames(renderers, method):
    first_renderer, second_renderer = renderers
    defocus = DefocusSettings(quality=Quality.DRAFT, method=method, views=5)
    shot = Shot(Lens(50.0, 2.0, 3.0, 36.0), defocus, framing=Framing(48, 27, "camera"))
    first_renderer.load_scene(_moving_scene())
    expected = [first_renderer.pixels(shot, frame).ravel() for frame in (2, 20)]
    assert not np.array_equal(*expected)
    second_renderer.load_scene_of(first_renderer)
    pictures = _alternate_steps(first_renderer.steps(shot, 2), second_renderer.steps(shot, 20))
    for picture, single_picture in zip(pictures, expected, strict=True):
        np.testing.assert_array_equal(picture, single_picture)
    second_renderer.unload()
    np.testing.assert_array_equal(first_renderer.pixels(shot, 2).ravel(), expected[0])


def test_load_scene_of_rejects_renderer_with_plate(renderers):
    first_renderer, second_renderer = renderers
    first_renderer.load(_plates()[0])
    with pytest.raises(InputError):
        second_renderer.load_scene_of(first_renderer)
