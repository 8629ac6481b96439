"""The pixels of the window: the renderer's picture and overlays; and the readout."""

from dataclasses import replace

import numpy as np
import OpenEXR
import pytest
from imgui_bundle import imgui

from heatlens.core.model.focus.coc import sharp_px
from heatlens.core.model.shot.settings import DefocusSettings
from heatlens.fronts.commands.main import main
from heatlens.media.plate.read import read_plate
from heatlens.render.display.overlay_pass import OverlayPass
from heatlens.render.gpu.textures import download
from support.plates import room
from support.session_files import HEIGHT, LENS, POST, WIDTH, room_file
from support.window_plates import display_bytes, plate_pixels, render_shot_from_file, screen_region

K = imgui.Key
FILM = DefocusSettings()


@pytest.fixture
def gui(gui):
    gui.do("1:1")
    gui.settled()
    return gui


def test_window_shows_the_renderers_picture_bit_for_bit(gui, other_renderer):
    gui.session.editing.edit(replace(gui.session.facts.shot, defocus=FILM))
    gui.click(gui.at_picture(POST[0] + 0.5, POST[1] + 0.5))
    gui.settled()
    expected = render_shot_from_file(gui, other_renderer)
    np.testing.assert_array_equal(download(gui.session.pictures.live.output.texture), expected)
    np.testing.assert_array_equal(screen_region(gui), display_bytes(gui, expected))
    assert abs(expected - plate_pixels(gui)).max() > 0.1


def test_window_shows_the_picture_that_the_command_writes(gui, tmp_path, capsys):
    gui.session.editing.edit(replace(gui.session.facts.shot, defocus=FILM))
    gui.frame()
    gui.settled()
    out = tmp_path / "out.exr"
    assert main(["render", gui.session.facts.shot.source, "-o", str(out), "--float"]) == 0
    capsys.readouterr()
    channels = OpenEXR.File(str(out), separate_channels=True).channels()
    expected = np.stack([channels[name].pixels for name in "RGB"], axis=-1)
    np.testing.assert_array_equal(
        download(gui.session.pictures.live.output.texture)[..., :3], expected
    )


def test_exposure_and_gamma_change_the_displayed_pixels(gui, other_renderer):
    for _ in range(3):
        gui.key(K.up_arrow, ctrl=True)
    gui.session.pictures.view.state = replace(gui.session.facts.view, gamma=1.4)
    gui.frame()
    expected = display_bytes(gui, render_shot_from_file(gui, other_renderer), stops=0.75, gamma=1.4)
    np.testing.assert_array_equal(screen_region(gui), expected)
    gui.key(K._0, ctrl=True)
    gui.frame()
    np.testing.assert_array_equal(
        screen_region(gui), display_bytes(gui, render_shot_from_file(gui, other_renderer))
    )


def test_t_stop_darkens_the_displayed_picture(gui, other_renderer):
    """T2 at f/1 darkens the view by two stops and leaves the blur."""
    gui.session.editing.edit_lens(replace(gui.session.facts.lens, t_stop=2.0))
    gui.frame()
    gui.settled()
    np.testing.assert_array_equal(
        screen_region(gui),
        display_bytes(gui, render_shot_from_file(gui, other_renderer), stops=-2.0),
    )


def test_chosen_view_transform_is_displayed(gui, other_renderer):
    before = screen_region(gui)
    display = gui.session.facts.view.display
    other_view = next(
        v for v in gui.session.pictures.color.views(display) if v != gui.session.facts.view.view
    )
    gui.session.pictures.view.state = replace(gui.session.facts.view, view=other_view)
    gui.frame(2)
    np.testing.assert_array_equal(
        screen_region(gui), display_bytes(gui, render_shot_from_file(gui, other_renderer))
    )
    assert np.any(screen_region(gui) != before)


@pytest.mark.parametrize("zoom", [4, 8])
def test_pixels_are_drawn_as_squares_from_zoom_four_on(gui, other_renderer, zoom):
    gui.do("Pixel grid")
    gui.session.pictures.view.state = replace(gui.session.facts.view, zoom=float(zoom))
    gui.frame(2)
    expected = display_bytes(gui, render_shot_from_file(gui, other_renderer))
    np.testing.assert_array_equal(
        screen_region(gui, zoom), expected.repeat(zoom, axis=0).repeat(zoom, axis=1)
    )


