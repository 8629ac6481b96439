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
from heatlens.render.display.probe import probe_text, read_texels
from heatlens.render.gpu.textures import download
from heatlens.studio.ui.picture.pixel_values import value_words
from support.session_files import BALL, BALL_M, SKY, WIDTH


def texts(gui, side: int = 0) -> list[list[str]]:
    return gui.screen.picture.viewport._values.sides[side]._texts.words


def zoomed(gui, zoom: float) -> None:
    gui.session.pictures.commands.change(zoom=zoom, center_px=(BALL[0] + 0.5, BALL[1] + 0.5))
    gui.settled()
    gui.frame()


def test_each_pixel_that_is_seen_tells_its_light(gui):
    zoomed(gui, 20.0)
    before = gui.screen.picture.viewport._values.sides[0]._texts.key
    zoomed(gui, 64.0)
    values = gui.screen.picture.viewport._values.sides[0]._texts
    assert values.key != before and values.key is not None
    box, picture = values.key[2], download(gui.session.pictures.live.shown.texture)
    assert box.contains(*BALL) and box.width * box.height < 400
    row, column = BALL[1] - box.y0, BALL[0] - box.x0
    told = [float(word) for word in values.words[row][column].split("\n")]
    np.testing.assert_allclose(told, picture[BALL[1], BALL[0], :3], atol=6e-4)
    assert len(values.words) == box.height and len(values.words[0]) == box.width


def test_letters_are_told_from_what_lies_under_them(gui):
    """In the pixel of the ball are both its colour and letters much lighter or darker."""
    zoomed(gui, 64.0)
    gui.session.pictures.commands.change(pixel_grid=False)
    gui.frame(2)
    x0, y0 = gui.at_picture(*BALL)
    with_values = gui.screenshot()[round(y0) : round(y0) + 64, round(x0) : round(x0) + 64]
    gui.do("Values in pixels")
    gui.frame(2)
    plain = gui.screenshot()[round(y0) : round(y0) + 64, round(x0) : round(x0) + 64]
    assert np.ptp(plain.reshape(-1, 3), axis=0).max() == 0  # one colour
    assert np.abs(with_values.astype(int) - plain).max() > 90


def test_both_sides_of_the_wipe_tell_their_own(gui):
    gui.do("Wipe")
    gui.session.pictures.commands.change(wipe=(BALL[0] + 0.5) / WIDTH)
    zoomed(gui, 64.0)
    light = gui.session.pictures.live.shown.texture, gui.session.pictures.renderer.loaded.color
    for side in (0, 1):
        assert gui.screen.picture.viewport._values.sides[side]._texts.key[0] is light[side]
    gui.do("Wipe")


@given(st.floats(-1e5, 1e5))
def test_a_value_is_told_in_few_letters(value):
    words = value_words(value)
    assert len(words) <= 7
    assert float(words) == pytest.approx(value, rel=0.5, abs=6e-4)


def test_texels_are_read_where_they_are(gui):
    texture = gui.session.pictures.live.shown.texture
    box = Box(3, 5, 9, 12)
    np.testing.assert_array_equal(
        read_texels(gui.ctx, texture, box, "f4"), download(texture)[5:12, 3:9]
    )


def test_the_status_bar_tells_what_would_be_sharp_if_the_focus_were_here(gui):
    gui.settled()
    for pixel in (BALL, SKY):
        assert "focus here: " in gui.screen.status.words(pixel)


def test_the_limits_under_the_pointer_are_where_the_blur_is_just_acceptable(gui, monkeypatch):
    gui.settled()
    caught = []
    monkeypatch.setattr(
        "heatlens.studio.ui.status_bar.probe_text",
        lambda read, *told: caught.append(read) or probe_text(read, *told),
    )
    gui.screen.status.words(BALL)
    lens = gui.session.facts.lens
    line = coc_line(replace(lens, focus_distance_m=caught[0].depth_m), WIDTH)
    assert caught[0].depth_m == pytest.approx(BALL_M, rel=1e-3)
    near, far = coc_px(np.array(caught[0].sharp_m), line)
    assert (-near, far) == pytest.approx((sharp_px(lens, WIDTH),) * 2, rel=1e-6)


