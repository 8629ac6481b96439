"""The strip of a reel: a card for each shot, to click, to drag to another place, to remove."""

import numpy as np

from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.framing import Framing
from heatlens.core.model.shot.reel import Reel, ReelShot
from heatlens.core.model.shot.shot import Shot
from heatlens.media.documents.reel_file import write_reel
from heatlens.media.documents.shot_file import write_shot
from support.session_files import QUICK, room_file, write_scene

WIDE = Lens(33.0, 2.8, 3.0, 36.0)  # as wide as the first camera of the scene


def wait_for_stills(gui, numbers):
    def has_stills() -> bool:
        shots = gui.session.files.reel.reel.shots
        return gui.screen._panels._reel_stills._stills.keys() == {shots[it] for it in numbers}

    gui.until(has_stills, "the pictures of the shots")


def still_pixels(gui, name):
    """Return the pixels of the still of a shot."""
    left, top, _, bottom = gui.rect(name)
    return gui.screenshot()[round(top) + 4 : round(bottom) - 4, round(left) + 4 : round(left) + 60]


def test_reel_strip_click_on_a_card_opens_its_shot(gui, tmp_path):
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
    wait_for_stills(gui, {0, 1})
    before = still_pixels(gui, "shot one")
    assert np.ptp(before.mean(2)) > 20  # the still, not the plain row
    gui.do("Brighter")
    assert (
        still_pixels(gui, "shot one").mean() > before.mean() + 5
    )  # as the screen shows the picture
    gui.click(gui.middle("shot two"))
    gui.until(lambda: session.editing.shot.source == rooms[1], "the second shot")
    gui.do("Previous shot")
    gui.until(lambda: session.editing.shot.source == rooms[0], "the first shot again")


def test_reel_strip_shows_the_still_of_a_scene_once_it_was_open(gui, tmp_path):
    two, path = tmp_path / "two.heatlens.json", tmp_path / "cut.heatreel.json"
    small = Framing(width_px=96, height_px=64)
    write_shot(two, Shot(WIDE, QUICK, str(write_scene(tmp_path / "two.glb")), framing=small))
    room = str(room_file(tmp_path / "one.exr"))
    write_reel(path, Reel("cut", (ReelShot("one", room), ReelShot("two", str(two)))))
    gui.session.files.commands.open(str(path))
    gui.until(lambda: gui.session.editing.shot.source == room, "the first shot")
    wait_for_stills(gui, {0})
    gui.click(gui.middle("shot two"))
    wait_for_stills(gui, {0, 1})
    gui.frame(2)
    sky, ground = (rows.mean((0, 1)) for rows in np.array_split(still_pixels(gui, "shot two"), 2))
    assert sky[2] > ground[2] + 20  # blue above


def drop_rooms(gui, folder, names: tuple[str, ...]) -> list[str]:
    """Drop a plate of each name on the window, and wait for the reel of them."""
    rooms = [str(room_file(folder / f"{name}.exr")) for name in names]
    gui.session.files.reel.leave()
    gui.session.files.commands.open_dropped(rooms)
    gui.until(lambda: gui.session.editing.shot.source == rooms[0], "the first shot")
    gui.settled()
    return rooms


def shot_names(gui) -> list[str]:
    return [shot.name for shot in gui.session.files.reel.reel.shots]


def test_card_dragged_past_another_changes_the_order_and_opens_nothing(gui, tmp_path):
    rooms = drop_rooms(gui, tmp_path, ("one", "two", "three"))
    left, _, right, _ = gui.rect("shot two")
    x, y = gui.middle("shot one")
    gui.drag((x, y), (right - 0.2 * (right - left), y))
    assert shot_names(gui) == ["two", "one", "three"]
    assert gui.session.editing.shot.source == rooms[0] and gui.session.files.reel.number == 1
    gui.drag(gui.middle("shot three"), (gui.rect("shot two")[0], y))
    assert shot_names(gui) == ["three", "two", "one"]


def test_cross_removes_a_shot_and_leave_ends_the_reel(gui, tmp_path):
    drop_rooms(gui, tmp_path, ("one", "two"))
    gui.move(gui.middle("shot two"))
    gui.click(gui.middle("remove two"))
    assert shot_names(gui) == ["one"] and gui.session.files.reel.number == 0
    gui.click(gui.middle("leave reel"))
    assert gui.session.files.reel.reel is None


def test_new_reel_takes_the_open_shot_and_the_dialog_adds_more(gui, tmp_path):
    """A reel of three shots takes five acts: two in the menu, the button, two double clicks."""
    rooms = [room_file(tmp_path / f"{name}.exr") for name in ("one", "two", "three")]
    gui.open(rooms[0])
    gui.choose_in_menu(next(it for it in gui.screen.commands if it.name == "New reel"))
    gui.frame(2)
    gui.click(gui.middle("add shots"))
    gui.until(lambda: not gui.ui.dialogs.walk.is_reading, "the folder")
    for count, name in ((2, "two"), (3, "three")):
        gui.frame(3)  # the rows have their places
        position = gui.middle(f"file {name}.exr")
        gui.click(position)
        gui.click(position)
        gui.until(lambda count=count: len(shot_names(gui)) == count, name)
        gui.later()
    gui.click(gui.middle("browser Done"))
    assert shot_names(gui) == ["one", "two", "three"] and gui.ui.dialogs.walk is None
    assert gui.session.files.window_title == "New reel *, 1 of 3: one"
