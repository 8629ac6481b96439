"""Plates of every kind in the window: without distances, odd sizes, data windows, alpha."""

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from imgui_bundle import imgui

from heatlens.core.base.errors import GpuError
from heatlens.core.model.focus.coc import coc_line, coc_px
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.core.model.view.overlays import overlays_by_name
from heatlens.core.model.view.view import Compare
from heatlens.media.plate.read import read_plate
from heatlens.render.frame_renderer import FrameRenderer
from heatlens.render.gpu.textures import download
from support.exr_files import window, write_file
from support.gui import Gui
from support.plates import room
from support.session_files import BALL, HEIGHT, LENS, POST, SKY, WIDTH, room_file, write_plate

K = imgui.Key


def assert_shows_renderers_picture(gui: Gui, other_renderer: FrameRenderer) -> None:
    gui.settled()
    other_renderer.load(
        read_plate(Path(gui.session.facts.shot.source), gui.session.facts.shot.plate_options)
    )
    found = download(gui.session.pictures.live.output.texture)
    np.testing.assert_array_equal(found, other_renderer.pixels(gui.session.facts.shot))


def show_every_overlay_and_comparison(gui: Gui) -> None:
    """Show every overlay and comparison at two zooms, and check OpenGL for errors."""
    for overlay in overlays_by_name():
        gui.session.pictures.view.state = replace(gui.session.facts.view, overlay=overlay)
        gui.frame(2)
    for compare in Compare:
        gui.session.pictures.view.state = replace(gui.session.facts.view, compare=compare)
        gui.frame(2)
    gui.session.pictures.view.state = replace(
        gui.session.facts.view, overlay="none", compare=Compare.OFF
    )
    for name in ("1:1", "Zoom in", "Zoom in", "Zoom in", "Fit", "Zoom out", "Zoom out", "Fit"):
        gui.do(name)
        gui.screenshot()


# Without distances


@pytest.fixture
def coc_window(gui, tmp_path) -> Gui:
    """Open a plate of the room that has blur sizes instead of distances."""
    color, depth = room(WIDTH, HEIGHT)
    blur = coc_px(depth, coc_line(LENS, WIDTH)).astype(np.float32)
    path = write_plate(tmp_path / "blur.exr", color, Z=blur)
    gui.open(path, PlateOptions(depth_convention="coc"))
    assert gui.session.source.plate.coc_px is not None
    return gui


def test_plate_with_blur_sizes_is_rendered_without_a_histogram(coc_window, other_renderer):
    assert_shows_renderers_picture(coc_window, other_renderer)
    show_every_overlay_and_comparison(coc_window)
    assert coc_window.session.facts.histogram is None


def test_click_on_a_plate_with_blur_sizes_reports_and_keeps_focus(coc_window):
    gui = coc_window
    gui.session.messages.clear()
    before = gui.session.facts.shot
    gui.click(gui.at_picture(BALL[0] + 0.5, BALL[1] + 0.5))
    assert gui.session.facts.shot == before
    assert "circle of confusion" in gui.session.messages.text
    for key in (K.left_bracket, K.right_bracket):
        gui.key(key)
    gui.do("Focus at infinity")
    gui.wheel(gui.middle("f-stop"), 2)
    assert gui.session.facts.shot == before


def test_click_beside_a_plate_with_blur_sizes_reports_nothing(coc_window):
    gui = coc_window
    gui.do("1:1")
    gui.session.messages.clear()
    gui.click(gui.at_picture(-4, -4))
    assert gui.session.messages.text == ""


def test_status_bar_shows_the_blur_size_of_the_hovered_pixel(coc_window):
    gui = coc_window
    gui.session.messages.clear()
    gui.move(gui.at_picture(SKY[0] + 0.5, SKY[1] + 0.5))
    gui.frame()
    blur = gui.session.source.plate.coc_px[SKY[1], SKY[0]]
    text = gui.screen.status.words(gui.screen.picture.hovered_px)
    assert text.endswith(f"   blur {blur:+.2f} px")


def test_click_focuses_again_on_a_plate_with_distances(coc_window, tmp_path):
    gui = coc_window
    gui.open(room_file(tmp_path / "again.exr"))
    gui.click(gui.at_picture(POST[0] + 0.5, POST[1] + 0.5))
    assert gui.session.facts.lens.focus_distance_m == pytest.approx(0.9)


