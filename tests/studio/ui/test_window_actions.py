"""Everything that can be done, by menu and by key; the palette, the keys, and opening files."""

from dataclasses import replace
from itertools import groupby

import numpy as np
import pytest
from imgui_bundle import imgui

from heatlens.core.model.shot.grade import Grade
from heatlens.render.gpu.textures import download
from heatlens.studio.board.command import MENUS, Command
from heatlens.studio.board.commands import named_commands
from heatlens.studio.ui.palette import matches
from heatlens.studio.ui.shortcuts import CTRL, SHIFT, chord_of
from support.commands import listed_commands
from support.session_files import BALL, POST, room_file

K = imgui.Key
ALL = listed_commands()
KEYED = [action for action in ALL if action.key]


def ids(action: Command) -> str:
    return action.name


def of(gui, action: Command) -> Command:
    """Return the same action, bound to this window."""
    return next(other for other in gui.screen.commands if other.name == action.name)


def chosen(gui, action: Command) -> None:
    """Choose it in its menu, by hand."""
    gui.click(gui.middle(f"menu {action.menu}"))
    gui.click(gui.middle(f"item {action.name}"))


def done(gui, action: Command) -> None:
    """Do it once more without a hand, which leaves the picture as it was."""
    gui.do(action.name)


def keyed(gui, action: Command) -> None:
    key, mods = chord_of(action.key)
    gui.key(key, ctrl=bool(mods & CTRL), shift=bool(mods & SHIFT))


def closed(gui) -> None:
    """Close again what an action opened, as a user would."""
    if gui.ui.dialogs.is_open:
        gui.frame(3)
        gui.key(K.escape)
        gui.frame(2)
        assert not gui.ui.dialogs.is_open
    gui.key(K.escape)
    gui.ui.is_over = False


def state(gui) -> tuple:
    """Return all that an action can change and that is seen at once."""
    session = gui.session
    ui = gui.ui
    others = (ui.shows_keys, ui.is_over, ui.dialogs.is_open, session.source.picture.version)
    return session.facts.shot, session.facts.view, dict(ui.panels), *others


@pytest.mark.parametrize("by", [chosen, keyed], ids=["menu", "key"])
def test_every_action_can_be_done_twice(gui, small_demo, by):
    """Nothing is raised, OpenGL has no error (each frame asks), and the picture comes back."""
    gui.session.pictures.references.open(gui.session.source.plate.path)
    gui.until(lambda: gui.session.facts.reference is not None, "the reference")
    for action in ALL if by is chosen else KEYED:
        if action.name in ("Picture alone", "Full screen", "Grid of looks", "Ruler"):
            continue  # Escape leaves them: test_picture_alone, test_look_grid, test_ruler
        if action.name == "Grade of the shot":  # which no shot has that was opened before
            gui.session.editing.begin(replace(gui.session.facts.shot, grade=Grade()))
        for does in (by, by if by is keyed else done):
            is_on = of(gui, action).is_on
            was_on = is_on is not None and is_on()
            does(gui, action)
            gui.until(lambda: not gui.session.source.opener.opening, "the plate")
            closed(gui)
            assert is_on is None or is_on() is not was_on, action.name
    gui.settled()
    assert gui.session.pictures.live.shown.shot == gui.session.facts.shot


def test_no_two_actions_share_a_name_or_a_key():
    assert len({action.name for action in ALL}) == len(ALL)
    assert len({chord_of(action.key) for action in KEYED}) == len(KEYED)
    assert len({action.key for action in KEYED}) == len(KEYED)


@pytest.mark.parametrize(
    ("name", "shortcut"),
    [
        *(("Undo", "Ctrl+Z"), ("Redo", "Ctrl+Shift+Z"), ("Keys", "?"), ("1:1", "1")),
        *(("Zoom in", "+"), ("Save shot", "Ctrl+S"), ("Save picture...", "Ctrl+Shift+E")),
    ],
)
def test_shortcuts_are_written_as_people_read_them(name, shortcut):
    assert next(action for action in ALL if action.name == name).key == shortcut


@pytest.mark.parametrize("action", [a for a in KEYED if a.is_on is not None], ids=ids)
def test_a_switch_switches_and_its_key_switches_back(gui, action):
    gui.session.pictures.references.open(gui.session.source.plate.path)
    gui.until(lambda: gui.session.facts.reference is not None, "the reference")
    gui.session.pictures.looks.keep()  # without a look there is no grid
    is_on = of(gui, action).is_on
    was = is_on()
    keyed(gui, action)
    assert is_on() is not was
    keyed(gui, action)
    assert is_on() is was


def test_a_plus_needs_shift_on_many_keyboards(gui):
    zoom = gui.session.pictures.view.zoom
    gui.key(K.equal, shift=True)
    gui.frame()
    assert gui.session.pictures.view.zoom == pytest.approx(2 * zoom)


def test_a_key_with_other_modifiers_is_another_key(gui):
    before = state(gui)
    gui.key(K.d, ctrl=True)
    gui.key(K.e, shift=True)
    gui.key(K._1, ctrl=True, shift=True)
    assert state(gui) == before


def test_quit_ends_the_program(gui):
    gui.key(K.q, ctrl=True)
    assert gui.ui.is_over


def test_a_held_key_goes_on_where_that_is_wanted(gui):
    before = 1 / gui.session.facts.lens.focus_distance_m
    gui.hold(K.left_bracket)
    gui.frame(60)
    gui.hold(K.left_bracket, False)
    assert (
        1 / gui.session.facts.lens.focus_distance_m
        > before + 5 * gui.session.facts.histogram.most_dioptres / 250
    )
    gui.hold(K.d)
    gui.frame(60)
    gui.hold(K.d, False)
    assert not gui.session.facts.view.depth_of_field  # once


