"""The Reel panel: there with a reel alone, and a click on a row opens its shot."""

import numpy as np
from imgui_bundle import imgui

from heatlens.documents.reel_file import write_reel
from heatlens.model.shot.reel import Reel, ReelShot
from support.session_files import room_file


def test_a_click_on_a_row_opens_its_shot(gui, tmp_path):
    gui.settled()
    assert "shot two" not in gui.drawn
    rooms = [str(room_file(tmp_path / f"{name}.exr")) for name in ("one", "two")]
    path = tmp_path / "cut.heatreel.json"
    write_reel(
        path, Reel("cut", tuple(ReelShot(n, s) for n, s in zip(("one", "two"), rooms, strict=True)))
    )
    session = gui.session
    session.files.commands.open(str(path))
    gui.until(lambda: session.editing.shot.source == rooms[0], "the first shot")
    imgui.set_window_focus("Reel")
    gui.frame(3)
    textures = gui.screen._panels._reel_textures._textures
    gui.until(lambda: textures.keys() == {0, 1}, "the pictures of both shots")
    left, top, _, bottom = gui.rect("shot one")
    row = gui.screenshot()[round(top) : round(bottom), round(left) : round(left) + 60]
    assert np.ptp(row.reshape(-1, 3).mean(1)) > 20  # the still, not the plain row
    gui.click(gui.middle("shot two"))
    gui.until(lambda: session.editing.shot.source == rooms[1], "the second shot")
    gui.click(gui.middle("previous shot"))
    gui.until(lambda: session.editing.shot.source == rooms[0], "the first shot again")
