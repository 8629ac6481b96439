"""Pictures of several lens views in the window: both sides of a comparison, and their number."""

from dataclasses import replace

import numpy as np
import pytest

from heatlens.core.model.shot.settings import DefocusSettings, Method
from heatlens.core.model.view.view import Against, Compare
from heatlens.render.frame_renderer import FrameRenderer
from heatlens.render.gpu.textures import download
from support.gui import gui_of
from support.scenes import still_life
from support.window_plates import display_bytes, screen_region


@pytest.fixture
def scene_gui(ctx, small_demo):
    """Yield a window with the small demo scene at 1:1."""
    quick = DefocusSettings(layers=1, views=8)
    with gui_of(ctx, "demo", defocus=quick) as gui:
        gui.do("1:1")
        gui.settled()
        yield gui


def test_a_and_b_by_scene_methods_equal_separate_renders(scene_gui):
    gui = scene_gui
    defocus = replace(gui.session.facts.shot.defocus, method=Method.ACCUMULATION)
    gui.session.editing.edit(replace(gui.session.facts.shot, defocus=defocus))
    gui.session.pictures.view.state = replace(
        gui.session.facts.view,
        against=Against.METHOD,
        b_method=Method.RAYTRACED,
        compare=Compare.FLIP,
    )
    gui.frame(3)
    gui.settled()
    renderer = FrameRenderer(gui.ctx)
    renderer.load_scene(still_life())
    shot, frame = gui.session.facts.shot, gui.session.editing.frame
    a = renderer.pixels(shot, frame)
    np.testing.assert_allclose(
        download(gui.session.pictures.live.output.texture), a, rtol=1e-4, atol=1e-5
    )
    b_shot = replace(shot, defocus=replace(defocus, method=Method.RAYTRACED))
    b = display_bytes(gui, renderer.pixels(b_shot, frame)).astype(int)
    assert np.abs(screen_region(gui) - b).max() <= 1
    assert np.abs(b - display_bytes(gui, a)).max() > 1


def test_views_slider_sets_the_views_of_a_scene_method(scene_gui):
    gui = scene_gui
    gui.ui.panels = {panel: panel == "Lens" for panel in gui.ui.panels}
    gui.frame(3)
    gui.unfolded("Rendering", "method")
    gui.click(gui.middle("method"))
    gui.frame(2)
    gui.click(gui.middle("method: accumulation"))
    gui.frame(3)
    assert gui.session.facts.shot.defocus.method is Method.ACCUMULATION
    x0, y0, _, y1 = gui.rect("views")
    gui.drag((x0 + 60, (y0 + y1) / 2), (x0 + 90, (y0 + y1) / 2))
    assert 8 < gui.session.facts.shot.defocus.views < 256
    gui.settled()
    assert gui.session.pictures.live.output.settings == gui.session.facts.shot.defocus
