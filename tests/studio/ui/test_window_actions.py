"""Every action by menu and by key; the palette, the keys window, and opening files."""

import webbrowser
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
ALL_ACTIONS = listed_commands()
ACTIONS_WITH_KEYS = [action for action in ALL_ACTIONS if action.key]


def ids(action: Command) -> str:
    return action.name


def bound_action(gui, action: Command) -> Command:
    """Return the action of the same name that is bound to this window."""
    return next(other for other in gui.screen.commands if other.name == action.name)


def choose_in_menu(gui, action: Command) -> None:
    """Choose the action in its menu with the mouse."""
    gui.choose_in_menu(action)


def run_action(gui, action: Command) -> None:
    """Run the action directly, without mouse or keys."""
    gui.do(action.name)


def press_shortcut(gui, action: Command) -> None:
    key, mods = chord_of(action.key)
    gui.key(key, ctrl=bool(mods & CTRL), shift=bool(mods & SHIFT))


def close_opened(gui) -> None:
    """Close the dialog or popup that an action opened, as a user would."""
    if gui.ui.dialogs.is_open:
        gui.frame(3)
        gui.key(K.escape)
        gui.frame(2)
        assert not gui.ui.dialogs.is_open
    gui.key(K.escape)
    gui.ui.is_over = False


def visible_state(gui) -> tuple:
    """Return everything that an action can change visibly at once."""
    session = gui.session
    ui = gui.ui
    others = (ui.shows_keys, ui.is_over, ui.dialogs.is_open, session.source.picture.version)
    return session.facts.shot, session.facts.view, dict(ui.panels), *others


@pytest.mark.parametrize("by", [choose_in_menu, press_shortcut], ids=["menu", "key"])
def test_every_action_runs_twice_by_menu_and_by_key(gui, small_demo, by):
    """No exception is raised, OpenGL reports no error, and the whole picture is shown at last."""
    gui.session.pictures.references.open(gui.session.source.plate.path)
    gui.until(lambda: gui.session.facts.reference is not None, "the reference")
    for action in ALL_ACTIONS if by is choose_in_menu else ACTIONS_WITH_KEYS:
        if action.name in ("Picture alone", "Full screen", "Grid of looks", "Ruler"):
            continue  # Escape leaves them: test_picture_alone, test_look_grid, test_ruler
        if action.name == "Grade of the shot":  # which no shot has that was opened before
            gui.session.editing.begin(replace(gui.session.facts.shot, grade=Grade()))
        for run_step in (by, by if by is press_shortcut else run_action):
            is_on = bound_action(gui, action).is_on
            was_on = is_on is not None and is_on()
            run_step(gui, action)
            gui.until(lambda: not gui.session.source.opener.opening, "the plate")
            close_opened(gui)
            assert is_on is None or is_on() is not was_on, action.name
    gui.settled()
    assert gui.session.pictures.live.output.shot == gui.session.facts.shot


def test_actions_have_unique_names_and_keys():
    assert len({action.name for action in ALL_ACTIONS}) == len(ALL_ACTIONS)
    assert len({chord_of(action.key) for action in ACTIONS_WITH_KEYS}) == len(ACTIONS_WITH_KEYS)
    assert len({action.key for action in ACTIONS_WITH_KEYS}) == len(ACTIONS_WITH_KEYS)


@pytest.mark.parametrize(
    ("name", "shortcut"),
    [
        *(("Undo", "Ctrl+Z"), ("Redo", "Ctrl+Shift+Z"), ("Keys", "F1"), ("1:1", "1")),
        *(("Zoom in", "+"), ("Save shot", "Ctrl+S"), ("Save picture...", "Ctrl+Shift+E")),
    ],
)
def test_action_shortcut_is_written_readably(name, shortcut):
    assert next(action for action in ALL_ACTIONS if action.name == name).key == shortcut


