"""Read the first game pad or jog wheel that GLFW finds."""

import glfw


def pad_axes() -> dict[str, float] | None:
    """Return the positions of the axes of the first pad, -1 to 1; None if none is connected."""
    for pad in range(glfw.JOYSTICK_1, glfw.JOYSTICK_LAST + 1):
        if glfw.joystick_present(pad):
            values, count = glfw.get_joystick_axes(pad)
            return {f"axis {at + 1}": float(values[at]) for at in range(count)}
    return None
