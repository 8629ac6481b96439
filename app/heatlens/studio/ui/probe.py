"""Report where controls are drawn, by name; nothing is recorded unless `listening` is active.

The Lens panel uses it to draw key dots beside its controls, and tests use it to click on controls.
"""

from collections.abc import Iterator
from contextlib import contextmanager

from imgui_bundle import imgui

Rect = tuple[float, float, float, float]  # x0, y0, x1, y1 in screen units

_listening: list[dict[str, Rect]] = []


@contextmanager
def listening() -> Iterator[dict[str, Rect]]:
    """Collect the rectangle of each control by its name while the block runs."""
    drawn: dict[str, Rect] = {}
    _listening.append(drawn)
    try:
        yield drawn
    finally:
        _listening[:] = [other for other in _listening if other is not drawn]


def note(name: str) -> None:
    """Report the rectangle of the last ImGui item under a name."""
    if _listening:
        low, high = imgui.get_item_rect_min(), imgui.get_item_rect_max()
        note_at(name, (low.x, low.y, high.x, high.y))


def note_at(name: str, rect: Rect) -> None:
    """Report the rectangle of something that is not an ImGui item."""
    for drawn in _listening:
        drawn[name] = rect
