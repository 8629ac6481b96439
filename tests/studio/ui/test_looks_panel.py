"""The Looks panel: a still of each look, one click back, and a wipe against it."""

from dataclasses import replace

import numpy as np
from imgui_bundle import imgui

from heatlens.core.model.view.view import Against, Compare

K = imgui.Key


def test_looks_panel_shows_compares_and_restores_a_kept_look(gui):
    session = gui.session
    gui.settled()
    gui.key(K.l, shift=True)
    imgui.set_window_focus("Looks")
    gui.settled()
    first = session.facts.lens
    stills = gui.screen._panels.stills
    still = stills.thumbnail(session.facts.shot.looks[0])
    assert still is not None
    pixels = np.frombuffer(still.read(), np.uint8).reshape(still.height, still.width, 4)
    assert pixels[..., :3].std() > 10  # a picture
    session.editing.edit_lens(replace(first, f_stop=8.0, focus_distance_m=1.0))
    gui.rest()
    gui.settled()
    gui.click(gui.middle("wipe A"))
    gui.settled()
    assert (session.facts.view.against, session.facts.view.compare) == (Against.LOOK, Compare.WIPE)
    assert session.pictures.sides.b.output.shot.lens_at(session.facts.frame) == first
    gui.later()
    gui.click(gui.middle("look A"))
    gui.frame(2)
    assert session.facts.lens == first
    gui.key(K.z, ctrl=True)
    assert session.facts.lens.f_stop == 8.0
    gui.key(K._1, ctrl=True)
    assert session.facts.lens == first
