"""The grid of looks, two looks under the wipe, and stills of looks in the shot file."""

from dataclasses import replace

import numpy as np
import pytest
from imgui_bundle import imgui

from heatlens.core.model.view.view import Compare
from heatlens.core.model.view.view_geometry import Viewport
from heatlens.media.documents.shot_file import read_shot, write_shot
from heatlens.media.files.still_text import pixels_of_still
from heatlens.render.frame_renderer import FrameRenderer
from heatlens.render.gpu.textures import download
from heatlens.studio.ui.picture.grid import cell_at, cells
from support.window_plates import display_bytes

K = imgui.Key
STOPS = (1.0, 2.8, 8.0, 22.0)


@pytest.fixture
def looks(gui):
    """Keep four looks of one focus and four stops; the last is that of the shot."""
    gui.settled()
    lens_before = gui.session.facts.lens
    for stop in STOPS:
        gui.session.editing.edit_lens(replace(lens_before, f_stop=stop, focus_distance_m=0.9))
        gui.rest()
        gui.settled()
        gui.key(K.l, shift=True)
    return gui.session.facts.shot.looks


def render_look(gui, look) -> np.ndarray:
    """Render the picture of a look with a new renderer at the size used in the grid."""
    session = gui.session
    shown = session.pictures.sides.picture_of_look(look.name)
    renderer = FrameRenderer(gui.ctx)
    renderer.load(session.source.plate)
    pixels = download(renderer.render(shown.shot, session.facts.frame))
    renderer.unload()
    return pixels


def test_grid_shows_four_looks_as_the_renderer_draws_them(gui, looks):
    session = gui.session
    gui.key(K.w, shift=True)
    gui.settled()
    tiles = gui.screen.picture.pictures.tiles
    assert [tile.name for tile in tiles] == ["A", "B", "C", "D"]
    assert [tile.is_current_lens for tile in tiles] == [False, False, False, True]
    for look in looks:
        shown = session.pictures.sides.picture_of_look(look.name)
        assert shown.is_whole and shown.shot.lens == look.lens
        np.testing.assert_allclose(
            download(shown.texture), render_look(gui, look), rtol=2e-3, atol=2e-3
        )
    screen = gui.screenshot()
    sharpness = []
    for name in "ABCD":
        x0, y0, x1, y1 = (round(v) for v in gui.rect(f"grid {name}"))
        cell = screen[y0 + 4 : y1 - 40, x0 + 4 : x1 - 4].astype(float)
        sharpness.append(np.abs(np.diff(cell, axis=1)).mean())
    assert sharpness == sorted(sharpness)  # the smaller the stop, the sharper the picture
    assert session.facts.view.compare is Compare.GRID
    gui.key(K.escape)
    gui.settled()
    assert session.facts.view.compare is Compare.OFF and not gui.screen.picture.pictures.tiles


def test_click_in_the_grid_takes_the_look_and_can_be_undone(gui, looks):
    session = gui.session
    gui.key(K.w, shift=True)
    gui.settled()
    gui.later()
    before = session.facts.lens
    gui.click(gui.middle("grid B"))
    gui.frame(2)
    assert session.facts.lens == looks[1].lens and session.facts.view.compare is Compare.OFF
    gui.key(K.z, ctrl=True)
    assert session.facts.lens == before
    gui.key(K._1, ctrl=True)
    assert session.facts.lens == looks[0].lens
    gui.key(K.backspace)
    assert session.facts.lens == before
    gui.key(K.backspace)
    assert session.facts.lens == looks[0].lens


def test_grid_cells_share_zoom_and_pointer(gui, looks):
    gui.key(K.w, shift=True)
    gui.settled()
    gui.move(gui.middle("grid D"))
    gui.frame()
    hovered = gui.screen.picture.hovered_px
    gui.move(gui.middle("grid A"))
    gui.frame()
    assert gui.screen.picture.hovered_px == hovered
    gui.wheel(gui.middle("grid C"), 2)
    zoom = gui.session.pictures.view.zoom
    gui.move(gui.middle("grid B"))
    gui.frame()
    assert gui.session.pictures.view.zoom == zoom


def test_wipe_compares_two_looks(gui, looks):
    session = gui.session
    imgui.set_window_focus("Looks")
    gui.frame(2)
    gui.click(gui.middle("left A"))
    gui.frame(2)
    gui.later()
    gui.click(gui.middle("wipe C"))
    gui.settled()
    view, sides = session.facts.view, session.pictures.sides
    assert (view.a_look, view.b_look, view.compare) == ("A", "C", Compare.WIPE)
    a, b = sides.picture_of_a(view), sides.picture_of_b(view)
    assert (a.shot.lens, b.shot.lens) == (looks[0].lens, looks[2].lens)
    assert a.is_whole and b.is_whole
    pictures = gui.screen.picture.pictures
    assert pictures.names == ("A", "C")
    for shown, texture in ((a, pictures.a), (b, pictures.b)):
        pixels = np.frombuffer(texture.read(), np.uint8).reshape(*texture.size[::-1], 4)
        np.testing.assert_allclose(
            pixels[..., :3].astype(int), display_bytes(gui, download(shown.texture)), atol=1
        )
    assert session.facts.lens == looks[3].lens  # the shot is as it was
    gui.later()
    gui.click(gui.middle("left A"))  # the lens stands at the left again
    gui.settled()
    assert session.facts.view.a_look == "" and sides.picture_of_a(session.facts.view) is None


def test_keeping_a_look_renders_nothing(gui):
    gui.settled()
    texture = gui.session.pictures.live.output.texture
    seconds = gui.session.pictures.live.output.seconds
    gui.key(K.l, shift=True)
    assert not gui.session.time.scheduler.is_rendering
    shown = gui.session.pictures.live.output
    assert (shown.texture, shown.seconds, shown.shot) == (texture, seconds, gui.session.facts.shot)


def test_looks_keep_stills_in_the_shot_file(gui, looks, tmp_path):
    stills = [pixels_of_still(look.still) for look in looks]
    assert all(still.shape == (144, 256, 3) and still.std() > 10 for still in stills)
    assert np.abs(stills[0].astype(int) - stills[3]).mean() > 1
    write_shot(tmp_path / "a.heatlens.json", gui.session.facts.shot)
    assert read_shot(tmp_path / "a.heatlens.json").looks == looks


@pytest.mark.parametrize("count", [1, 2, 3, 4])
def test_grid_cells_have_one_size_within_the_viewport(gui, count):
    whole = Viewport(corner=(10.0, 20.0), size=(640.0, 400.0), framebuffer_scale=1.5)
    grid_cells = cells(whole, count)
    assert len(grid_cells) == count and len({cell.size for cell in grid_cells}) == 1
    for index, cell in enumerate(grid_cells):
        assert cell_at(grid_cells, cell.middle) == index
        (x, y), (width, height) = cell.corner, cell.size
        assert x >= 10 and y >= 20 and x + width <= 651 and y + height <= 421
    assert cell_at(grid_cells, (0.0, 0.0)) is None
