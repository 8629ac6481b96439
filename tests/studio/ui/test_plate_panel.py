"""The Source panel of a plate: how it was read, and reading it again with other options."""

import math

import numpy as np
import pytest
from imgui_bundle import imgui

from heatlens.core.base.messages import window_words
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.core.model.value_bins import bin_values, depth_histogram
from heatlens.media.plate.depth_read import planar_depth_m
from heatlens.media.plate.header.camera_header import lens_attributes
from heatlens.media.plate.header.channel_choice import color_layers_among, depth_channels_first
from heatlens.media.plate.read import read_plate
from heatlens.render.display.pixel_reading import visible_depth_m
from heatlens.studio.settings.preferences import Preferences
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
        imgui.set_window_focus("Source")
        gui.frame(3)
        yield gui


def choose(gui, control, item):
    gui.click(gui.middle(control))
    gui.frame(2)
    gui.click(gui.middle(f"{control}: {item}"))
    gui.until(lambda: not gui.session.source.opener.opening, "an answer")
    gui.frame(3)


def test_neighbors_control_sets_the_option(gui):
    choose(gui, "neighbours", "2 on either side")
    assert gui.session.facts.shot.plate_options.neighbours == 2
    choose(gui, "neighbours", "none")
    assert gui.session.facts.shot.plate_options.neighbours == 0


def enter(gui, control, text):
    gui.click(gui.middle(control))
    gui.type(text)
    gui.click(gui.middle("distance"))
    gui.until(lambda: not gui.session.source.opener.opening, "an answer")
    gui.frame(3)


def test_never_blur_is_typed_and_only_blur_can_be_picked(gui):
    imgui.set_window_focus("Lens")
    gui.frame(2)
    gui.unfolded("Mattes for the blur", "never blur")
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


def test_chosen_depth_channel_is_read_and_the_lens_stays(gui):
    lens = gui.session.facts.lens
    choose(gui, "channel", "Z")
    assert gui.session.source.plate.depth.channel == "Z"
    assert gui.session.facts.lens == lens
    assert gui.session.facts.shot.plate_options == PlateOptions(depth_channel="Z")


@pytest.mark.parametrize(
    ("item", "of"), [("distance", lambda z: z), ("1 / distance", lambda z: 1 / z)]
)
def test_chosen_convention_converts_the_depth(gui, item, of):
    choose(gui, "convention", item)
    np.testing.assert_allclose(depths(gui), of(8 * RAMP), rtol=1e-6)


def test_scene_unit_is_chosen_by_name_or_typed_in_meters(gui):
    choose(gui, "scene unit", "ft")
    np.testing.assert_allclose(depths(gui), 0.3048 * 8 * RAMP, rtol=1e-6)
    enter(gui, "in metres", "0.5")
    np.testing.assert_allclose(depths(gui), 0.5 * 8 * RAMP, rtol=1e-6)
    enter(gui, "in metres", "none")
    assert "'none' is not a number" in gui.session.messages.text
    assert gui.session.files.commands.reading.options == PlateOptions(scene_unit_m=0.5)


def test_depth_along_the_ray_is_converted_to_planar_depth(gui):
    before = gui.session.source.plate
    choose(gui, "kind", "along the ray")
    window = before.display_window
    planar = planar_depth_m(8 * RAMP, window, window, 1.0, 50.0, 36.0)
    np.testing.assert_allclose(depths(gui), planar, rtol=1e-6)


def test_depth_along_the_ray_uses_the_lens_if_the_header_has_none(ctx, tmp_path):
    bare = write_file(tmp_path / "bare.exr", channels())
    with gui_of(ctx, bare, size=SIZE, lens={"focal_length_mm": 35.0}) as gui:
        imgui.set_window_focus("Source")
        gui.frame(3)
        choose(gui, "kind", "along the ray")
        window = gui.session.source.plate.display_window
        planar = planar_depth_m(8 * RAMP, window, window, 1.0, 35.0, 36.0)
        np.testing.assert_allclose(depths(gui), planar, rtol=1e-6)


def test_chosen_color_layer_is_shown(gui, plate):
    choose(gui, "colour layer", "diffuse")
    expected = read_plate(plate, PlateOptions(color_layer="diffuse"))
    assert np.array_equal(gui.session.source.plate.color, expected.color)
    assert gui.session.source.opened.options.color_layer == "diffuse"


def test_normalized_depth_is_read_once_near_and_far_are_given(gui):
    """The ambiguous channel is refused with a message until convention, near and far are given."""
    choose(gui, "channel", "mist.V")
    reading, plate = gui.session.files.commands.reading, gui.session.source.plate
    assert "may be a normalised depth" in reading.problem and plate.depth.channel == "Z"
    choose(gui, "convention", "0 near, 1 far")
    assert reading.problem.startswith("Give near and far")
    assert gui.session.source.plate is plate and gui.session.pictures.live.output is not None
    enter(gui, "near", "50cm")
    enter(gui, "far", "10")
    assert reading.problem == ""
    np.testing.assert_allclose(depths(gui), 0.5 + RAMP * 9.5, rtol=1e-5)


def test_impossible_near_and_far_are_reported_and_the_plate_stays(gui):
    choose(gui, "convention", "1 near, 0 far")
    plate = gui.session.source.plate
    enter(gui, "near", "9")
    enter(gui, "far", "2")
    assert gui.session.source.plate is plate
    assert "near at least 0 and less than far" in gui.session.files.commands.reading.problem
    assert "--" not in gui.session.messages.text and "near 9 and far 2" in gui.session.messages.text
    enter(gui, "far", "inf")
    assert "must be finite" in gui.session.messages.text


