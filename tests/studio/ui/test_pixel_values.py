"""Values written into pixels at high zoom, and the depth of field under the pointer."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from heatlens.core.model.boxes import Box
from heatlens.core.model.focus.coc import coc_line, coc_px, sharp_px
from heatlens.core.model.units import format_distance
from heatlens.core.model.view.view import Against, Compare
from heatlens.render.display.pixel_reading import read_texels
from heatlens.render.gpu.textures import download
from heatlens.studio.ui import status_bar
from heatlens.studio.ui.picture.pixel_values import value_words
from support.session_files import BALL, BALL_M, SKY, WIDTH
from support.watched_calls import watch_calls


def texts(gui, side: int = 0) -> list[list[str]]:
    return gui.screen.picture.viewport._values.sides[side]._texts.words


def zoom_to_ball(gui, zoom: float) -> None:
    gui.session.pictures.commands.change(zoom=zoom, center_px=(BALL[0] + 0.5, BALL[1] + 0.5))
    gui.settled()
    gui.frame()


def test_visible_pixels_show_their_values_at_high_zoom(gui):
    zoom_to_ball(gui, 20.0)
    before = gui.screen.picture.viewport._values.sides[0]._texts.key
    zoom_to_ball(gui, 64.0)
    values = gui.screen.picture.viewport._values.sides[0]._texts
    assert values.key != before and values.key is not None
    box, picture = values.key[2], download(gui.session.pictures.live.output.texture)
    assert box.contains(*BALL) and box.width * box.height < 400
    row, column = BALL[1] - box.y0, BALL[0] - box.x0
    written_values = [float(word) for word in values.words[row][column].split("\n")]
    np.testing.assert_allclose(written_values, picture[BALL[1], BALL[0], :3], atol=6e-4)
    assert len(values.words) == box.height and len(values.words[0]) == box.width


def test_pixel_values_contrast_with_the_pixel_color(gui):
    """The letters in the pixel of the ball differ from its color by more than 90 of 255."""
    zoom_to_ball(gui, 64.0)
    gui.session.pictures.commands.change(pixel_grid=False)
    gui.frame(2)
    x0, y0 = gui.at_picture(*BALL)
    with_values = gui.screenshot()[round(y0) : round(y0) + 64, round(x0) : round(x0) + 64]
    gui.do("Values in pixels")
    gui.frame(2)
    plain = gui.screenshot()[round(y0) : round(y0) + 64, round(x0) : round(x0) + 64]
    assert np.ptp(plain.reshape(-1, 3), axis=0).max() == 0  # one colour
    assert np.abs(with_values.astype(int) - plain).max() > 90


def test_pixel_values_of_both_wipe_sides_come_from_their_own_textures(gui):
    gui.do("Wipe")
    gui.session.pictures.commands.change(wipe=(BALL[0] + 0.5) / WIDTH)
    zoom_to_ball(gui, 64.0)
    light = gui.session.pictures.live.output.texture, gui.session.pictures.renderer.loaded.color
    for side in (0, 1):
        assert gui.screen.picture.viewport._values.sides[side]._texts.key[0] is light[side]
    gui.do("Wipe")


@given(st.floats(-1e5, 1e5))
def test_value_words_are_at_most_seven_characters(value):
    words = value_words(value)
    assert len(words) <= 7
    assert float(words) == pytest.approx(value, rel=0.5, abs=6e-4)


def test_read_texels_returns_the_texels_of_the_box(gui):
    texture = gui.session.pictures.live.output.texture
    box = Box(3, 5, 9, 12)
    np.testing.assert_array_equal(
        read_texels(gui.ctx, texture, box, "f4"), download(texture)[5:12, 3:9]
    )


def test_status_bar_shows_the_sharp_range_for_focus_at_the_pointer(gui):
    gui.settled()
    for pixel in (BALL, SKY):
        assert "focus here: " in gui.screen.status.words(pixel)


def test_sharp_range_at_the_pointer_ends_at_acceptable_blur(gui, monkeypatch):
    gui.settled()
    calls = watch_calls(monkeypatch, status_bar, "reading_text")
    gui.screen.status.words(BALL)
    reading, *_ = calls[0]
    lens = gui.session.facts.lens
    line = coc_line(replace(lens, focus_distance_m=reading.depth_m), WIDTH)
    assert reading.depth_m == pytest.approx(BALL_M, rel=1e-3)
    near, far = coc_px(np.array(reading.sharp_m), line)
    assert (-near, far) == pytest.approx((sharp_px(lens, WIDTH),) * 2, rel=1e-6)


def test_breathing_lens_maps_readout_ruler_and_marks_to_the_frame(gui):
    """Readout, ruler, marks and overlay use the pixel of the frame that is shown at a pixel."""
    session = gui.session
    breathing = replace(session.facts.lens, breathing=0.6, close_focus_m=1.0, focus_distance_m=1.0)
    session.editing.edit_lens(breathing)
    session.pictures.commands.toggle_overlay("zones")
    gui.rest()
    gui.settled()
    source, view = session.source, session.pictures.view
    corner = source.frame_px(session.facts.lens, (0, 0))
    assert corner[0] == pytest.approx(WIDTH / 2 * 0.4, abs=1)
    overlay = gui.screen.picture.viewport._placed_pictures[-1]
    across = overlay.last[0] - overlay.first[0]
    for pixel in (BALL, (10, 20)):
        frame_px = source.frame_px(session.facts.lens, pixel)
        seen_x = overlay.first[0] + (frame_px[0] + 0.5) / WIDTH * across
        expected = view.geometry.window_at_picture((pixel[0] + 0.5, pixel[1] + 0.5))[0]
        assert seen_x == pytest.approx(expected, abs=view.zoom)
        column, row = frame_px
        depth_m = source.plate.depth_m[row, column]
        ruler = session.pictures.commands.ruler
        ruler.points = (pixel, BALL)
        assert ruler.measure().depths_m[0] == pytest.approx(depth_m, rel=1e-3)
        status_words = gui.screen.status.words(pixel)
        assert f"depth {format_distance(float(depth_m), 'm')}" in status_words
        session.time.marks.set_point(pixel)
        gui.frame()
        mark = session.facts.shot.marks[-1]
        assert session.time.marks.distances.distance_m(mark) == pytest.approx(depth_m, rel=1e-3)
        clicked = view.geometry.window_at_picture((pixel[0] + 0.5, pixel[1] + 0.5))
        assert gui.rect(f"point {mark.name}")[:2] == pytest.approx(clicked, abs=2 * view.zoom)
    ruler.switch_off()
    edge = view.geometry.window_at_picture((WIDTH, 0))[0]
    assert overlay.clip.x1 <= round(edge) + 1 < overlay.last[0]


def test_plate_is_drawn_aligned_with_the_picture_of_a_breathing_lens(gui):
    """Both sides of the wipe agree, and so do the pictures with and without depth of field."""
    session = gui.session
    breathing = replace(session.facts.lens, breathing=0.6, close_focus_m=1.0, focus_distance_m=1.0)
    session.editing.edit_lens(breathing)
    session.pictures.view.state = replace(
        session.facts.view, compare=Compare.WIPE, against=Against.PINHOLE
    )
    gui.rest()
    gui.settled()
    lens_side, plate_side = gui.screen.picture.viewport._placed_pictures
    assert lens_side.last[0] - lens_side.first[0] < plate_side.last[0] - plate_side.first[0]
    session.pictures.view.state = replace(session.facts.view, depth_of_field=False)
    gui.frame(2)
    for plate in (plate_side, gui.screen.picture.viewport._placed_pictures[0]):
        across = plate.last[0] - plate.first[0]
        for pixel in (BALL, (10, 20)):
            frame_px = session.source.frame_px(session.facts.lens, pixel)
            seen_x = plate.first[0] + (frame_px[0] + 0.5) / WIDTH * across
            view = session.pictures.view
            expected = view.geometry.window_at_picture((pixel[0] + 0.5, pixel[1] + 0.5))[0]
            assert seen_x == pytest.approx(expected, abs=view.zoom)