@pytest.mark.parametrize("action", [a for a in ACTIONS_WITH_KEYS if a.is_on is not None], ids=ids)
def test_shortcut_of_a_switch_toggles_it(gui, action):
    gui.session.pictures.references.open(gui.session.source.plate.path)
    gui.until(lambda: gui.session.facts.reference is not None, "the reference")
    gui.session.pictures.looks.keep()  # without a look there is no grid
    is_on = bound_action(gui, action).is_on
    was_on = is_on()
    press_shortcut(gui, action)
    assert is_on() is not was_on
    press_shortcut(gui, action)
    assert is_on() is was_on


def test_shift_equal_zooms_in_like_plus(gui):
    zoom = gui.session.pictures.view.zoom
    gui.key(K.equal, shift=True)
    gui.frame()
    assert gui.session.pictures.view.zoom == pytest.approx(2 * zoom)


def test_shortcut_with_other_modifiers_does_nothing(gui):
    before = visible_state(gui)
    gui.key(K.d, ctrl=True)
    gui.key(K.e, shift=True)
    gui.key(K._1, ctrl=True, shift=True)
    assert visible_state(gui) == before


def test_ctrl_q_ends_the_program(gui):
    gui.key(K.q, ctrl=True)
    assert gui.ui.is_over


def test_held_key_repeats_for_focus_but_not_for_switches(gui):
    before = 1 / gui.session.facts.lens.focus_distance_m
    gui.hold(K.left_bracket)
    gui.frame(60)
    gui.hold(K.left_bracket, down=False)
    assert (
        1 / gui.session.facts.lens.focus_distance_m
        > before + 5 * gui.session.facts.histogram.most_dioptres / 250
    )
    gui.hold(K.d)
    gui.frame(60)
    gui.hold(K.d, down=False)
    assert not gui.session.facts.view.depth_of_field  # once


# Palette and keys


def test_palette_runs_the_typed_action(gui):
    gui.key(K.p, ctrl=True, shift=True)
    gui.frame(3)
    gui.type("far xyz")
    gui.key(K.enter)  # no action has these words: the palette waits for others
    for _ in "xyz":
        gui.key(K.backspace)
    gui.type("near")  # "far near" finds the action "Near, in focus, far", which shows three zones
    gui.key(K.enter)
    gui.frame(3)
    assert gui.session.facts.view.overlay == "zones"
    assert not imgui.is_popup_open("", imgui.PopupFlags_.any_popup)


@pytest.mark.parametrize(
    ("words", "name"),
    [
        *(("wip", "Wipe"), ("plane in", "Plane in focus"), ("1:1", "1:1"), ("UNDO", "Undo")),
        *(("dof", "Depth of field"), ("picture behind", "Add clean plate...")),
    ],
)
def test_matches_finds_a_command_by_few_letters_or_a_synonym(words, name):
    assert next(action for action in ALL_ACTIONS if matches(action, words)).name == name


def test_matches_finds_every_action_by_its_words_in_any_order():
    for action in ALL_ACTIONS:
        assert matches(action, " ".join(reversed(action.name.split())))


def test_palette_arrow_keys_choose_and_escape_does_nothing(gui):
    before = visible_state(gui)
    gui.key(K.p, ctrl=True, shift=True)
    gui.frame(3)
    gui.type("overlay nothing is called so")
    gui.key(K.enter)
    gui.key(K.escape)
    assert visible_state(gui) == before
    gui.key(K.p, ctrl=True, shift=True)
    gui.frame(3)
    gui.type("lens focus")
    action_names = [action.name for action in ALL_ACTIONS if matches(action, "lens focus")]
    assert action_names[:3] == ["Focus nearer", "Focus farther", "Focus at infinity"]
    for _ in range(2):
        gui.key(K.down_arrow)
    gui.key(K.enter)
    gui.frame(2)
    assert gui.session.facts.lens.focus_distance_m == float("inf")


