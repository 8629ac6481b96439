"""Where controls are drawn, for whoever asks: nothing is written down unless somebody listens.

The timeline's dots stand before the controls of the lens, and tests aim at controls by their names.
"""

from collections.abc import Iterator
from contextlib import contextmanager

from imgui_bundle import imgui

Rect = tuple[float, float, float, float]  # x0, y0, x1, y1 in screen units

_listening: list[dict[str, Rect]] = []


@contextmanager
def listening() -> Iterator[dict[str, Rect]]:
    """Collect by name where each control was drawn last, for as long as the block runs."""
    drawn: dict[str, Rect] = {}
    _listening.append(drawn)
    try:
        yield drawn
    finally:
        _listening[:] = [other for other in _listening if other is not drawn]


def note(name: str) -> None:
    """Tell whoever listens where the last control lies."""
    if _listening:
        low, high = imgui.get_item_rect_min(), imgui.get_item_rect_max()
        note_at(name, (low.x, low.y, high.x, high.y))


def note_at(name: str, rect: Rect) -> None:
    """Tell whoever listens where something lies that is no control of ImGui's."""
    for drawn in _listening:
        drawn[name] = rect
