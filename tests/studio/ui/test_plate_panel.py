"""The plate's panel: what it tells is what was read, and what is chosen in it is read."""

import math

import numpy as np
import pytest

from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.core.model.value_bins import bins_of, depth_histogram
from heatlens.media.plate.depth_read import planar_depth_m
from heatlens.media.plate.header.camera_header import lens_attributes
from heatlens.media.plate.header.channel_choice import color_layers_among, depth_channels_first
from heatlens.media.plate.read import read_plate
from heatlens.render.display.probe import seen_depth_m
from heatlens.studio.session.messages import window_words
from heatlens.studio.session.settings.preferences import Preferences
from support.exr_files import rgb, write_file
from support.gui import gui_of

HEIGHT, WIDTH = 24, 36
SIZE = (1280, 1900)  # tall: every control of the panel is in sight
RAMP = np.linspace(0.25, 0.75, HEIGHT * WIDTH, dtype=np.float32).reshape(HEIGHT, WIDTH)


def channels():
    """Return channels: depth in metres, a mist of 0 to 1, and a second colour layer."""
    layer = {f"diffuse.{name}": values for name, values in rgb(HEIGHT, WIDTH).items()}
    return rgb(HEIGHT, WIDTH) | layer | {"Z": 8 * RAMP, "mist.V": RAMP}


@pytest.fixture
def plate(tmp_path):
    return write_file(tmp_path / "plate.exr", channels(), **lens_attributes(50, 2, 3, 36, 24))


@pytest.fixture
def preferences():
    return Preferences()


@pytest.fixture
def gui(ctx, plate, preferences):
    with gui_of(ctx, plate, preferences, size=SIZE) as gui:
        for other in ("Display", "Speed"):
            gui.ui.panels[other] = False
        gui.frame(3)
        yield gui


def choose(gui, control, item):
    gui.click(gui.middle(control))
    gui.frame(2)
    gui.click(gui.middle(f"{control}: {item}"))
    gui.until(lambda: not gui.session.source.opener.opening, "an answer")
    gui.frame(3)


def test_neighbours_are_chosen(gui):
    choose(gui, "neighbours", "2 on either side")
    assert gui.session.facts.shot.plate_options.neighbours == 2
    choose(gui, "neighbours", "none")
    assert gui.session.facts.shot.plate_options.neighbours == 0


def enter(gui, control, text):
    gui.click(gui.middle(control))
    gui.type(text)
    gui.click(gui.middle("plate histogram"))
    gui.until(lambda: not gui.session.source.opener.opening, "an answer")
    gui.frame(3)


def test_what_stays_sharp_is_typed_or_picked(gui):
    enter(gui, "never blur", "matte:mist.V")
    assert gui.session.facts.shot.plate_options.never_blur == "matte:mist.V"
    assert gui.session.source.plate.cutout is not None
    enter(gui, "never blur", "matte:nothing")
    assert gui.session.facts.shot.plate_options.never_blur == "matte:mist.V"  # it has no such
    gui.click(gui.middle("pick only blur"))
    gui.frame(2)
    assert "Ctrl+Shift+click" in gui.session.messages.text


def depths(gui):
    return gui.session.source.plate.depth_m


# Choosing


def test_another_channel_is_read_and_the_shot_stays(gui):
    lens = gui.session.facts.lens
    choose(gui, "channel", "Z")
    assert gui.session.source.plate.depth.channel == "Z"
    assert gui.session.facts.lens == lens
    assert gui.session.facts.shot.plate_options == PlateOptions(depth_channel="Z")


@pytest.mark.parametrize(
    ("item", "of"),
    [("distance", lambda z: z), ("1 / distance", lambda z: 1 / z)],
)
def test_a_convention_is_what_it_says(gui, item, of):
    choose(gui, "convention", item)
    np.testing.assert_allclose(depths(gui), of(8 * RAMP), rtol=1e-6)


