"""B by another method in the window: to the pixel what is rendered alone, and only while seen."""

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
from support.window_plates import displayed, region

K = imgui.Key
OF_PLATES = [method for method in Method if not method.needs_scene]


@pytest.fixture(scope="module")
def own(session_context) -> FrameRenderer:
    """Return a renderer that is not the window's."""
    return FrameRenderer(session_context)


@pytest.fixture
def gui(gui):
    gui.do("1:1")
    gui.settled()
    return gui


@pytest.fixture
def asked(gui, monkeypatch) -> list[Method]:
    """Return the method of every picture that is begun for B."""
    found: list[Method] = []
    steps = gui.session.pictures.renderer.steps

    def counted(shot, frame=0, slot=0):
        if slot >= 2:
            found.append(shot.defocus.method)
        return steps(shot, frame, slot)

    monkeypatch.setattr(gui.session.pictures.renderer, "steps", counted)
    return found


def alone(gui, own: FrameRenderer, method: Method) -> np.ndarray:
    """Return (H, W, 3) bytes of the shot by `method`, rendered again from its file."""
    shot = gui.session.facts.shot
    own.load(read_plate(gui.session.source.plate.path))
    return displayed(gui, own.pixels(replace(shot, defocus=replace(shot.defocus, method=method))))


def by_method(gui, method: Method, compare: Compare = Compare.FLIP) -> None:
    gui.session.pictures.view.state = replace(
        gui.session.facts.view, against=Against.METHOD, b_method=method, compare=compare
    )
    gui.frame(2)
    gui.settled()


def picked(gui, name: str, item: str) -> None:
    """Pick an item of a drop-down with the mouse."""
    gui.later()
    gui.click(gui.middle(name))
    gui.frame(2)
    gui.click(gui.middle(f"{name}: {item}"))
    gui.frame(2)


def with_panel(gui, name: str) -> None:
    """Show only this panel, so that it has all the room."""
    gui.ui.panels = {panel: panel == name for panel in gui.ui.panels}
    gui.frame(3)


@pytest.mark.parametrize("method", OF_PLATES)
def test_b_is_the_shot_by_that_method_alone(gui, own, method):
    by_method(gui, method)
    np.testing.assert_array_equal(region(gui), alone(gui, own, method))


def test_the_wipe_shows_a_left_and_the_method_right(gui, own):
    by_method(gui, Method.GATHER, Compare.WIPE)
    seen, line = region(gui), WIDTH // 2
    free = slice(line + 30, None)  # beside grip and letters
    np.testing.assert_array_equal(seen[:, free], alone(gui, own, Method.GATHER)[:, free])
    free = slice(0, line - 30)
    np.testing.assert_array_equal(seen[:, free], alone(gui, own, Method.DIFFUSION)[:, free])
    assert np.any(alone(gui, own, Method.GATHER) != alone(gui, own, Method.DIFFUSION))


def test_b_follows_the_lens_and_a_is_as_if_it_were_alone(gui, own):
    by_method(gui, Method.SCATTER)
    before = region(gui)
    gui.click(gui.at_picture(POST[0] + 0.5, POST[1] + 0.5))
    gui.settled()
    np.testing.assert_array_equal(region(gui), alone(gui, own, Method.SCATTER))
    assert np.any(region(gui) != before)
    a = own.pixels(gui.session.facts.shot)
    np.testing.assert_array_equal(download(gui.session.pictures.live.shown.texture), a)


def test_the_difference_from_the_same_method_is_black_and_from_another_is_not(gui):
    by_method(gui, Method.DIFFUSION, Compare.DIFFERENCE)
    assert region(gui).max() == 0
    by_method(gui, Method.PYRAMID, Compare.DIFFERENCE)
    assert region(gui).max() > 0


def test_nothing_is_rendered_for_b_while_it_is_not_seen(gui, asked):
    def turn() -> None:
        lens = gui.session.facts.lens
        gui.session.editing.edit_lens(replace(lens, focus_distance_m=lens.focus_distance_m * 1.1))
        gui.frame(2)
        gui.settled()

    by_method(gui, Method.GATHER, Compare.OFF)
    turn()
    gui.session.pictures.view.state = replace(
        gui.session.facts.view, against=Against.PINHOLE, compare=Compare.WIPE
    )
    turn()
    by_method(gui, gui.session.facts.shot.defocus.method)  # A is it already
    assert asked == []
    by_method(gui, Method.GATHER)
    assert asked and asked[-1] is Method.GATHER
    asked.clear()
    gui.session.pictures.view.state = replace(gui.session.facts.view, compare=Compare.OFF)
    turn()
    assert asked == []


def test_a_whole_b_is_not_made_again(gui, asked):
    by_method(gui, Method.GATHER)
    asked.clear()
    for _ in range(2):
        gui.key(K.x)
        gui.settled()
    assert asked == []


# By hand


def test_both_methods_are_chosen_in_the_panels(gui, own):
    gui.session.pictures.view.state = replace(gui.session.facts.view, compare=Compare.FLIP)
    with_panel(gui, "Display")
    picked(gui, "compare with", "method gather")
    assert (gui.session.facts.view.against, gui.session.facts.view.b_method) == (
        Against.METHOD,
        Method.GATHER,
    )
    gui.settled()
    np.testing.assert_array_equal(region(gui), alone(gui, own, Method.GATHER))
    picked(gui, "compare with", "method raytraced")
    assert (
        gui.session.facts.view.b_method is Method.GATHER
    )  # there is no scene, and the list stays open
    gui.click(gui.middle("compare with: pinhole"))
    gui.frame(2)
    assert gui.session.facts.view.against is Against.PINHOLE
    with_panel(gui, "Lens")
    picked(gui, "method", "pyramid")
    assert gui.session.facts.shot.defocus.method is Method.PYRAMID
    picked(gui, "method", "accumulation")
    assert gui.session.facts.shot.defocus.method is Method.PYRAMID


@pytest.mark.parametrize("method", OF_PLATES)
def test_the_palette_compares_with_a_method(gui, method):
    gui.do(f"Compare with {method}")
    view = gui.session.facts.view
    assert (view.compare, view.against, view.b_method) == (Compare.WIPE, Against.METHOD, method)
    gui.do("Flip to B")
    gui.do("Compare with pinhole")
    assert (gui.session.facts.view.compare, gui.session.facts.view.against) == (
        Compare.FLIP,
        Against.PINHOLE,
    )


def test_a_method_that_needs_a_scene_is_refused_aloud(gui):
    before = gui.session.facts.view
    gui.do("Compare with raytraced")
    assert gui.session.facts.view == before
    assert "scene" in gui.session.messages.text


def test_the_status_says_what_a_and_b_are(gui):
    def said() -> str:
        return words(
            gui.session.facts.view,
            gui.session.pictures.sides,
            None,
            gui.session.pictures.live.shown,
        )

    assert said() == "diffusion"
    by_method(gui, Method.GATHER, Compare.WIPE)
    assert said() == "A: diffusion    B: gather"
    gui.session.pictures.view.state = replace(
        gui.session.facts.view, against=Against.REFERENCE, depth_of_field=False
    )
    assert said() == "A: pinhole    B: pinhole"


def test_a_shot_that_cannot_be_rendered_is_told_once_and_keeps_nothing_busy(gui):
    """A shot of a scene whose source became a plate, say."""
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
    assert gui.session.pictures.live.shown.shot == shot
