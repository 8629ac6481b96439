"""Report the rectangles of controls by name; nothing is recorded unless `listening` is active.

The Lens panel uses it to draw key dots beside its controls, and tests use it to click on controls.
"""

from collections.abc import Iterator
from contextlib import contextmanager

from imgui_bundle import imgui

Rect = tuple[float, float, float, float]  # x0, y0, x1, y1 in screen units

_listeners: list[dict[str, Rect]] = []


@contextmanager
def listening() -> Iterator[dict[str, Rect]]:
    """Collect the rectangle of each control by its name while the block runs."""
    rects: dict[str, Rect] = {}
    _listeners.append(rects)
    try:
        yield rects
    finally:
        _listeners[:] = [listener for listener in _listeners if listener is not rects]


def note(name: str) -> None:
    """Report the rectangle of the last ImGui item under a name."""
    if _listeners:
        corner, end = imgui.get_item_rect_min(), imgui.get_item_rect_max()
        note_at(name, (corner.x, corner.y, end.x, end.y))


def note_at(name: str, rect: Rect) -> None:
    """Report the rectangle of something that is not an ImGui item."""
    for rects in _listeners:
        rects[name] = rect
