"""A beside B, to the pixel: Alt, flip, wipe, difference, and whatever EXR is B."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from imgui_bundle import imgui

from heatlens.core.model.view.view import Against, Compare
from heatlens.render.frame_renderer import FrameRenderer
from support.exr_files import write_file
from support.plates import room
from support.session_files import HEIGHT, POST, WIDTH, write_plate
from support.window_plates import displayed, plate_pixels, region, rendered

K = imgui.Key
HANDLE_EM = 1.6  # letters and grip reach so far from the line


@pytest.fixture(scope="module")
def own(session_context) -> FrameRenderer:
    """Return a renderer that is not the window's."""
    return FrameRenderer(session_context)


@pytest.fixture
def gui(gui):
    gui.do("1:1")
    gui.settled()
    return gui


def test_alt_held_shows_the_plate_as_it_is(gui):
    gui.move(gui.middle("picture"))
    before = region(gui)
    gui.io.add_key_event(K.mod_alt, True)
    gui.hold(K.left_alt)
    np.testing.assert_array_equal(region(gui), before)  # Alt+Tab flips nothing
    gui.later()
    pinhole = region(gui)
    gui.io.add_key_event(K.mod_alt, False)
    gui.hold(K.left_alt, False)
    np.testing.assert_array_equal(pinhole, displayed(gui, plate_pixels(gui)))
    np.testing.assert_array_equal(region(gui), before)
    assert np.any(pinhole != before)


def test_alt_does_nothing_with_another_key_or_beside_the_picture(gui):
    for at, other in ((gui.middle("picture"), K.tab), (gui.middle("f-stop"), None)):
        gui.move(at)
        gui.io.add_key_event(K.mod_alt, True)
        gui.hold(K.left_alt)
        if other is not None:
            gui.hold(other)
            gui.hold(other, False)
        gui.later()
        gui.later()
        assert not gui.session.pictures.view.is_lens_held_off
        gui.io.add_key_event(K.mod_alt, False)
        gui.hold(K.left_alt, False)


def test_depth_of_field_off_shows_the_plate_as_it_is(gui):
    gui.key(K.d)
    gui.frame()
    np.testing.assert_array_equal(region(gui), displayed(gui, plate_pixels(gui)))


def test_flip_shows_b_alone(gui):
    gui.key(K.x)
    gui.frame()
    np.testing.assert_array_equal(region(gui), displayed(gui, plate_pixels(gui)))


def beside_the_handle(gui) -> np.ndarray:
    """Return (H, W), True outside the line, grip and labels of the wipe."""
    em, x0 = imgui.get_font_size(), gui.session.pictures.view.geometry.origin[0]
    line = round(gui.session.facts.view.wipe * WIDTH)
    x = np.arange(WIDTH)
    y = np.arange(HEIGHT)[:, None]
    top = (
        gui.session.pictures.view.geometry.origin[1] - gui.session.pictures.view.viewport.corner[1]
    )
    at_middle = abs(y + top - gui.session.pictures.view.viewport.size[1] / 2) <= 0.7 * em
    at_letters = y + top < 2 * em
    near = abs(x - line) <= HANDLE_EM * em
    assert x0 == int(x0)
    return (x != line) & ~(near & (at_middle | at_letters))


@pytest.mark.parametrize("part", [0.0, 0.25, 0.5, 0.813, 1.0])
def test_the_wipe_is_exactly_a_left_and_b_right(gui, part):
    a = region(gui)
    gui.key(K.x)
    gui.frame()
    b = region(gui)
    gui.key(K.w)
    gui.session.pictures.view.state = replace(gui.session.facts.view, wipe=part)
    gui.frame(2)
    line = round(part * WIDTH)
    expected = np.where((np.arange(WIDTH) < line)[:, None], a, b)
    seen = beside_the_handle(gui)
    np.testing.assert_array_equal(region(gui)[seen], expected[seen])
    assert seen.mean() > 0.6 and np.any(a != b)


def test_the_handle_of_the_wipe_is_dragged_and_focuses_nothing(gui):
    gui.key(K.w)
    before = gui.session.facts.shot
    at = gui.at_picture(0.5 * WIDTH, 40)
    gui.drag(at, (at[0] + 24, at[1] - 10))
    assert gui.session.facts.view.wipe == pytest.approx(0.75, abs=0.5 / WIDTH)
    at = gui.at_picture(0.75 * WIDTH, 20)
    gui.drag(at, (at[0] + 500, at[1]))
    assert gui.session.facts.view.wipe == 1.0
    assert gui.session.facts.shot == before
    gui.drag(gui.at_picture(WIDTH, 20), gui.at_picture(-50, 20))
    assert gui.session.facts.view.wipe == 0.0


