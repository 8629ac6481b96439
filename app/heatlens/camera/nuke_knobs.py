"""Values of knobs as the text of a Nuke script has them."""

from collections.abc import Sequence

from heatlens.camera.samples import CameraSamples


def knob_value(camera: CameraSamples, values: Sequence[float]) -> str:
    """Return a number, or a list of the one curve that animates the knob."""
    element = curve_or_number(camera, values)
    return f"{{{element}}}" if element.startswith("{") else element


def curve_or_number(camera: CameraSamples, values: Sequence[float]) -> str:
    """Return one value of a knob: a number if it is constant, else a curve with all keys."""
    if min(values) == max(values):
        return repr(values[0])
    keys = (f"x{frame} {value!r}" for frame, value in zip(camera.frames, values, strict=True))
    return f"{{curve {' '.join(keys)}}}"


def quoted(text: str) -> str:
    """Return a text as one word of Tcl, which counts quotes, brackets, $ and backslashes."""
    for sign in '\\"[]{}$':
        text = text.replace(sign, f"\\{sign}")
    return f'"{text}"'