def test_a_unit_by_name_and_in_metres(gui):
    choose(gui, "scene unit", "ft")
    np.testing.assert_allclose(depths(gui), 0.3048 * 8 * RAMP, rtol=1e-6)
    enter(gui, "in metres", "0.5")
    np.testing.assert_allclose(depths(gui), 0.5 * 8 * RAMP, rtol=1e-6)
    enter(gui, "in metres", "none")
    assert "'none' is not a number" in gui.session.messages.text
    assert gui.session.files.commands.reading.options == PlateOptions(scene_unit_m=0.5)


def test_along_the_ray_is_turned_into_along_the_axis(gui):
    before = gui.session.source.plate
    choose(gui, "kind", "along the ray")
    window = before.display_window
    planar = planar_depth_m(8 * RAMP, window, window, 1.0, 50.0, 36.0)
    np.testing.assert_allclose(depths(gui), planar, rtol=1e-6)


def test_along_the_ray_takes_the_lens_in_hand_where_the_header_tells_none(ctx, tmp_path):
    bare = write_file(tmp_path / "bare.exr", channels())
    with gui_of(ctx, bare, size=SIZE, lens={"focal_length_mm": 35.0}) as gui:
        gui.ui.panels["Display"] = gui.ui.panels["Speed"] = False
        gui.frame(3)
        choose(gui, "kind", "along the ray")
        window = gui.session.source.plate.display_window
        planar = planar_depth_m(8 * RAMP, window, window, 1.0, 35.0, 36.0)
        np.testing.assert_allclose(depths(gui), planar, rtol=1e-6)


def test_a_colour_layer_is_shown(gui, plate):
    choose(gui, "colour layer", "diffuse")
    wanted = read_plate(plate, PlateOptions(color_layer="diffuse"))
    assert np.array_equal(gui.session.source.plate.color, wanted.color)
    assert gui.session.source.opened.options.color_layer == "diffuse"


def test_a_normalised_depth_waits_for_its_ends(gui):
    """Mist alone may be anything: refused, told, and then read step by step."""
    choose(gui, "channel", "mist.V")
    reading, plate = gui.session.files.commands.reading, gui.session.source.plate
    assert "may be a normalised depth" in reading.problem and plate.depth.channel == "Z"
    choose(gui, "convention", "0 near, 1 far")
    assert reading.problem.startswith("Give near and far")
    assert gui.session.source.plate is plate and gui.session.pictures.live.shown is not None
    enter(gui, "near", "50cm")
    enter(gui, "far", "10")
    assert reading.problem == ""
    np.testing.assert_allclose(depths(gui), 0.5 + RAMP * 9.5, rtol=1e-5)


def test_ends_that_cannot_be_leave_the_picture_and_say_why(gui):
    choose(gui, "convention", "1 near, 0 far")
    plate = gui.session.source.plate
    enter(gui, "near", "9")
    enter(gui, "far", "2")
    assert gui.session.source.plate is plate
    assert "near at least 0 and less than far" in gui.session.files.commands.reading.problem
    assert "--" not in gui.session.messages.text and "near 9 and far 2" in gui.session.messages.text
    enter(gui, "far", "inf")
    assert "must be finite" in gui.session.messages.text


def test_guess_again_forgets_what_was_chosen(gui, plate, preferences):
    choose(gui, "scene unit", "cm")
    gui.click(gui.middle("Guess again"))
    gui.until(lambda: not gui.session.source.opener.opening, "an answer")
    gui.frame(3)
    assert gui.session.source.opened.options == PlateOptions()
    np.testing.assert_array_equal(depths(gui), read_plate(plate).depth_m)
    assert preferences.now.plates == {}


def test_undo_reads_the_plate_as_before(gui, plate):
    choose(gui, "scene unit", "cm")
    gui.rest()
    gui.do("Undo")
    gui.until(lambda: gui.session.source.opened.options == PlateOptions(), "the plate as before")
    gui.frame(2)
    assert gui.session.files.commands.reading.options == PlateOptions()
    gui.do("Redo")
    gui.until(lambda: gui.session.source.opened.options.scene_unit_m == 0.01, "the plate again")


def test_a_plate_that_is_gone_after_undo_is_told_once(gui, plate):
    choose(gui, "scene unit", "cm")
    gui.rest()
    plate.unlink()
    gui.do("Undo")
    gui.until(lambda: "plate.exr" in gui.session.messages.text, "the sentence")
    gui.session.messages.clear()
    gui.frame(5)
    assert gui.session.messages.text == "" and not gui.session.source.opener.opening


