"""Two renderers in one context: what one has half done, the other leaves as it is."""

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
    own = FrameRenderer(ctx)
    return own, own.beside()


def _plates():
    color, depth = room(96, 64)
    return plate_of(color, depth), plate_of(np.ascontiguousarray(color[::-1]), depth)


def _in_turns(*turns):
    """Return the pictures of several steps, one step of each after the other."""
    found = [None] * len(turns)
    while any(picture is None for picture in found):
        for at, steps in enumerate(turns):
            if found[at] is None:
                try:
                    next(steps)
                except StopIteration as end:
                    found[at] = np.frombuffer(end.value.read(), np.float32)
    return found


def test_pictures_that_come_about_in_turns_are_those_made_alone(renderers):
    own, other = renderers
    one, two = _plates()
    own.load(one)
    expected = own.pixels(SHOT)
    other.load(two)
    expected_other = other.pixels(SHOT)
    assert not np.array_equal(expected, expected_other)
    found = _in_turns(own.steps(SHOT), other.steps(SHOT))
    np.testing.assert_array_equal(found[0], expected.ravel())
    np.testing.assert_array_equal(found[1], expected_other.ravel())


def test_a_plate_taken_band_by_band_is_the_plate(renderers, monkeypatch):
    monkeypatch.setattr("heatlens.render.gpu.textures._BAND_BYTES", 1000)
    own, other = renderers
    one, _ = _plates()
    own.load(one)
    assert len(list(other.loading(one))) > 50
    np.testing.assert_array_equal(other.pixels(SHOT), own.pixels(SHOT))


def test_a_plate_that_is_half_taken_is_not_there(renderers):
    _, other = renderers
    one, two = _plates()
    other.load(one)
    steps = other.loading(two)
    next(steps)
    steps.close()
    with pytest.raises(InputError):
        other.render(SHOT)
    other.load(one)
    assert other.loaded.plate is one


def test_what_was_let_go_can_be_loaded_again(renderers):
    _, other = renderers
    one, _ = _plates()
    other.load(one)
    before = other.pixels(SHOT)
    other.let_go()
    with pytest.raises(InputError):
        other.render(SHOT)
    other.load(one)
    np.testing.assert_array_equal(other.pixels(SHOT), before)


def _moving_scene():
    """Return two spheres and a box that wander over the table."""
    scene = still_life()
    there = np.stack([instance.to_world for instance in scene.instances])

    def motion(frame):
        now = there.copy()
        now[1:, 0, 3] += 0.02 * frame
        return now

    return replace(scene, motion=motion)


@pytest.mark.parametrize("method", [Method.DIFFUSION, Method.ACCUMULATION, Method.RAYTRACED])
def test_a_moving_scene_is_drawn_at_two_frames_in_turns(renderers, method):
    own, other = renderers
    defocus = DefocusSettings(quality=Quality.DRAFT, method=method, views=5)
    shot = Shot(Lens(50.0, 2.0, 3.0, 36.0), defocus, framing=Framing(48, 27, "camera"))
    own.load_scene(_moving_scene())
    expected = [own.pixels(shot, frame).ravel() for frame in (2, 20)]
    assert not np.array_equal(*expected)
    other.load_scene_of(own)
    found = _in_turns(own.steps(shot, 2), other.steps(shot, 20))
    for one, alone in zip(found, expected, strict=True):
        np.testing.assert_array_equal(one, alone)
    other.let_go()
    np.testing.assert_array_equal(own.pixels(shot, 2).ravel(), expected[0])


def test_a_plate_is_no_scene_to_share(renderers):
    own, other = renderers
    own.load(_plates()[0])
    with pytest.raises(InputError):
        other.load_scene_of(own)
