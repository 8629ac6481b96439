"""The shape of a key."""

from imgui_bundle import ImVec2


def diamond(middle: ImVec2, reach: float) -> tuple[ImVec2, ImVec2, ImVec2, ImVec2]:
    """Its corners, `reach` from the middle."""
    x, y = middle.x, middle.y
    return (
        ImVec2(x, y - reach),
        ImVec2(x + reach, y),
        ImVec2(x, y + reach),
        ImVec2(x - reach, y),
    )
