"""A compared with B to the pixel: Alt, flip, wipe, difference, and any EXR as B."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from imgui_bundle import imgui

from heatlens.core.model.view.view import Against, Compare
from heatlens.studio.settings.preferences import Preferences
from support.exr_files import write_file
from support.gui import gui_of
from support.plates import room
from support.session_files import HEIGHT, POST, QUICK, WIDTH, room_file, write_plate
from support.window_plates import display_bytes, plate_pixels, render_shot_from_file, screen_region

K = imgui.Key
HANDLE_REACH_EM = 1.6  # how far the letters and the grip reach from the line of the wipe


@pytest.fixture
def gui(gui):
    gui.do("1:1")
    gui.settled()
    return gui


def test_held_alt_shows_the_plate_without_depth_of_field(gui):
    gui.move(gui.middle("picture"))
    before = screen_region(gui)
    gui.io.add_key_event(K.mod_alt, True)
    gui.hold(K.left_alt)
    np.testing.assert_array_equal(screen_region(gui), before)  # Alt+Tab flips nothing
    gui.later()
    pinhole = screen_region(gui)
    gui.io.add_key_event(K.mod_alt, False)
    gui.hold(K.left_alt, down=False)
    np.testing.assert_array_equal(pinhole, display_bytes(gui, plate_pixels(gui)))
    np.testing.assert_array_equal(screen_region(gui), before)
    assert np.any(pinhole != before)


def test_alt_with_another_key_or_off_the_picture_does_nothing(gui):
    for position, other_key in ((gui.middle("picture"), K.tab), (gui.middle("f-stop"), None)):
        gui.move(position)
        gui.io.add_key_event(K.mod_alt, True)
        gui.hold(K.left_alt)
        if other_key is not None:
            gui.hold(other_key)
            gui.hold(other_key, down=False)
        gui.later()
        gui.later()
        assert not gui.session.pictures.view.is_lens_held_off
        gui.io.add_key_event(K.mod_alt, False)
        gui.hold(K.left_alt, down=False)


def test_depth_of_field_off_shows_the_plate(gui):
    gui.key(K.d)
    gui.frame()
    np.testing.assert_array_equal(screen_region(gui), display_bytes(gui, plate_pixels(gui)))


def test_key_x_shows_the_unblurred_plate_in_place_of_the_picture(gui):
    gui.key(K.x)
    gui.frame()
    np.testing.assert_array_equal(screen_region(gui), display_bytes(gui, plate_pixels(gui)))


def mask_without_handle(gui) -> np.ndarray:
    """Return a mask (H, W) that is False at the line, the grip and the labels of the wipe."""
    em, x0 = imgui.get_font_size(), gui.session.pictures.view.geometry.origin[0]
    line = round(gui.session.facts.view.wipe * WIDTH)
    x = np.arange(WIDTH)
    y = np.arange(HEIGHT)[:, None]
    top = (
        gui.session.pictures.view.geometry.origin[1] - gui.session.pictures.view.viewport.corner[1]
    )
    is_at_grip = abs(y + top - gui.session.pictures.view.viewport.size[1] / 2) <= 0.7 * em
    is_at_labels = y + top < 2 * em
    is_near = abs(x - line) <= HANDLE_REACH_EM * em
    assert x0 == int(x0)
    return (x != line) & ~(is_near & (is_at_grip | is_at_labels))


@pytest.mark.parametrize("part", [0.0, 0.25, 0.5, 0.813, 1.0])
def test_wipe_shows_a_left_and_b_right_of_its_line(gui, part):
    a = screen_region(gui)
    gui.key(K.x)
    gui.frame()
    b = screen_region(gui)
    gui.key(K.w)
    gui.session.pictures.view.state = replace(gui.session.facts.view, wipe=part)
    gui.frame(2)
    line = round(part * WIDTH)
    expected = np.where((np.arange(WIDTH) < line)[:, None], a, b)
    mask = mask_without_handle(gui)
    np.testing.assert_array_equal(screen_region(gui)[mask], expected[mask])
    assert mask.mean() > 0.6 and np.any(a != b)


def test_wipe_handle_drag_moves_the_wipe_and_keeps_the_focus(gui):
    gui.key(K.w)
    before = gui.session.facts.shot
    position = gui.at_picture(0.5 * WIDTH, 40)
    gui.drag(position, (position[0] + 24, position[1] - 10))
    assert gui.session.facts.view.wipe == pytest.approx(0.75, abs=0.5 / WIDTH)
    position = gui.at_picture(0.75 * WIDTH, 20)
    gui.drag(position, (position[0] + 500, position[1]))
    assert gui.session.facts.view.wipe == 1.0
    assert gui.session.facts.shot == before
    gui.drag(gui.at_picture(WIDTH, 20), gui.at_picture(-50, 20))
    assert gui.session.facts.view.wipe == 0.0


def test_click_beside_the_wipe_handle_focuses(gui):
    gui.key(K.w)
    gui.click(gui.at_picture(POST[0] + 0.5, POST[1] + 0.5))
    assert gui.session.facts.lens.focus_distance_m == pytest.approx(0.9)
    assert gui.session.facts.view.wipe == 0.5


def open_reference(gui, path: Path) -> None:
    gui.session.pictures.references.open(path)
    gui.until(lambda: gui.session.facts.reference is not None, "the reference")
    gui.session.pictures.view.state = replace(gui.session.facts.view, against=Against.REFERENCE)
    gui.frame(2)


def test_reference_exr_is_shown_as_b(gui, tmp_path, rng):
    pixels = rng.uniform(0, 1, (HEIGHT, WIDTH, 3)).astype(np.float32)
    b = write_file(tmp_path / "b.exr", {n: pixels[..., i].copy() for i, n in enumerate("RGB")})
    open_reference(gui, b)
    gui.key(K.x)
    gui.frame()
    opaque = np.concatenate([pixels, np.ones((HEIGHT, WIDTH, 1), np.float32)], axis=-1)
    np.testing.assert_array_equal(screen_region(gui), display_bytes(gui, opaque))
    gui.key(K.r)  # back to the pinhole picture
    gui.frame()
    np.testing.assert_array_equal(screen_region(gui), display_bytes(gui, plate_pixels(gui)))


def test_reference_of_another_size_is_scaled_to_the_picture(gui, tmp_path):
    left = np.zeros((10, 2), np.float32)
    left[:, 0] = 1.0
    b = write_file(tmp_path / "b.exr", {name: left for name in "RGB"})
    open_reference(gui, b)
    gui.key(K.x)
    gui.frame()
    pixels = screen_region(gui)
    white, black = display_bytes(gui, np.array([[[1, 1, 1, 1], [0, 0, 0, 1]]], np.float32))[0]
    np.testing.assert_array_equal(pixels[:, : WIDTH // 4], np.broadcast_to(white, (HEIGHT, 24, 3)))
    np.testing.assert_array_equal(pixels[:, -WIDTH // 4 :], np.broadcast_to(black, (HEIGHT, 24, 3)))


def test_difference_shows_gain_times_the_distance_of_a_and_b(gui, other_renderer):
    gui.key(K.e)
    gui.session.pictures.view.state = replace(gui.session.facts.view, difference_gain=2.0)
    gui.frame(2)
    expected = 2.0 * abs(render_shot_from_file(gui, other_renderer) - plate_pixels(gui))
    error = abs(screen_region(gui).astype(int) - display_bytes(gui, expected))
    assert error.max() <= 1  # the product is rounded before the curve, here after it
    gui.key(K.period)
    gui.frame()
    assert gui.session.facts.view.difference_gain == 4.0


def test_difference_from_an_equal_reference_is_black(gui, other_renderer, tmp_path):
    pixels = render_shot_from_file(gui, other_renderer)
    names = {name: np.ascontiguousarray(pixels[..., i]) for i, name in enumerate("RGB")}
    open_reference(gui, write_file(tmp_path / "a.exr", names))
    gui.key(K.e)
    gui.session.pictures.view.state = replace(gui.session.facts.view, difference_gain=64.0)
    gui.frame(2)
    np.testing.assert_array_equal(screen_region(gui), display_bytes(gui, np.zeros_like(pixels)))


@pytest.mark.parametrize("compare", [Compare.FLIP, Compare.DIFFERENCE, Compare.WIPE])
def test_b_is_the_plate_that_was_opened_last(gui, tmp_path, compare):
    """The new plate has the same size and is all in focus, so A and B are equal."""
    gui.session.pictures.view.state = replace(gui.session.facts.view, compare=compare, wipe=0.0)
    gui.frame(2)
    color, depth = room(WIDTH, HEIGHT)
    upside_down = np.ascontiguousarray(color[::-1])
    gui.open(write_plate(tmp_path / "b.exr", upside_down, Z=np.full_like(depth, 2.0)))
    gui.do("1:1")
    gui.settled()
    expected = display_bytes(gui, plate_pixels(gui))
    if compare is Compare.DIFFERENCE:
        expected = display_bytes(gui, np.zeros((HEIGHT, WIDTH, 4), np.float32))
    mask = mask_without_handle(gui) if compare is Compare.WIPE else np.ones((HEIGHT, WIDTH), bool)
    np.testing.assert_array_equal(screen_region(gui)[mask], expected[mask])


def test_version_of_the_shot_is_chosen_in_a_box_and_shown_as_b(ctx, tmp_path):
    preferences = Preferences.load(tmp_path / "settings")
    with gui_of(ctx, room_file(tmp_path / "room.exr"), preferences, defocus=QUICK) as gui:
        documents, view = gui.session.files.documents, gui.session.pictures.view
        gui.session.lens.commands.focus(1.5)
        documents.save_as(tmp_path / "room.heatlens.json")
        gui.until(documents.versions.of_open, "a version")
        (saved,) = documents.versions.of_open()
        gui.session.editing.undo()
        for answer, side_b in (("Cancel", Against.PINHOLE), (saved.words, Against.SHOT)):
            gui.do("Compare with a version...")
            gui.frame(3)
            if answer == "Cancel":
                gui.key(K.escape)
            else:
                gui.click(gui.middle(f"version {answer}"))
            gui.until(lambda side_b=side_b: view.state.against is side_b, "the answer")
            assert documents.versions.offered is None
        gui.settled()
        b = gui.session.pictures.sides.picture_of_b(view.state)
        assert b.shot.lens.focus_distance_m == 1.5 != gui.session.facts.lens.focus_distance_m


def test_chosen_channel_is_shown_with_its_values_and_the_picture_comes_back(ctx, tmp_path, rng):
    color, depth = room(WIDTH, HEIGHT)
    normals = {f"N.{leaf}": rng.uniform(-1, 1, depth.shape).astype(np.float32) for leaf in "XYZ"}
    write_plate(tmp_path / "room.exr", color, Z=depth, **normals)
    with gui_of(ctx, tmp_path / "room.exr", defocus=QUICK) as gui:
        channel, view = gui.session.pictures.channel, gui.session.pictures.view
        gui.settled()
        before = screen_region(gui)
        imgui.set_window_focus("Display")
        gui.frame(3)
        for choice in ("N", "picture"):
            gui.click(gui.middle("channel"))
            gui.click(gui.middle(f"channel: {choice}"))
            gui.until(lambda choice=choice: channel.is_current == (choice == "N"), "the channel")
            gui.frame(3)
            if choice == "N":
                assert view.state.compare is Compare.FLIP
                assert channel.texture.size == (WIDTH, HEIGHT)
                gui.move(gui.middle("picture"))
                gui.frame(2)
                assert "N.X " in gui.screen.status.words(gui.screen.picture.hovered_px)
                assert np.any(screen_region(gui) != before)
        assert view.state.compare is Compare.OFF
        gui.settled()
        np.testing.assert_array_equal(screen_region(gui), before)