# What it tells


def test_the_distance_under_the_pointer_is_that_of_the_pixel(gui):
    plate = gui.session.source.plate
    gui.move(gui.at_picture(20.5, 7.5))
    gui.frame(2)
    assert gui.screen.picture.hovered == (20, 7)
    assert seen_depth_m(plate, (20, 7)) == pytest.approx(8 * RAMP[7, 20])
    assert seen_depth_m(plate, (-1, 7)) is None and seen_depth_m(plate, (20, HEIGHT)) is None


def test_the_mark_in_the_histogram_moves_with_the_pointer(gui):
    """Only the mark is as bright as the wipe's handle: 235 of 255."""
    for x, y in ((2.5, 2.5), (33.5, 21.5)):
        gui.move(gui.at_picture(x, y))
        gui.frame(2)
        x0, y0, x1, _ = (round(v) for v in gui.rect("plate histogram"))
        bar = gui.screenshot()[y0 + 4 : y0 + 20, x0:x1].min(axis=(0, 2))
        part = gui.session.facts.histogram.part_at(float(8 * RAMP[int(y), int(x)]))
        assert np.flatnonzero(bar > 180).mean() == pytest.approx((1 - part) * (x1 - x0), abs=1.5)


@pytest.mark.parametrize("distance_m", [0.5, 2.0, math.inf, 1e-12])
def test_a_part_of_the_histogram_is_a_part_of_the_dioptres(distance_m):
    histogram = depth_histogram(bins_of(np.array([0.5, 0.25, 0.0], np.float32)))
    assert histogram.part_at(distance_m) == pytest.approx(
        min(1 / distance_m / histogram.most_dioptres, 1)
    )


def test_a_plate_of_blur_has_no_histogram(ctx, tmp_path):
    coc = write_file(tmp_path / "coc.exr", rgb(HEIGHT, WIDTH) | {"coc": 4 * RAMP})
    with gui_of(ctx, coc, size=SIZE, plate_options=PlateOptions(depth_convention="coc")) as gui:
        gui.ui.panels["Display"] = gui.ui.panels["Speed"] = False
        gui.frame(4)
        x0, y0, x1, y1 = (round(v) for v in gui.rect("plate because"))
        assert gui.screenshot()[y0:y1, x0:x1].max() > 150  # the text is there
        choose(gui, "convention", "guessed")  # known by its name
        assert gui.session.source.plate.coc_px is not None


# Names


def test_layers_of_colour_among_names():
    names = ["R", "G", "B", "A", "diffuse.R", "diffuse.G", "diffuse.B", "N.X", "Z", "spec.R"]
    assert color_layers_among(names) == ("", "diffuse")


def test_names_of_depth_come_first_and_none_is_lost():
    names = ["A", "B", "depth.V", "G", "N.X", "N.Y", "N.Z", "R", "Z", "mist.V"]
    sorted_names = depth_channels_first(names)
    assert sorted_names[:2] == ("Z", "depth.V") and set(sorted_names) == set(names)


def test_options_are_called_as_in_the_panel():
    said = window_words("give --near and --far, or say --depth-convention distance -- or not")
    assert said == "give near and far, or say depth convention distance -- or not"


def test_what_cannot_be_and_what_may_be_two_things_stand_at_their_controls(ctx, tmp_path):
    values = np.linspace(0.3, 1.0, HEIGHT * WIDTH, dtype=np.float32).reshape(HEIGHT, WIDTH)
    asked = write_file(
        tmp_path / "asked.exr",
        rgb(HEIGHT, WIDTH) | {"Z": 1.3 * values**8},
        **lens_attributes(50, 2, 500, 36, 24),
    )
    with gui_of(ctx, asked, Preferences(), size=SIZE) as gui:
        gui.ui.panels["Display"] = False
        gui.drawn.clear()
        gui.frame(3)
        assert "question about the convention" in gui.drawn
        assert {"doubt about focus", "doubt about the unit"} <= gui.drawn.keys()