# Palette and keys


def test_the_palette_does_what_was_typed(gui):
    gui.key(K.p, ctrl=True, shift=True)
    gui.frame(3)
    gui.type("far xyz")
    gui.key(K.enter)  # nothing is called so: it waits for other words
    for _ in range(3):
        gui.key(K.backspace)
    gui.type("near")
    gui.key(K.enter)
    gui.frame(3)
    assert gui.session.facts.view.overlay == "zones"
    assert not imgui.is_popup_open("", imgui.PopupFlags_.any_popup)


@pytest.mark.parametrize(
    ("words", "name"),
    [("wip", "Wipe"), ("plane", "Plane in focus"), ("1:1", "1:1"), ("UNDO", "Undo")],
)
def test_few_letters_find_it(words, name):
    assert next(action for action in ALL if matches(action, words)).name == name


def test_every_action_is_found_by_its_name_in_any_order():
    for action in ALL:
        assert matches(action, " ".join(reversed(action.name.split())))


def test_arrows_choose_in_the_palette_and_escape_does_nothing(gui):
    before = state(gui)
    gui.key(K.p, ctrl=True, shift=True)
    gui.frame(3)
    gui.type("overlay nothing is called so")
    gui.key(K.enter)
    gui.key(K.escape)
    assert state(gui) == before
    gui.key(K.p, ctrl=True, shift=True)
    gui.frame(3)
    gui.type("lens focus")
    found = [action.name for action in ALL if matches(action, "lens focus")]
    assert found[:3] == ["Focus nearer", "Focus farther", "Focus at infinity"]
    for _ in range(2):
        gui.key(K.down_arrow)
    gui.key(K.enter)
    gui.frame(2)
    assert gui.session.facts.lens.focus_distance_m == float("inf")


def test_a_click_in_the_palette_does_it(gui):
    gui.key(K.p, ctrl=True, shift=True)
    gui.frame(3)
    gui.type("feet")
    gui.click(gui.middle("palette Metres or feet"))
    assert gui.session.facts.view.unit == "ft"
    gui.key(K.d)  # closed: keys are keys again
    assert not gui.session.facts.view.depth_of_field


def test_letters_in_the_palette_are_no_shortcuts(gui):
    gui.key(K.p, ctrl=True, shift=True)
    gui.frame(3)
    before = state(gui)
    for key in (K.d, K.w, K.z, K._1, K.left_bracket):
        gui.key(key)
    assert state(gui) == before


def test_a_question_mark_shows_the_keys_and_hides_them(gui):
    gui.key(K.slash, shift=True)
    gui.frame(3)
    assert gui.ui.shows_keys
    assert imgui.internal.find_window_by_name("Keys").active
    gui.key(K.slash, shift=True)
    gui.frame(3)
    assert not gui.ui.shows_keys
    assert not imgui.internal.find_window_by_name("Keys").active


# Opening


def picture(gui) -> np.ndarray:
    return download(gui.session.pictures.live.shown.texture)


def test_another_plate_begins_another_shot(gui, tmp_path):
    gui.click(gui.at_picture(POST[0] + 0.5, POST[1] + 0.5))
    gui.rest()
    gui.do("1:1")
    other = room_file(tmp_path / "other.exr", 80, 50)
    gui.open(other)
    assert gui.session.facts.shot.source == str(other)
    assert gui.session.editing.history.past == ()
    assert gui.session.facts.view.zoom is None
    assert picture(gui).shape[1::-1] == (80, 50)
    gui.key(K.z, ctrl=True)
    assert gui.session.facts.shot.source == str(other)


def damaged(path):
    path.write_bytes(room_file(path).read_bytes()[:900])


@pytest.mark.parametrize(
    "make",
    [
        damaged,
        lambda path: path.write_bytes(b""),
        lambda path: path.write_text("no picture"),
        lambda path: None,
        lambda path: path.mkdir(),
    ],
    ids=["cut off", "empty", "no EXR", "missing", "folder"],
)
def test_what_cannot_be_read_is_said_and_the_last_picture_stays(gui, tmp_path, make):
    gui.settled()
    path = tmp_path / "damaged.exr"
    make(path)
    shot, before = gui.session.facts.shot, picture(gui)
    gui.session.files.commands.open(str(path))
    gui.until(lambda: gui.session.messages.text, "a sentence")
    gui.settled()
    assert path.name in gui.session.messages.text and gui.session.messages.text.endswith(".")
    assert "Traceback" not in gui.session.messages.text
    assert gui.session.facts.shot == shot
    np.testing.assert_array_equal(picture(gui), before)
    gui.click(gui.at_picture(BALL[0] + 0.5, BALL[1] + 0.5))  # and goes on to be worked with
    gui.click(gui.at_picture(POST[0] + 0.5, POST[1] + 0.5))
    assert gui.session.facts.lens != shot.lens


def test_the_palette_finds_settings_too(gui):
    before = gui.session.facts.shot
    gui.key(K.p, ctrl=True, shift=True)
    gui.frame(3)
    gui.type("set film quality")
    gui.key(K.enter)
    gui.frame(3)
    assert str(gui.session.facts.shot.defocus.quality) == "film"
    gui.key(K.z, ctrl=True)
    assert gui.session.facts.shot == before


def test_menus_hold_each_of_their_groups_once_and_together(gui):
    for menu, groups in MENUS.items():
        items = [command.group for command in gui.screen.commands if command.menu == menu]
        assert list(dict.fromkeys(items)) == [group for group, _ in groupby(items)] == list(groups)


def test_every_named_command_stands_in_a_menu(gui):
    named = {action.name for action in gui.screen.commands}
    commands = named_commands(gui.session)
    assert {command.name for command in commands} <= named
    assert len({command.name for command in commands}) == len(commands)
