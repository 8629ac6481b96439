"""What the window shows, to the pixel: the renderer's picture, its comparison with B, overlays."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import OpenEXR
import pytest
from imgui_bundle import imgui

from exr_files import write_file
from heatlens.commands.main import main
from heatlens.display.overlay_pass import OverlayPass
from heatlens.gpu.textures import download
from heatlens.image.exr_read import read_plate
from heatlens.model.coc import sharp_px
from heatlens.model.settings import DefocusSettings
from heatlens.model.view import Against, Compare, Overlay
from heatlens.render import FrameRenderer
from plates import room
from window_plates import HEIGHT, LENS, POST, WIDTH, displayed, room_file, write_plate

K = imgui.Key
HANDLE_EM = 1.6  # letters and grip reach so far from the line


@pytest.fixture(scope="module")
def own(session_context) -> FrameRenderer:
    """A renderer that is not the window's."""
    return FrameRenderer(session_context)


@pytest.fixture
def gui(gui):
    gui.do("1:1")
    gui.settled()
    return gui


def region(gui, zoom: int = 1) -> np.ndarray:
    """(H, W, 3) bytes of the display window on the screen."""
    x, y = gui.app.viewport.geometry.origin
    shape = gui.app.picture_shape
    assert (x, y) == (int(x), int(y))
    height, width = shape.height_px * zoom, shape.width_px * zoom
    found = gui.screenshot()[int(y) : int(y) + height, int(x) : int(x) + width]
    assert found.shape == (height, width, 3)
    return found


def rendered(gui, own: FrameRenderer) -> np.ndarray:
    """The shot's picture, made anew from the file."""
    own.load(read_plate(Path(gui.app.shot.source)))
    return own.pixels(gui.app.shot)


def plate_pixels(gui) -> np.ndarray:
    return gui.app.stage.plate.color


FILM = DefocusSettings()


def test_it_shows_the_renderers_picture_bit_for_bit(gui, own):
    gui.app.edit(replace(gui.app.shot, defocus=FILM))
    gui.click(gui.at_picture(POST[0] + 0.5, POST[1] + 0.5))
    gui.settled()
    expected = rendered(gui, own)
    np.testing.assert_array_equal(download(gui.app.live.shown.texture), expected)
    np.testing.assert_array_equal(region(gui), displayed(gui, expected))
    assert abs(expected - plate_pixels(gui)).max() > 0.1


@pytest.mark.usefixtures("command_context")
def test_it_shows_what_the_command_writes(gui, tmp_path, capsys):
    gui.app.edit(replace(gui.app.shot, defocus=FILM))
    gui.frame()
    gui.settled()
    out = tmp_path / "out.exr"
    assert main(["render", gui.app.shot.source, "-o", str(out), "--float"]) == 0
    capsys.readouterr()
    written = OpenEXR.File(str(out), separate_channels=True).channels()
    expected = np.stack([written[name].pixels for name in "RGB"], axis=-1)
    np.testing.assert_array_equal(download(gui.app.live.shown.texture)[..., :3], expected)


def test_exposure_and_gamma_are_the_display_passes(gui, own):
    for _ in range(3):
        gui.key(K.up_arrow, ctrl=True)
    gui.app.view = replace(gui.app.view, gamma=1.4)
    gui.frame()
    expected = displayed(gui, rendered(gui, own), stops=0.75, gamma=1.4)
    np.testing.assert_array_equal(region(gui), expected)
    gui.key(K._0, ctrl=True)
    gui.frame()
    np.testing.assert_array_equal(region(gui), displayed(gui, rendered(gui, own)))


def test_the_glass_darkens_the_view_by_its_t_stop(gui, own):
    """T2 at f/1 is two stops; the blur stays."""
    gui.app.edit_lens(replace(gui.app.lens, t_stop=2.0))
    gui.frame()
    gui.settled()
    np.testing.assert_array_equal(region(gui), displayed(gui, rendered(gui, own), stops=-2.0))


def test_another_view_transform_is_shown(gui, own):
    before = region(gui)
    display = gui.app.view.display
    other = next(v for v in gui.app.color.views(display) if v != gui.app.view.view)
    gui.app.view = replace(gui.app.view, view=other)
    gui.frame(2)
    np.testing.assert_array_equal(region(gui), displayed(gui, rendered(gui, own)))
    assert np.any(region(gui) != before)


