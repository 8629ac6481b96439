"""Time for a picture while something is dragged, beside drawing the window."""

_GPU_S = 0.012  # keeps up with the screen
# A software rasteriser draws the window with the same processor: above twelve pictures a second,
# also where one takes somewhat longer than was expected.
_FRAME_SOFTWARE_S, _LEAST_S = 0.068, 0.012


def budget_s(is_software: bool, window_s: float) -> float:
    """Seconds for a picture, where drawing the window without it takes `window_s`."""
    return max(_LEAST_S, _FRAME_SOFTWARE_S - window_s) if is_software else _GPU_S
