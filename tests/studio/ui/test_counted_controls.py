"""How much a window offers at once: bounds for controls, panels and menu items."""

from collections import Counter
from collections.abc import Iterator
from pathlib import Path

import pytest

from heatlens.media.scene.scene_read import DEMO
from heatlens.render.gpu.device import Device
from heatlens.studio.board.command import MENUS, SUBMENUS
from support.commands import listed_commands
from support.counted_controls import Counted, count_frame, count_menu_items
from support.gui import Gui, gui_of
from support.session_files import QUICK, room_file

LARGE, SMALL = (1600, 900), (800, 600)
PANELS = ["Lens", "Marks", "Looks", "Display", "Export", "Source"]


def test_submenus_hold_three_to_twelve_commands_each():
    counts = Counter((it.menu, it.submenu) for it in listed_commands() if it.submenu)
    assert counts.keys() == {(menu, title) for (menu, _), title in SUBMENUS.items()}
    assert 3 <= min(counts.values()) and max(counts.values()) <= 12


@pytest.fixture(scope="module")
def demo(session_context: Device) -> Iterator[Gui]:
    """Return the demo at a first start."""
    with gui_of(session_context, DEMO, size=LARGE, defocus=QUICK) as gui:
        yield gui


def count_plate(ctx: Device, folder: Path, size: tuple[int, int]) -> Counted:
    with gui_of(ctx, room_file(folder / "room.exr"), size=size, defocus=QUICK) as gui:
        return count_frame(gui)


def names(counted: Counted) -> set[str]:
    return {words.partition("##")[0] or words.strip("#") for _, words in counted.enabled}


def test_demo_has_at_most_45_controls_and_menus_of_at_most_90_items(ctx, demo):
    counted = count_frame(demo)
    assert len(counted.enabled) <= 45 and len(counted.disabled) <= 8
    assert counted.panels == PANELS
    expected = {"distance", "f-stop", "focal length", "focus bar", "Set mark here"}
    expected |= {"Pull focus...", "forwards", "frame", "keys", "Set key", "curve"}
    assert expected <= names(counted)
    assert sum(count_menu_items(demo, tuple(MENUS)).values()) <= 90


def test_plate_has_at_most_26_controls(ctx, tmp_path):
    counted = count_plate(ctx, tmp_path, LARGE)
    assert len(counted.enabled) <= 26 and counted.panels == PANELS
    expected = {"distance", "f-stop", "focal length", "focus bar", "Set mark here"}
    assert expected | {"Pull focus..."} <= names(counted)


def test_small_window_has_at_most_20_controls_and_the_focus_bar(ctx, tmp_path):
    counted = count_plate(ctx, tmp_path, SMALL)
    assert len(counted.enabled) <= 20 and "focus bar" in names(counted)
