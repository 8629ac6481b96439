"""How much a window offers at once: bounds for controls, panels and menu items."""

from collections import Counter

from heatlens.studio.board.command import MENUS, SUBMENUS
from support.commands import listed_commands
from support.counted_controls import count_menu_items


def test_menus_draw_at_most_90_items(gui):
    counts = count_menu_items(gui, tuple(MENUS))
    assert all(counts.values()) and sum(counts.values()) <= 90


def test_submenus_hold_three_to_twelve_commands_each():
    counts = Counter((it.menu, it.submenu) for it in listed_commands() if it.submenu)
    assert counts.keys() == {(menu, title) for (menu, _), title in SUBMENUS.items()}
    assert 3 <= min(counts.values()) and max(counts.values()) <= 12