def test_a_click_beside_the_handle_focuses(gui):
    gui.key(K.w)
    gui.click(gui.at_picture(POST[0] + 0.5, POST[1] + 0.5))
    assert gui.session.facts.lens.focus_distance_m == pytest.approx(0.9)
    assert gui.session.facts.view.wipe == 0.5


def opened_reference(gui, path: Path) -> None:
    gui.session.pictures.references.open(path)
    gui.until(lambda: gui.session.facts.reference is not None, "the reference")
    gui.session.pictures.view.state = replace(gui.session.facts.view, against=Against.REFERENCE)
    gui.frame(2)


def test_any_exr_can_be_b(gui, tmp_path, rng):
    pixels = rng.uniform(0, 1, (HEIGHT, WIDTH, 3)).astype(np.float32)
    b = write_file(tmp_path / "b.exr", {n: pixels[..., i].copy() for i, n in enumerate("RGB")})
    opened_reference(gui, b)
    gui.key(K.x)
    gui.frame()
    opaque = np.concatenate([pixels, np.ones((HEIGHT, WIDTH, 1), np.float32)], axis=-1)
    np.testing.assert_array_equal(region(gui), displayed(gui, opaque))
    gui.key(K.r)  # back to the pinhole picture
    gui.frame()
    np.testing.assert_array_equal(region(gui), displayed(gui, plate_pixels(gui)))


def test_a_reference_of_another_size_lies_over_the_whole_picture(gui, tmp_path):
    left = np.zeros((10, 2), np.float32)
    left[:, 0] = 1.0
    b = write_file(tmp_path / "b.exr", {name: left for name in "RGB"})
    opened_reference(gui, b)
    gui.key(K.x)
    gui.frame()
    found = region(gui)
    one, none = displayed(gui, np.array([[[1, 1, 1, 1], [0, 0, 0, 1]]], np.float32))[0]
    np.testing.assert_array_equal(found[:, : WIDTH // 4], np.broadcast_to(one, (HEIGHT, 24, 3)))
    np.testing.assert_array_equal(found[:, -WIDTH // 4 :], np.broadcast_to(none, (HEIGHT, 24, 3)))


def test_the_difference_is_the_light_between_a_and_b_times_the_gain(gui, own):
    gui.key(K.e)
    gui.session.pictures.view.state = replace(gui.session.facts.view, difference_gain=2.0)
    gui.frame(2)
    apart = 2.0 * abs(rendered(gui, own) - plate_pixels(gui))
    off = abs(region(gui).astype(int) - displayed(gui, apart))
    assert off.max() <= 1  # the product is rounded before the curve, here after it
    gui.key(K.period)
    gui.frame()
    assert gui.session.facts.view.difference_gain == 4.0


def test_a_has_no_difference_from_itself(gui, own, tmp_path):
    pixels = rendered(gui, own)
    names = {name: np.ascontiguousarray(pixels[..., i]) for i, name in enumerate("RGB")}
    opened_reference(gui, write_file(tmp_path / "a.exr", names))
    gui.key(K.e)
    gui.session.pictures.view.state = replace(gui.session.facts.view, difference_gain=64.0)
    gui.frame(2)
    np.testing.assert_array_equal(region(gui), displayed(gui, np.zeros_like(pixels)))


@pytest.mark.parametrize("compare", [Compare.FLIP, Compare.DIFFERENCE, Compare.WIPE])
def test_b_is_of_the_plate_that_is_open_now(gui, tmp_path, compare):
    """Another plate of the same size, its distances all in focus: A and B are equal."""
    gui.session.pictures.view.state = replace(gui.session.facts.view, compare=compare, wipe=0.0)
    gui.frame(2)
    color, depth = room(WIDTH, HEIGHT)
    upside_down = np.ascontiguousarray(color[::-1])
    gui.open(write_plate(tmp_path / "b.exr", upside_down, Z=np.full_like(depth, 2.0)))
    gui.do("1:1")
    gui.settled()
    expected = displayed(gui, plate_pixels(gui))
    if compare is Compare.DIFFERENCE:
        expected = displayed(gui, np.zeros((HEIGHT, WIDTH, 4), np.float32))
    seen = beside_the_handle(gui) if compare is Compare.WIPE else np.ones((HEIGHT, WIDTH), bool)
    np.testing.assert_array_equal(region(gui)[seen], expected[seen])
