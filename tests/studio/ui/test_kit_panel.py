"""The lens kit in the Lens panel: chosen with the mouse, and what it does to the sliders."""

import pytest

from support.gui import gui_of
from support.session_files import QUICK, room_file


@pytest.fixture(scope="module")
def gui(session_context, tmp_path_factory):
    plate = room_file(tmp_path_factory.mktemp("kits") / "room.exr")
    with gui_of(session_context, plate, size=(1280, 1400), defocus=QUICK) as new_gui:
        new_gui.opened()
        yield new_gui


def pick_item(gui, name: str, item: str) -> None:
    gui.click(gui.middle(name))
    gui.frame(2)
    gui.click(gui.middle(f"{name}: {item}"))
    gui.frame(2)


def test_chosen_kit_and_its_lens_limit_the_lens_sliders(gui):
    pick_item(gui, "kit", "modern-primes")
    assert gui.session.facts.shot.kit.name == "modern-primes"
    assert gui.session.facts.lens.focal_length_mm == 85.0
    assert gui.session.facts.lens.f_stop == 1.7  # the plate had f/1
    pick_item(gui, "lens", "50 mm")
    assert gui.session.facts.lens.focal_length_mm == 50.0
    gui.click(gui.middle("breathing"))
    assert gui.session.facts.lens.breathing == 0.975
    gui.settled()  # the picture is there, cut
    gui.click(gui.middle("breathing"))
    assert gui.session.facts.lens.breathing == 1.0
    x0, y0, _, y1 = gui.rect("f-stop")
    gui.click((x0 + 2, (y0 + y1) / 2))  # as far open as the slider goes
    assert 1.7 <= gui.session.facts.lens.f_stop <= 1.8
    before = gui.session.facts.lens.focal_length_mm
    x, y = gui.middle("focal length")
    gui.press((x, y))
    gui.move((x + 60, y))
    gui.release()
    assert gui.session.facts.lens.focal_length_mm == before  # a prime has no other length