def test_zoomed_out_view_shows_pixel_means(gui, other_renderer):
    """At a quarter of the size the mipmaps show means of 4 x 4 pixels."""
    gui.session.pictures.view.state = replace(gui.session.facts.view, zoom=0.25)
    gui.frame(3)
    shape = gui.session.facts.shape
    x, y = (int(c) for c in gui.session.pictures.view.geometry.origin)
    small = gui.screenshot()[y : y + HEIGHT // 4, x : x + WIDTH // 4].astype(float)
    assert (shape.width_px, shape.height_px) == (WIDTH, HEIGHT)
    whole = display_bytes(gui, render_shot_from_file(gui, other_renderer)).astype(float)
    means = whole.reshape(HEIGHT // 4, 4, WIDTH // 4, 4, 3).mean(axis=(1, 3))
    assert abs(small - means).max() <= 2.0  # each of two halvings rounds


# Overlays


@pytest.mark.parametrize(
    ("key", "overlay"),
    [(K.z, "zones"), (K.p, "focus plane"), (K.c, "coc"), (K.v, "depth"), (K.l, "layers")],
)
def test_overlay_key_blends_the_overlay_over_the_picture(gui, key, overlay):
    picture = screen_region(gui).astype(float)
    gui.key(key)
    gui.frame()
    assert gui.session.facts.view.overlay == overlay
    optics = gui.session.pictures.renderer.optics(gui.session.facts.shot)
    colors = gui.ctx.texture((WIDTH, HEIGHT), 4)
    OverlayPass(gui.ctx).run(
        overlay,
        gui.session.pictures.renderer.loaded.depth,
        optics,
        sharp_px(LENS, WIDTH),
        (),
        colors,
    )
    over = np.frombuffer(colors.read(), np.uint8).reshape(HEIGHT, WIDTH, 4).astype(float)
    colors.release()
    alpha = over[..., 3:] / 255
    expected = picture * (1 - alpha) + over[..., :3] * alpha
    assert abs(screen_region(gui) - expected).max() <= 1.5
    gui.key(key)
    gui.frame()
    np.testing.assert_array_equal(screen_region(gui), picture)


def test_zones_overlay_follows_the_focus(gui):
    gui.key(K.z)
    gui.frame()
    before = screen_region(gui)
    gui.click(gui.at_picture(POST[0] + 0.5, POST[1] + 0.5))
    gui.frame()
    after = screen_region(gui)
    post, sky = (POST[1], POST[0]), (4, 80)
    assert before[post][0] > before[post][1] and after[post][1] > after[post][0]  # red, green
    assert before[sky][2] > before[sky][1] and after[sky][2] > after[sky][1]  # blue


# The pixel under the pointer


def test_status_bar_shows_the_values_of_the_hovered_pixel(gui, other_renderer):
    gui.move(gui.at_picture(POST[0] + 0.5, POST[1] + 0.5))
    gui.frame(2)
    text = gui.screen.status.words(gui.screen.picture.hovered_px)
    x, y = POST
    plate = plate_pixels(gui)[y, x]
    through = render_shot_from_file(gui, other_renderer)[y, x]
    assert text.startswith(f"x {x}  y {y}   picture ")
    assert "plate " + " ".join(f"{c:.4g}" for c in plate[:3]) in text
    assert "picture " + " ".join(f"{c:.4g}" for c in through[:3]) in text
    assert "depth 0.9 m" in text
    assert (
        f"blur {-(LENS.aperture_diameter_mm * 85 / 1915 * (2 / 0.9 - 1)) * WIDTH / 36:+.2f} px"
        in text
    )
    gui.move(gui.at_picture(WIDTH + 5, 3))
    gui.frame()
    words = gui.screen.status.words(gui.screen.picture.hovered_px)
    assert words.startswith("Click in the picture") and "plate" not in words


def test_surround_of_the_picture_is_gray(gui):
    x, y = (int(c) for c in gui.session.pictures.view.geometry.origin)
    screen = gui.screenshot()
    for row, column in ((y - 1, x), (y, x - 1), (y + HEIGHT, x), (y, x + WIDTH)):
        assert len(set(screen[row, column].tolist())) == 1, (row, column)


def test_room_file_holds_colors_depth_and_lens_of_the_room(tmp_path):
    """The plate that these tests use has the colors, the distances and the lens of the room."""
    plate = read_plate(room_file(tmp_path / "room.exr"))
    color, depth = room(WIDTH, HEIGHT)
    np.testing.assert_array_equal(plate.color[..., :3], color)
    np.testing.assert_array_equal(plate.depth_m, depth)
    assert plate.camera.f_stop == LENS.f_stop
