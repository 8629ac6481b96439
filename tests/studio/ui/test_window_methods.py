"""B by another method in the window: equal to a separate render, and rendered only if shown."""

from dataclasses import replace

import numpy as np
import pytest
from imgui_bundle import imgui

from heatlens.core.model.shot.settings import Method
from heatlens.core.model.view.view import Against, Compare
from heatlens.media.plate.read import read_plate
from heatlens.render.frame_renderer import FrameRenderer
from heatlens.render.gpu.textures import download
from heatlens.studio.ui.status_bar import sides_words as words
from support.session_files import POST, WIDTH
from support.window_plates import display_bytes, screen_region

K = imgui.Key
PLATE_METHODS = [method for method in Method if not method.needs_scene]


@pytest.fixture
def gui(gui):
    gui.do("1:1")
    gui.settled()
    return gui


@pytest.fixture
def methods_of_b(gui, monkeypatch) -> list[Method]:
    """Return the method of every picture that is begun for B."""
    found: list[Method] = []
    steps = gui.session.pictures.renderer.steps

    def record_method(shot, frame=0, slot=0, enlarges=False):
        if slot >= 2:
            found.append(shot.defocus.method)
        return steps(shot, frame, slot, enlarges)

    monkeypatch.setattr(gui.session.pictures.renderer, "steps", record_method)
    return found


def render_separately(gui, other_renderer: FrameRenderer, method: Method) -> np.ndarray:
    """Return (H, W, 3) bytes of the shot by `method`, rendered again from its file."""
    shot = gui.session.facts.shot
    other_renderer.load(read_plate(gui.session.source.plate.path))
    return display_bytes(
        gui, other_renderer.pixels(replace(shot, defocus=replace(shot.defocus, method=method)))
    )


def compare_with_method(gui, method: Method, compare: Compare = Compare.FLIP) -> None:
    gui.session.pictures.view.state = replace(
        gui.session.facts.view, against=Against.METHOD, b_method=method, compare=compare
    )
    gui.frame(2)
    gui.settled()


def pick_item(gui, name: str, item: str) -> None:
    """Pick an item of a drop-down with the mouse."""
    gui.later()
    gui.click(gui.middle(name))
    gui.frame(2)
    gui.click(gui.middle(f"{name}: {item}"))
    gui.frame(2)


def show_only_panel(gui, name: str) -> None:
    """Show only this panel, so that it is as tall as possible."""
    gui.ui.panels = {panel: panel == name for panel in gui.ui.panels}
    gui.frame(3)


@pytest.mark.parametrize("method", PLATE_METHODS)
def test_b_by_a_method_equals_a_separate_render(gui, other_renderer, method):
    compare_with_method(gui, method)
    np.testing.assert_array_equal(
        screen_region(gui), render_separately(gui, other_renderer, method)
    )


def test_wipe_shows_a_left_and_the_other_method_right(gui, other_renderer):
    compare_with_method(gui, Method.GATHER, Compare.WIPE)
    pixels, line = screen_region(gui), WIDTH // 2
    columns = slice(line + 30, None)  # beside grip and letters
    np.testing.assert_array_equal(
        pixels[:, columns], render_separately(gui, other_renderer, Method.GATHER)[:, columns]
    )
    columns = slice(0, line - 30)
    np.testing.assert_array_equal(
        pixels[:, columns], render_separately(gui, other_renderer, Method.DIFFUSION)[:, columns]
    )
    assert np.any(
        render_separately(gui, other_renderer, Method.GATHER)
        != render_separately(gui, other_renderer, Method.DIFFUSION)
    )


def test_b_follows_the_lens_and_a_stays_the_renderers_picture(gui, other_renderer):
    compare_with_method(gui, Method.SCATTER)
    before = screen_region(gui)
    gui.click(gui.at_picture(POST[0] + 0.5, POST[1] + 0.5))
    gui.settled()
    np.testing.assert_array_equal(
        screen_region(gui), render_separately(gui, other_renderer, Method.SCATTER)
    )
    assert np.any(screen_region(gui) != before)
    a = other_renderer.pixels(gui.session.facts.shot)
    np.testing.assert_array_equal(download(gui.session.pictures.live.output.texture), a)


def test_difference_is_black_only_for_the_same_method(gui):
    compare_with_method(gui, Method.DIFFUSION, Compare.DIFFERENCE)
    assert screen_region(gui).max() == 0
    compare_with_method(gui, Method.PYRAMID, Compare.DIFFERENCE)
    assert screen_region(gui).max() > 0