def test_click_in_the_palette_runs_the_action(gui):
    gui.key(K.p, ctrl=True, shift=True)
    gui.frame(3)
    gui.type("feet")
    gui.click(gui.middle("palette Metres or feet"))
    assert gui.session.facts.view.unit == "ft"
    gui.key(K.d)  # closed: keys are keys again
    assert not gui.session.facts.view.depth_of_field


def test_question_mark_opens_the_palette_that_searches_the_manual(gui, monkeypatch):
    opened = []
    monkeypatch.setattr(webbrowser, "open", opened.append)
    gui.key(K.slash, shift=True)
    gui.frame(3)
    gui.type("hyperfocal")
    gui.click(gui.middle("page The window"))
    assert [name.rpartition("/")[2] for name in opened] == ["window.md"]
    gui.key(K.escape)
    gui.frame(2)
    assert not imgui.is_popup_open("", imgui.PopupFlags_.any_popup)


def test_letters_typed_in_the_palette_run_no_shortcuts(gui):
    gui.key(K.p, ctrl=True, shift=True)
    gui.frame(3)
    before = visible_state(gui)
    for key in (K.d, K.w, K.z, K._1, K.left_bracket):
        gui.key(key)
    assert visible_state(gui) == before


def test_f1_toggles_the_keys_window(gui):
    gui.key(K.f1)
    gui.frame(3)
    assert gui.ui.shows_keys
    assert imgui.internal.find_window_by_name("Keys").active
    gui.key(K.f1)
    gui.frame(3)
    assert not gui.ui.shows_keys
    assert not imgui.internal.find_window_by_name("Keys").active


# Opening


def shown_pixels(gui) -> np.ndarray:
    return download(gui.session.pictures.live.output.texture)


def test_opening_another_plate_begins_another_shot(gui, tmp_path):
    gui.click(gui.at_picture(POST[0] + 0.5, POST[1] + 0.5))
    gui.rest()
    gui.do("1:1")
    other = room_file(tmp_path / "other.exr", 80, 50)
    gui.open(other)
    assert gui.session.facts.shot.source == str(other)
    assert gui.session.editing.history.past == ()
    assert gui.session.facts.view.zoom is None
    assert shown_pixels(gui).shape[1::-1] == (80, 50)
    gui.key(K.z, ctrl=True)
    assert gui.session.facts.shot.source == str(other)


def write_damaged(path):
    path.write_bytes(room_file(path).read_bytes()[:900])


@pytest.mark.parametrize(
    "make",
    [
        write_damaged,
        lambda path: path.write_bytes(b""),
        lambda path: path.write_text("no picture"),
        lambda path: None,
        lambda path: path.mkdir(),
    ],
    ids=["cut off", "empty", "no EXR", "missing", "folder"],
)
def test_unreadable_file_is_reported_and_the_last_picture_stays(gui, tmp_path, make):
    gui.settled()
    path = tmp_path / "damaged.exr"
    make(path)
    shot, before = gui.session.facts.shot, shown_pixels(gui)
    gui.session.files.commands.open(str(path))
    gui.until(lambda: gui.session.messages.text, "a sentence")
    gui.settled()
    assert path.name in gui.session.messages.text and gui.session.messages.text.endswith(".")
    assert "Traceback" not in gui.session.messages.text
    assert gui.session.facts.shot == shot
    np.testing.assert_array_equal(shown_pixels(gui), before)
    gui.click(gui.at_picture(BALL[0] + 0.5, BALL[1] + 0.5))  # and goes on to be worked with
    gui.click(gui.at_picture(POST[0] + 0.5, POST[1] + 0.5))
    assert gui.session.facts.lens != shot.lens


def test_palette_sets_a_typed_setting(gui):
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


def test_every_named_command_has_a_menu_action(gui):
    action_names = {action.name for action in gui.screen.commands}
    commands = named_commands(gui.session)
    assert {command.name for command in commands} <= action_names
    assert len({command.name for command in commands}) == len(commands)