def test_before_a_plate_a_lens_that_breathes_is_read_where_it_shows_the_frame(gui):
    """Readout, ruler, marks and overlay go by the part of the frame that is seen at a pixel."""
    session = gui.session
    breathing = replace(session.facts.lens, breathing=0.6, close_focus_m=1.0, focus_distance_m=1.0)
    session.editing.edit_lens(breathing)
    session.pictures.commands.toggle_overlay("zones")
    gui.rest()
    gui.settled()
    source, place = session.source, session.pictures.view
    corner = source.frame_px(session.facts.lens, (0, 0))
    assert corner[0] == pytest.approx(WIDTH / 2 * 0.4, abs=1)
    overlay = gui.screen.picture.viewport._placed[-1]
    across = overlay.last[0] - overlay.first[0]
    for pixel in (BALL, (10, 20)):
        frame_px = source.frame_px(session.facts.lens, pixel)
        seen_x = overlay.first[0] + (frame_px[0] + 0.5) / WIDTH * across
        expected = place.geometry.window_at_picture((pixel[0] + 0.5, pixel[1] + 0.5))[0]
        assert seen_x == pytest.approx(expected, abs=place.zoom)
        column, row = frame_px
        depth_m = source.plate.depth_m[row, column]
        ruler = session.pictures.commands.ruler
        ruler.points = (pixel, BALL)
        assert ruler.measured().depths_m[0] == pytest.approx(depth_m, rel=1e-3)
        told = gui.screen.status.words(pixel)
        assert f"depth {format_distance(float(depth_m), 'm')}" in told
        session.time.marks.set_point(pixel)
        gui.frame()
        mark = session.facts.shot.marks[-1]
        assert session.time.marks.distances.of_m(mark) == pytest.approx(depth_m, rel=1e-3)
        clicked = place.geometry.window_at_picture((pixel[0] + 0.5, pixel[1] + 0.5))
        assert gui.rect(f"point {mark.name}")[:2] == pytest.approx(clicked, abs=2 * place.zoom)
    ruler.leave()
    edge = place.geometry.window_at_picture((WIDTH, 0))[0]
    assert overlay.clip.x1 <= round(edge) + 1 < overlay.last[0]


def test_a_plate_beside_a_lens_that_breathes_shows_the_same_part_of_the_frame(gui):
    """Both sides of the wipe agree, and so do the pictures with and without depth of field."""
    session = gui.session
    breathing = replace(session.facts.lens, breathing=0.6, close_focus_m=1.0, focus_distance_m=1.0)
    session.editing.edit_lens(breathing)
    session.pictures.view.state = replace(
        session.facts.view, compare=Compare.WIPE, against=Against.PINHOLE
    )
    gui.rest()
    gui.settled()
    lens_side, plate_side = gui.screen.picture.viewport._placed
    assert lens_side.last[0] - lens_side.first[0] < plate_side.last[0] - plate_side.first[0]
    session.pictures.view.state = replace(session.facts.view, depth_of_field=False)
    gui.frame(2)
    for plate in (plate_side, gui.screen.picture.viewport._placed[0]):
        across = plate.last[0] - plate.first[0]
        for pixel in (BALL, (10, 20)):
            frame_px = session.source.frame_px(session.facts.lens, pixel)
            seen_x = plate.first[0] + (frame_px[0] + 0.5) / WIDTH * across
            place = session.pictures.view
            expected = place.geometry.window_at_picture((pixel[0] + 0.5, pixel[1] + 0.5))[0]
            assert seen_x == pytest.approx(expected, abs=place.zoom)
