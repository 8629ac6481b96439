"""Each named command of the board does what its name says, and each switch tells its state."""

from dataclasses import replace

import pytest

from heatlens.core.base.errors import InputError
from heatlens.core.model.curves.interpolation import Interpolation
from heatlens.core.model.shot.grade import Grade
from heatlens.core.model.shot.settings import Bokeh, Method, Quality
from heatlens.core.model.view.view import Against, Compare
from heatlens.studio.board import window_handover
from heatlens.studio.board.board import Board
from heatlens.studio.board.command import Command
from heatlens.studio.board.commands import named_commands
from heatlens.studio.session.live import pull_recording
from support.evening import FIRST, LAST, run_until_settled

START_FRAME = FIRST + 10


def focus_of(session):
    return session.facts.lens.focus_distance_m


def f_stop_of(session):
    return round(session.facts.lens.f_stop, 3)


def focus_key_frames(session):
    return [key.frame for key in session.editing.shot.curves.focus_distance_m.keys]


# Name of a command: a function that reads a value of the session, its value before and after.
EXPECTED_CHANGES = {
    "Start screen": (lambda s: s.files.start_choices.is_shown, False, True),
    "Open 1/3 stop": (f_stop_of, 2.8, 2.5),
    "Close 1/3 stop": (f_stop_of, 2.8, 3.2),
    "Focus at infinity": (focus_of, 4.0, float("inf")),
    "Next quality": (lambda s: s.editing.shot.defocus.quality, None, Quality.DRAFT),
    "Next bokeh": (lambda s: s.editing.shot.defocus.bokeh, Bokeh.DISC, Bokeh.HEAT),
    "Keep this look": (lambda s: len(s.editing.shot.looks), 0, 1),
    "Play or stop": (lambda s: s.time.timeline.playback.direction, 0, 1),
    "Play backwards": (lambda s: s.time.timeline.playback.direction, 0, -1),
    "Next frame": (lambda s: s.editing.frame, START_FRAME, START_FRAME + 1),
    "Previous frame": (lambda s: s.editing.frame, START_FRAME, START_FRAME - 1),
    "First frame": (lambda s: s.editing.frame, START_FRAME, FIRST),
    "Last frame": (lambda s: s.editing.frame, START_FRAME, LAST),
    "Set in point": (lambda s: s.time.timeline.played.first, FIRST, START_FRAME),
    "Set out point": (lambda s: s.time.timeline.played.last, LAST, START_FRAME),
    "Set key": (focus_key_frames, [], [START_FRAME]),
    "Hold the focus from here": (focus_key_frames, [], [START_FRAME]),
    "Set mark here": (lambda s: len(s.editing.shot.marks), 0, 1),
    "Fit": (lambda s: s.facts.view.zoom, None, None),
    "1:1": (lambda s: s.facts.view.zoom, None, 1.0),
    "Brighter": (lambda s: s.facts.view.exposure_stops, 0.0, 0.25),
    "Darker": (lambda s: s.facts.view.exposure_stops, 0.0, -0.25),
    "Metres or feet": (lambda s: s.facts.view.unit, "m", "ft"),
    "More gain": (lambda s: s.facts.view.difference_gain, 4.0, 8.0),
    "Less gain": (lambda s: s.facts.view.difference_gain, 4.0, 2.0),
    "Compare with pinhole": (
        *(lambda s: (s.facts.view.compare, s.facts.view.against), (Compare.OFF, Against.PINHOLE)),
        (Compare.WIPE, Against.PINHOLE),
    ),
    "Compare with gather": (
        *(lambda s: (s.facts.view.against, s.facts.view.b_method is Method.GATHER),),
        *((Against.PINHOLE, True), (Against.METHOD, True)),
    ),
}


@pytest.fixture
def session(session):
    session.time.timeline.go_to(START_FRAME)
    return session


@pytest.fixture
def commands(session):
    return {command.name: command for command in named_commands(session)}


def test_named_commands_have_unique_names_and_known_menus(session, commands):
    all_commands = named_commands(session)
    assert len(all_commands) == len(commands) and EXPECTED_CHANGES.keys() < commands.keys()
    menus = {"File", "Edit", "Lens", "Play", "Animate", "View", "Compare"}
    assert {command.menu for command in all_commands} == menus
    assert {f"Interpolate {how} after key" for how in Interpolation} < commands.keys()
    assert {f"Look {number}" for number in range(1, 10)} < commands.keys()


@pytest.mark.parametrize("name", EXPECTED_CHANGES)
def test_named_command_changes_the_value_it_names(session, commands, name):
    read_value, before, after = EXPECTED_CHANGES[name]
    if name == "Next bokeh":
        kinds = list(type(read_value(session)))
        before = read_value(session)
        after = kinds[(kinds.index(before) + 1) % len(kinds)]
    assert read_value(session) == before
    commands[name].do()
    assert read_value(session) == after


def test_focus_nearer_farther_and_reset_lens_commands_move_focus(session, commands):
    commands["Focus nearer"].run()
    assert focus_of(session) < 4.0
    commands["Focus farther"].run()
    commands["Focus farther"].run()
    assert focus_of(session) > 4.0
    commands["Reset lens"].run()
    assert focus_of(session) == 4.0