def test_guess_again_button_resets_the_options(gui, plate, preferences):
    choose(gui, "scene unit", "cm")
    gui.click(gui.middle("Guess again"))
    gui.until(lambda: not gui.session.source.opener.opening, "an answer")
    gui.frame(3)
    assert gui.session.source.opened.options == PlateOptions()
    np.testing.assert_array_equal(depths(gui), read_plate(plate).depth_m)
    assert preferences.values.plates == {}


def test_undo_and_redo_reread_the_plate_with_their_options(gui, plate):
    choose(gui, "scene unit", "cm")
    gui.rest()
    gui.do("Undo")
    gui.until(lambda: gui.session.source.opened.options == PlateOptions(), "the plate as before")
    gui.frame(2)
    assert gui.session.files.commands.reading.options == PlateOptions()
    gui.do("Redo")
    gui.until(lambda: gui.session.source.opened.options.scene_unit_m == 0.01, "the plate again")


def test_missing_plate_after_undo_is_reported_once(gui, plate):
    choose(gui, "scene unit", "cm")
    gui.rest()
    plate.unlink()
    gui.do("Undo")
    gui.until(lambda: "plate.exr" in gui.session.messages.text, "the sentence")
    gui.session.messages.clear()
    gui.frame(5)
    assert gui.session.messages.text == "" and not gui.session.source.opener.opening


# What it tells


def test_visible_depth_is_that_of_the_hovered_pixel(gui):
    plate = gui.session.source.plate
    gui.move(gui.at_picture(20.5, 7.5))
    gui.frame(2)
    assert gui.screen.picture.hovered_px == (20, 7)
    assert visible_depth_m(plate, (20, 7)) == pytest.approx(8 * RAMP[7, 20])
    assert visible_depth_m(plate, (-1, 7)) is None and visible_depth_m(plate, (20, HEIGHT)) is None


def test_histogram_mark_follows_the_depth_under_the_pointer(gui):
    """The mark is found by its brightness: no other column of the bar is above 180 of 255."""
    for x, y in ((2.5, 2.5), (33.5, 21.5)):
        gui.move(gui.at_picture(x, y))
        gui.frame(2)
        x0, y0, x1, _ = (round(v) for v in gui.rect("plate histogram"))
        bar = gui.screenshot()[y0 + 4 : y0 + 20, x0:x1].min(axis=(0, 2))
        fraction = gui.session.facts.histogram.scale_position(float(8 * RAMP[int(y), int(x)]))
        assert np.flatnonzero(bar > 180).mean() == pytest.approx(
            (1 - fraction) * (x1 - x0), abs=1.5
        )


@pytest.mark.parametrize("distance_m", [0.5, 2.0, math.inf, 1e-12])
def test_histogram_part_at_is_linear_in_dioptres(distance_m):
    histogram = depth_histogram(bin_values(np.array([0.5, 0.25, 0.0], np.float32)))
    assert histogram.scale_position(distance_m) == pytest.approx(
        min(1 / distance_m / histogram.most_dioptres, 1)
    )


def test_plate_of_blur_sizes_has_no_histogram_and_says_why(ctx, tmp_path):
    coc = write_file(tmp_path / "coc.exr", rgb(HEIGHT, WIDTH) | {"coc": 4 * RAMP})
    with gui_of(ctx, coc, size=SIZE, plate_options=PlateOptions(depth_convention="coc")) as gui:
        imgui.set_window_focus("Source")
        gui.frame(4)
        x0, y0, x1, y1 = (round(v) for v in gui.rect("plate because"))
        assert gui.screenshot()[y0:y1, x0:x1].max() > 150  # the text is there
        choose(gui, "convention", "guessed")  # known by its name
        assert gui.session.source.plate.coc_px is not None


# Names


def test_color_layers_among_finds_layers_with_red_green_and_blue():
    names = ["R", "G", "B", "A", "diffuse.R", "diffuse.G", "diffuse.B", "N.X", "Z", "spec.R"]
    assert color_layers_among(names) == ("", "diffuse")


def test_depth_channels_first_sorts_names_of_depth_first():
    names = ["A", "B", "depth.V", "G", "N.X", "N.Y", "N.Z", "R", "Z", "mist.V"]
    sorted_names = depth_channels_first(names)
    assert sorted_names[:2] == ("Z", "depth.V") and set(sorted_names) == set(names)


def test_window_words_names_options_as_in_the_panel():
    words = window_words("give --near and --far, or say --depth-convention distance -- or not")
    assert words == "give near and far, or say depth convention distance -- or not"


def test_doubts_about_depth_are_shown_beside_their_controls(ctx, tmp_path):
    values = np.linspace(0.3, 1.0, HEIGHT * WIDTH, dtype=np.float32).reshape(HEIGHT, WIDTH)
    plate = write_file(
        tmp_path / "asked.exr",
        rgb(HEIGHT, WIDTH) | {"Z": 1.3 * values**8},
        **lens_attributes(50, 2, 500, 36, 24),
    )
    with gui_of(ctx, plate, Preferences(), size=SIZE) as gui:
        assert "plate because" in gui.drawn  # in front by itself
        for panel in ("Lens", "Source"):
            imgui.set_window_focus(panel)
            gui.frame(3)
        assert "question about the convention" in gui.drawn
        assert {"doubt about focus", "doubt about the unit"} <= gui.drawn.keys()