@pytest.mark.parametrize("zoom", [4, 8])
def test_pixels_are_squares_from_four_to_one_on(gui, own, zoom):
    gui.do("Pixel grid")
    gui.app.view = replace(gui.app.view, zoom=float(zoom))
    gui.frame(2)
    expected = displayed(gui, rendered(gui, own))
    np.testing.assert_array_equal(
        region(gui, zoom), expected.repeat(zoom, axis=0).repeat(zoom, axis=1)
    )


def test_a_small_view_keeps_the_light(gui, own):
    """Mipmaps: a quarter of the size shows means of 4 x 4 pixels."""
    gui.app.view = replace(gui.app.view, zoom=0.25)
    gui.frame(3)
    shape = gui.app.picture_shape
    x, y = (int(c) for c in gui.app.viewport.geometry.origin)
    small = gui.screenshot()[y : y + HEIGHT // 4, x : x + WIDTH // 4].astype(float)
    assert (shape.width_px, shape.height_px) == (WIDTH, HEIGHT)
    whole = displayed(gui, rendered(gui, own)).astype(float)
    means = whole.reshape(HEIGHT // 4, 4, WIDTH // 4, 4, 3).mean(axis=(1, 3))
    assert abs(small - means).max() <= 2.0  # each of two halvings rounds


# A and B


def test_alt_held_shows_the_plate_as_it_is(gui):
    before = region(gui)
    gui.io.add_key_event(K.mod_alt, True)
    gui.hold(K.left_alt)
    pinhole = region(gui)
    gui.io.add_key_event(K.mod_alt, False)
    gui.hold(K.left_alt, False)
    np.testing.assert_array_equal(pinhole, displayed(gui, plate_pixels(gui)))
    np.testing.assert_array_equal(region(gui), before)
    assert np.any(pinhole != before)


def test_depth_of_field_off_shows_the_plate_as_it_is(gui):
    gui.key(K.d)
    gui.frame()
    np.testing.assert_array_equal(region(gui), displayed(gui, plate_pixels(gui)))


def test_flip_shows_b_alone(gui):
    gui.key(K.x)
    gui.frame()
    np.testing.assert_array_equal(region(gui), displayed(gui, plate_pixels(gui)))


def beside_the_handle(gui) -> np.ndarray:
    """(H, W) True where neither line, grip nor letters of the wipe are."""
    em, x0 = imgui.get_font_size(), gui.app.viewport.geometry.origin[0]
    line = round(gui.app.view.wipe * WIDTH)
    x = np.arange(WIDTH)
    y = np.arange(HEIGHT)[:, None]
    top = gui.app.viewport.geometry.origin[1] - gui.app.viewport.viewport.corner[1]
    at_middle = abs(y + top - gui.app.viewport.viewport.size[1] / 2) <= 0.7 * em
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
    gui.app.view = replace(gui.app.view, wipe=part)
    gui.frame(2)
    line = round(part * WIDTH)
    expected = np.where((np.arange(WIDTH) < line)[:, None], a, b)
    seen = beside_the_handle(gui)
    np.testing.assert_array_equal(region(gui)[seen], expected[seen])
    assert seen.mean() > 0.6 and np.any(a != b)


def test_the_handle_of_the_wipe_is_dragged_and_focuses_nothing(gui):
    gui.key(K.w)
    before = gui.app.shot
    at = gui.at_picture(0.5 * WIDTH, 40)
    gui.drag(at, (at[0] + 24, at[1] - 10))
    assert gui.app.view.wipe == pytest.approx(0.75, abs=0.5 / WIDTH)
    at = gui.at_picture(0.75 * WIDTH, 20)
    gui.drag(at, (at[0] + 500, at[1]))
    assert gui.app.view.wipe == 1.0
    assert gui.app.shot == before
    gui.drag(gui.at_picture(WIDTH, 20), gui.at_picture(-50, 20))
    assert gui.app.view.wipe == 0.0


def test_a_click_beside_the_handle_focuses(gui):
    gui.key(K.w)
    gui.click(gui.at_picture(POST[0] + 0.5, POST[1] + 0.5))
    assert gui.app.lens.focus_distance_m == pytest.approx(0.9)
    assert gui.app.view.wipe == 0.5


def opened_reference(gui, path: Path) -> None:
    gui.app.stage.open_reference(path)
    gui.until(lambda: gui.app.reference is not None, "the reference")
    gui.app.view = replace(gui.app.view, against=Against.REFERENCE)
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
    gui.app.view = replace(gui.app.view, difference_gain=2.0)
    gui.frame(2)
    apart = 2.0 * abs(rendered(gui, own) - plate_pixels(gui))
    off = abs(region(gui).astype(int) - displayed(gui, apart))
    assert off.max() <= 1  # the product is rounded before the curve, here after it
    gui.key(K.period)
    gui.frame()
    assert gui.app.view.difference_gain == 4.0


def test_a_has_no_difference_from_itself(gui, own, tmp_path):
    pixels = rendered(gui, own)
    names = {name: np.ascontiguousarray(pixels[..., i]) for i, name in enumerate("RGB")}
    opened_reference(gui, write_file(tmp_path / "a.exr", names))
    gui.key(K.e)
    gui.app.view = replace(gui.app.view, difference_gain=64.0)
    gui.frame(2)
    np.testing.assert_array_equal(region(gui), displayed(gui, np.zeros_like(pixels)))


@pytest.mark.parametrize("compare", [Compare.FLIP, Compare.DIFFERENCE, Compare.WIPE])
def test_b_is_of_the_plate_that_is_open_now(gui, tmp_path, compare):
    """Another plate of the same size, its distances all in focus: A and B are equal."""
    gui.app.view = replace(gui.app.view, compare=compare, wipe=0.0)
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


# Overlays


@pytest.mark.parametrize(
    ("key", "overlay"),
    [
        (K.z, Overlay.ZONES),
        (K.p, Overlay.FOCUS_PLANE),
        (K.c, Overlay.COC),
        (K.v, Overlay.DEPTH),
        (K.l, Overlay.LAYERS),
    ],
)
def test_an_overlay_lies_over_the_picture_and_goes_with_its_key(gui, key, overlay):
    picture = region(gui).astype(float)
    gui.key(key)
    gui.frame()
    assert gui.app.view.overlay is overlay
    optics = gui.app.renderer.optics(gui.app.shot)
    colors = gui.ctx.texture((WIDTH, HEIGHT), 4)
    OverlayPass(gui.ctx).run(
        overlay, gui.app.renderer.loaded.depth, optics, sharp_px(LENS, WIDTH), (), colors
    )
    over = np.frombuffer(colors.read(), np.uint8).reshape(HEIGHT, WIDTH, 4).astype(float)
    colors.release()
    alpha = over[..., 3:] / 255
    expected = picture * (1 - alpha) + over[..., :3] * alpha
    assert abs(region(gui) - expected).max() <= 1.5
    gui.key(key)
    gui.frame()
    np.testing.assert_array_equal(region(gui), picture)


def test_an_overlay_follows_the_lens(gui):
    gui.key(K.z)
    gui.frame()
    before = region(gui)
    gui.click(gui.at_picture(POST[0] + 0.5, POST[1] + 0.5))
    gui.frame()
    after = region(gui)
    post, sky = (POST[1], POST[0]), (4, 80)
    assert before[post][0] > before[post][1] and after[post][1] > after[post][0]  # red, green
    assert before[sky][2] > before[sky][1] and after[sky][2] > after[sky][1]  # blue


# The pixel under the pointer


def test_the_status_bar_reads_the_pixel_under_the_pointer(gui, own):
    gui.move(gui.at_picture(POST[0] + 0.5, POST[1] + 0.5))
    gui.frame(2)
    text = gui.screen._probe_text()
    x, y = POST
    plate = plate_pixels(gui)[y, x]
    through = rendered(gui, own)[y, x]
    assert text.startswith(f"x {x}  y {y}   picture ")
    assert "plate " + " ".join(f"{c:.4g}" for c in plate[:3]) in text
    assert "picture " + " ".join(f"{c:.4g}" for c in through[:3]) in text
    assert "depth 0.9 m" in text
    assert (
        f"coc {-(LENS.aperture_diameter_mm * 85 / 1915 * (2 / 0.9 - 1)) * WIDTH / 36:+.2f} px"
        in text
    )
    gui.move(gui.at_picture(WIDTH + 5, 3))
    gui.frame()
    assert gui.screen._probe_text() == ""


def test_what_lies_outside_the_picture_is_grey(gui):
    x, y = (int(c) for c in gui.app.viewport.geometry.origin)
    found = gui.screenshot()
    for row, column in ((y - 1, x), (y, x - 1), (y + HEIGHT, x), (y, x + WIDTH)):
        assert len(set(found[row, column].tolist())) == 1, (row, column)


def test_the_file_is_the_rooms(tmp_path):
    """What these tests stand on: colours, distances and the lens as they were made."""
    plate = read_plate(room_file(tmp_path / "room.exr"))
    color, depth = room(WIDTH, HEIGHT)
    np.testing.assert_array_equal(plate.color[..., :3], color)
    np.testing.assert_array_equal(plate.depth_m, depth)
    assert plate.camera.f_stop == LENS.f_stop