def test_every_switch_command_turns_on_and_off(session, commands):
    session.editing.do(replace(session.editing.shot, grade=Grade()))
    switches = [command for command in commands.values() if command.is_on is not None]
    assert len(switches) > 20
    for command in switches:
        if command.name in ("Grid of looks", "Compare with the reference"):
            continue  # there are neither looks nor a reference
        before = command.is_on()
        for state in (not before, before):
            command.do()
            assert command.is_on() is state, command.name


def test_overlay_commands_exclude_each_other(session, commands):
    for name in ("Depth", "Layers", "Circle of confusion", "Plane in focus", "Near, in focus, far"):
        commands[name].run()
        assert (
            commands[name].is_on()
            and not commands["Depth" if name != "Depth" else "Layers"].is_on()
        )
    assert session.facts.view.overlay == "zones"


def test_undo_command_names_its_step_and_is_barred_without_one(session, commands):
    run_until_settled(session)
    undo, redo = commands["Undo"], commands["Redo"]
    assert undo.shown == "Undo" and "nothing to undo" in undo.why_not()
    Board(session).do(undo)
    assert session.messages.text == undo.why_not()
    with pytest.raises(InputError, match="nothing to undo"):
        undo.do()
    session.lens.commands.focus(3.0)
    session.editing.settle()
    assert undo.shown.startswith("Undo ") and undo.why_not() == ""
    undo.do()
    assert focus_of(session) == 4.0 and redo.why_not() == "" and redo.shown.startswith("Redo ")


def test_key_commands_copy_paste_move_and_delete_keys(session, commands):
    commands["Set key"].run()
    commands["Select all keys"].run()
    commands["Copy keys"].run()
    session.time.timeline.go_to(START_FRAME + 3)
    commands["Paste keys"].run()
    assert focus_key_frames(session) == [START_FRAME, START_FRAME + 3]
    commands["Move keys later"].run()
    assert focus_key_frames(session) == [START_FRAME, START_FRAME + 4]
    commands["Move keys earlier"].run()
    session.time.timeline.go_to(FIRST)
    commands["Next key"].run()
    assert session.editing.frame == START_FRAME
    commands["Next key"].run()
    commands["Previous key"].run()
    assert session.editing.frame == START_FRAME
    commands["Select all keys"].run()
    commands["Delete keys"].run()
    assert focus_key_frames(session) == []


def test_scene_commands_are_barred_while_a_plate_is_open(session, commands):
    follow = "Camera follows the focal length", "Focal length follows the camera"
    for name in ("Set camera key", "Frame the object", *follow):
        assert "Only a scene" in commands[name].why_not()
    for method in Method:
        why = commands[f"Compare with {method}"].why_not()
        assert bool(why) is method.needs_scene


def test_command_without_a_bar_can_always_run():
    done = []
    plain = Command("A", lambda: done.append(1))
    plain.do()
    assert done == [1] and plain.why_not() == "" and plain.shown == "A"


def test_documented_limits_of_board_and_pull_recording():
    assert (window_handover._CLIENTS_MOST, window_handover._NAMES_MOST) == (64, 1000)
    assert window_handover._REQUEST_MOST == 1 << 20
    assert window_handover.handover_path().stem.startswith("window-")
    assert len(window_handover.handover_path().stem) == len("window-") + 16
    assert (pull_recording.TOLERANCE_LEAST, pull_recording.TOLERANCE_MOST) == (1e-4, 1.0)


def test_choosing_no_kit_frees_the_lens_and_shows_a_message(session):
    kits = session.lens.commands.kits
    kits.choose(next(iter(kits.shelf.kits)))
    mounted = session.messages.text
    assert session.editing.shot.kit is not None and mounted
    kits.choose(None)
    assert session.editing.shot.kit is None and session.messages.text not in ("", mounted)


def test_set_key_turns_tried_focus_into_one_key(session):
    session.time.keys.set_here()
    session.editing.toggle_auto_key()
    session.time.timeline.go_to(START_FRAME + 5)
    session.lens.commands.focus(3.0)
    assert session.editing.trial_parameters and focus_key_frames(session) == [START_FRAME]
    session.time.keys.set_here()
    assert (
        focus_key_frames(session) == [START_FRAME, START_FRAME + 5]
        and not session.editing.trial_parameters
    )
    assert session.editing.shot.lens_at(START_FRAME + 5).focus_distance_m == 3.0


def test_undo_and_redo_drop_a_tried_focus(session):
    session.time.keys.set_here()
    session.time.keys.set_here()
    session.lens.commands.step_f_stop(1)
    session.editing.settle()
    session.editing.toggle_auto_key()
    for step in (session.editing.undo, session.editing.redo):
        session.time.timeline.go_to(START_FRAME + 5)
        session.lens.commands.focus(3.0)
        assert session.editing.trial_parameters and focus_of(session) == 3.0
        step()
        assert not session.editing.trial_parameters and focus_of(session) == 4.0