# Sizes


@pytest.mark.parametrize("size", [(1, 1), (1, 200), (301, 7)])
def test_plates_of_odd_sizes_are_shown_and_clicked(gui, other_renderer, tmp_path, size, rng):
    width, height = size
    color = rng.uniform(0, 1, (height, width, 3)).astype(np.float32)
    depth = rng.uniform(1, 9, (height, width)).astype(np.float32)
    gui.open(write_plate(tmp_path / "odd.exr", color, Z=depth))
    assert_shows_renderers_picture(gui, other_renderer)
    show_every_overlay_and_comparison(gui)
    gui.do("Fit")
    for point in ((0, 0), (width, 0), (0, height), (width, height)):
        x, y = gui.at_picture(*point)
        x0, y0, x1, y1 = gui.rect("picture")
        assert x0 - 1 <= x <= x1 + 1 and y0 - 1 <= y <= y1 + 1
    x, y = width // 2, height - 1
    gui.click(gui.at_picture(x + 0.5, y + 0.5))
    near = np.sort(depth[max(0, y - 2) : y + 3, max(0, x - 2) : x + 3], axis=None)
    assert gui.session.facts.lens.focus_distance_m == near[len(near) // 2]


# Windows of the file


@pytest.fixture
def off_origin(gui, tmp_path) -> Gui:
    """Open a plate whose 40 x 30 data window at (-5, 12) exceeds the display window at (10, 20)."""
    color, depth = room(40, 30)
    windows = {"dataWindow": window(-5, 12, 35, 42), "displayWindow": window(10, 20, 90, 70)}
    gui.open(write_plate(tmp_path / "windows.exr", color, Z=depth, **windows))
    gui.do("1:1")
    gui.settled()
    return gui


def test_data_window_is_drawn_at_its_place_in_the_display_window(off_origin, other_renderer):
    gui = off_origin
    assert_shows_renderers_picture(gui, other_renderer)
    assert gui.session.facts.shape.width_px == 80
    gui.do("Depth of field")
    gui.frame()
    x, y = (int(c) for c in gui.session.pictures.view.geometry.origin)
    screen = gui.screenshot()
    lamp = np.argwhere(gui.session.source.plate.color[..., 0] == 40.0)[0]
    row, column = y + 12 - 20 + lamp[0], x - 5 - 10 + lamp[1]
    assert screen[row, column].min() >= 240
    assert screen[row, column - 2].max() < 240
    outside = screen[y + 45, x + 60]
    assert len(set(outside.tolist())) == 1  # the display window's rest is surround


def test_display_window_is_outlined(off_origin):
    gui = off_origin
    x, y = (int(c) for c in gui.session.pictures.view.geometry.origin)
    screen = gui.screenshot().astype(int)
    surround = screen[y + 48, x + 60]
    for row, column in ((y + 50, x + 60), (y + 40, x + 80)):
        edge = screen[row - 1 : row + 2, column - 1 : column + 2]
        assert abs(edge - surround).max() > 40, (row - y, column - x)


def test_readout_counts_pixels_from_display_and_data_window(off_origin):
    """Pixel (3, 4) of the display window is (13, 24) of the file, and (18, 12) of the data."""
    gui = off_origin
    gui.move(gui.at_picture(3.5, 4.5))
    gui.frame()
    text = gui.screen.status.words(gui.screen.picture.hovered_px)
    assert text.startswith("x 3  y 4  (data window 13, 24)")
    values = " ".join(f"{c:.4g}" for c in gui.session.source.plate.color[12, 18, :3])
    assert f"plate {values}" in text
    gui.move(gui.at_picture(60.5, 4.5))
    gui.frame()
    words = gui.screen.status.words(gui.screen.picture.hovered_px)
    assert words.startswith("Click in the picture") and "plate" not in words


def test_click_focuses_only_within_the_data_window(off_origin):
    gui = off_origin
    depth = gui.session.source.plate.depth_m
    gui.click(gui.at_picture(3.5, 4.5))
    near = np.sort(depth[10:15, 16:21], axis=None)
    assert gui.session.facts.lens.focus_distance_m == near[12]
    before, gui.session.messages.text = gui.session.facts.shot, ""
    for column in (28.5, 60.5):  # 38 and 70 of the file, whose data end at 35
        gui.click(gui.at_picture(column, 4.5))
    assert (gui.session.facts.shot, gui.session.messages.text) == (before, "")


# Wide pixels, alpha, headers


def test_anamorphic_plate_is_shown_twice_as_wide(gui, other_renderer, tmp_path):
    gui.open(room_file(tmp_path / "wide.exr", 96, 64, pixelAspectRatio=2.0))
    assert gui.session.source.plate.pixel_aspect_ratio == 2.0
    gui.do("1:1")
    assert_shows_renderers_picture(gui, other_renderer)
    (x0, y0), (x1, y1) = gui.at_picture(0, 0), gui.at_picture(96, 64)
    assert (x1 - x0, y1 - y0) == (192, 64)
    gui.do("Zoom in")
    gui.frame()
    gui.click(gui.at_picture(POST[0] + 0.5, POST[1] + 0.5))
    assert gui.session.facts.lens.focus_distance_m == pytest.approx(0.9)
    show_every_overlay_and_comparison(gui)


def test_plate_with_alpha_is_shown_over_black(gui, other_renderer, tmp_path):
    color, depth = room(WIDTH, HEIGHT)
    alpha = np.where(np.isinf(depth), 0.0, 1.0).astype(np.float32)
    rgba = np.concatenate([color * alpha[..., None], alpha[..., None]], axis=-1)
    gui.open(write_plate(tmp_path / "alpha.exr", rgba, Z=depth))
    assert gui.session.source.plate.has_alpha
    gui.do("1:1")
    assert_shows_renderers_picture(gui, other_renderer)
    show_every_overlay_and_comparison(gui)
    gui.do("1:1")
    gui.do("Depth of field")
    x, y = (int(c) for c in gui.session.pictures.view.geometry.origin)
    assert gui.screenshot()[y + SKY[1], x + SKY[0]].max() <= 1


def test_plate_without_lens_header_focuses_on_its_middle(gui, tmp_path):
    color, depth = room(WIDTH, HEIGHT)
    channels = {name: color[..., i].copy() for i, name in enumerate("RGB")} | {"Z": depth}
    gui.open(write_file(tmp_path / "plain.exr", channels))
    assert (gui.session.facts.lens.focal_length_mm, gui.session.facts.lens.f_stop) == (50.0, 2.8)
    middle = np.sort(depth[21:43, 32:64], axis=None)
    assert gui.session.facts.lens.focus_distance_m == middle[len(middle) // 2]


def test_plate_of_sky_only_focuses_at_infinity(gui, other_renderer, tmp_path):
    color = np.full((20, 30, 3), 0.4, np.float32)
    gui.open(write_plate(tmp_path / "sky.exr", color, Z=np.full((20, 30), np.inf, np.float32)))
    assert_shows_renderers_picture(gui, other_renderer)
    show_every_overlay_and_comparison(gui)
    gui.click(gui.at_picture(10.5, 10.5))
    assert gui.session.facts.lens.focus_distance_m == math.inf
    gui.key(K.left_bracket)
    assert gui.session.facts.lens.focus_distance_m == pytest.approx(250.0)


def test_plate_too_large_for_the_gpu_is_reported_and_the_last_stays(gui, tmp_path, monkeypatch):
    """A failed texture is reported, and the last plate is shown again and can be edited."""
    path = room_file(tmp_path / "large.exr", 128, 96)

    def refuse(*args: object, **kwargs: object) -> None:
        raise GpuError("OpenGL could not make a 128x96 texture (GL_OUT_OF_MEMORY).")

    before = gui.session.facts.shot
    with monkeypatch.context() as failing_patch:
        failing_patch.setattr("heatlens.render.source.plate_on_gpu.new_texture", refuse)
        gui.session.files.commands.open(str(path))
        gui.until(lambda: "128x96" in gui.session.messages.text, "a sentence")
        gui.frame(3)
    gui.frame(3)
    gui.settled()
    assert gui.session.facts.shot == before
    gui.click(gui.at_picture(POST[0] + 0.5, POST[1] + 0.5))
    assert gui.session.facts.lens.focus_distance_m == pytest.approx(0.9)
    gui.open(path)
    assert gui.session.facts.shape.width_px == 128