def test_b_is_not_rendered_while_it_is_not_shown(gui, methods_of_b):
    def change_focus() -> None:
        lens = gui.session.facts.lens
        gui.session.editing.edit_lens(replace(lens, focus_distance_m=lens.focus_distance_m * 1.1))
        gui.frame(2)
        gui.settled()

    compare_with_method(gui, Method.GATHER, Compare.OFF)
    change_focus()
    gui.session.pictures.view.state = replace(
        gui.session.facts.view, against=Against.PINHOLE, compare=Compare.WIPE
    )
    change_focus()
    compare_with_method(gui, gui.session.facts.shot.defocus.method)  # A is it already
    assert methods_of_b == []
    compare_with_method(gui, Method.GATHER)
    assert methods_of_b and methods_of_b[-1] is Method.GATHER
    methods_of_b.clear()
    gui.session.pictures.view.state = replace(gui.session.facts.view, compare=Compare.OFF)
    change_focus()
    assert methods_of_b == []


def test_whole_b_is_not_rendered_again(gui, methods_of_b):
    compare_with_method(gui, Method.GATHER)
    methods_of_b.clear()
    for _ in range(2):
        gui.key(K.x)
        gui.settled()
    assert methods_of_b == []


# By hand


def test_methods_of_a_and_b_are_chosen_in_the_panels(gui, other_renderer):
    gui.session.pictures.view.state = replace(gui.session.facts.view, compare=Compare.FLIP)
    show_only_panel(gui, "Display")
    pick_item(gui, "compare with", "method gather")
    assert (gui.session.facts.view.against, gui.session.facts.view.b_method) == (
        Against.METHOD,
        Method.GATHER,
    )
    gui.settled()
    np.testing.assert_array_equal(
        screen_region(gui), render_separately(gui, other_renderer, Method.GATHER)
    )
    pick_item(gui, "compare with", "method raytraced")
    assert (
        gui.session.facts.view.b_method is Method.GATHER
    )  # there is no scene, and the list stays open
    gui.click(gui.middle("compare with: pinhole"))
    gui.frame(2)
    assert gui.session.facts.view.against is Against.PINHOLE
    show_only_panel(gui, "Lens")
    gui.unfolded("Rendering", "method")
    pick_item(gui, "method", "pyramid")
    assert gui.session.facts.shot.defocus.method is Method.PYRAMID
    pick_item(gui, "method", "accumulation")
    assert gui.session.facts.shot.defocus.method is Method.PYRAMID


@pytest.mark.parametrize("method", PLATE_METHODS)
def test_compare_with_method_actions_set_b(gui, method):
    gui.do(f"Compare with {method}")
    view = gui.session.facts.view
    assert (view.compare, view.against, view.b_method) == (Compare.WIPE, Against.METHOD, method)
    gui.do("Show B")
    gui.do("Compare with pinhole")
    assert (gui.session.facts.view.compare, gui.session.facts.view.against) == (
        Compare.FLIP,
        Against.PINHOLE,
    )


def test_compare_with_a_scene_method_is_refused_for_a_plate(gui):
    before = gui.session.facts.view
    gui.do("Compare with raytraced")
    assert gui.session.facts.view == before
    assert "scene" in gui.session.messages.text


def test_status_words_name_the_methods_of_a_and_b(gui):
    def status_words() -> str:
        return words(
            gui.session.facts.view, gui.session.pictures, None, gui.session.pictures.live.output
        )

    assert status_words() == "diffusion"
    compare_with_method(gui, Method.GATHER, Compare.WIPE)
    assert status_words() == "A: diffusion    B: gather"
    gui.session.pictures.view.state = replace(
        gui.session.facts.view, against=Against.REFERENCE, depth_of_field=False
    )
    assert status_words() == "A: pinhole    B: pinhole"


def test_shot_with_an_impossible_method_is_reported_once(gui):
    """This happens for a shot of a scene whose source became a plate."""
    shot = gui.session.facts.shot
    defocus = replace(shot.defocus, method=Method.ACCUMULATION)
    gui.session.editing.edit(replace(shot, defocus=defocus))
    gui.frame(2)
    assert (
        "accumulation" in gui.session.messages.text and not gui.session.time.scheduler.is_rendering
    )
    gui.session.messages.clear()
    gui.frame(2)
    gui.session.work()
    assert gui.session.messages.text == ""
    gui.session.editing.edit(shot)
    gui.settled()
    assert gui.session.pictures.live.output.shot == shot
