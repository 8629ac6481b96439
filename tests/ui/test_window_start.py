"""How a window begins: the lens that the command line gives."""

from dataclasses import replace

from support.gui import gui_of
from support.session_files import LENS, QUICK, room_file


def test_a_lens_from_the_command_line_that_cannot_be_is_said_and_the_plates_own_is_taken(
    ctx, tmp_path
):
    given = {"focus_distance_m": 0.02, "f_stop": 4.0}
    with gui_of(ctx, room_file(tmp_path / "room.exr"), lens=given, defocus=QUICK) as gui:
        assert "focus distance must be beyond the focal length" in gui.session.messages.text
        assert gui.session.facts.lens == LENS
        assert gui.session.facts.shot.source == str(tmp_path / "room.exr")


def test_a_lens_from_the_command_line_is_that_of_its_plate_alone(ctx, tmp_path):
    first, second = (room_file(tmp_path / name) for name in ("first.exr", "second.exr"))
    with gui_of(ctx, first, lens={"f_stop": 4.0}, defocus=QUICK) as gui:
        assert gui.session.facts.lens == replace(LENS, f_stop=4.0)
        gui.open(second)
        assert gui.session.facts.lens == LENS
