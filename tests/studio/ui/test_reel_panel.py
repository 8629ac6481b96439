"""The Reel panel: shown only with a reel; a click on a row opens its shot."""

import numpy as np
from imgui_bundle import imgui

from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.framing import Framing
from heatlens.core.model.shot.reel import Reel, ReelShot
from heatlens.core.model.shot.shot import Shot
from heatlens.media.documents.reel_file import write_reel
from heatlens.media.documents.shot_file import write_shot
from support.session_files import QUICK, room_file, write_scene

WIDE = Lens(33.0, 2.8, 3.0, 36.0)  # as wide as the first camera of the scene


def wait_for_stills(gui, numbers):
    stills = gui.screen._panels._reel_stills._stills
    gui.until(lambda: stills.keys() == numbers, "the pictures of the shots")


def still_pixels(gui, name):
    """Return the pixels of the still of a shot."""
    left, top, _, bottom = gui.rect(name)
    return gui.screenshot()[round(top) : round(bottom), round(left) : round(left) + 60]


def test_reel_panel_click_on_a_row_opens_its_shot(gui, tmp_path):
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
    wait_for_stills(gui, {0, 1})
    before = still_pixels(gui, "shot one")
    assert np.ptp(before.mean(2)) > 20  # the still, not the plain row
    gui.do("Brighter")
    assert (
        still_pixels(gui, "shot one").mean() > before.mean() + 5
    )  # as the screen shows the picture
    gui.click(gui.middle("shot two"))
    gui.until(lambda: session.editing.shot.source == rooms[1], "the second shot")
    gui.click(gui.middle("previous shot"))
    gui.until(lambda: session.editing.shot.source == rooms[0], "the first shot again")


def test_reel_panel_shows_the_still_of_a_scene_once_it_was_open(gui, tmp_path):
    two, path = tmp_path / "two.heatlens.json", tmp_path / "cut.heatreel.json"
    small = Framing(width_px=96, height_px=64)
    write_shot(two, Shot(WIDE, QUICK, str(write_scene(tmp_path / "two.glb")), framing=small))
    room = str(room_file(tmp_path / "one.exr"))
    write_reel(path, Reel("cut", (ReelShot("one", room), ReelShot("two", str(two)))))
    gui.session.files.commands.open(str(path))
    gui.until(lambda: gui.session.editing.shot.source == room, "the first shot")
    imgui.set_window_focus("Reel")
    gui.frame(3)
    wait_for_stills(gui, {0})
    gui.click(gui.middle("shot two"))
    wait_for_stills(gui, {0, 1})
    gui.frame(2)
    sky, ground = (rows.mean((0, 1)) for rows in np.array_split(still_pixels(gui, "shot two"), 2))
    assert sky[2] > ground[2] + 20  # blue above
