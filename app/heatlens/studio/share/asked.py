"""What a page may ask of a session, which is less than the window may.

Nothing here names a file, opens one, or writes one: that stays in the window.
"""

import json
from collections.abc import Mapping

from heatlens.core.base.errors import InputError
from heatlens.core.model.curves.interpolation import Interpolation
from heatlens.core.model.shot.settings import Method
from heatlens.core.model.view import overlays
from heatlens.core.model.view.guides import MATTES
from heatlens.studio.session.door.named_commands import LOOKS_NAMED

MESSAGE_MOST = 4096  # bytes
_DEPTH_MOST = 8  # nested braces and brackets
# Commands of the shot, the playhead and the view. None of them opens, writes or deletes a file.
_SHARED = frozenset(
    (
        *("Undo", "Redo", "Focus nearer", "Focus farther", "Open 1/3 stop", "Close 1/3 stop"),
        *("Focus at infinity", "Focus on the other surface here", "Reset lens"),
        *("Keep the size of a mark", "Keep this look", "Back to the lens before"),
        *(f"Look {number + 1}" for number in range(LOOKS_NAMED)),
        *("Next quality", "Next bokeh", "Play or stop", "Play backwards", "Next frame"),
        *("Previous frame", "First frame", "Last frame", "Next key", "Previous key"),
        *("Set in point", "Set out point", "Clear in and out", "Set key", "Delete keys"),
        *("Set mark here", "Reverse the pull", "Record a pull", "Hold the focus from here"),
        *("Auto key", "Select all keys", "Copy keys", "Paste keys", "Move keys later"),
        *("Move keys earlier", "Show curve", "Set camera key", "Camera follows the focal length"),
        *("Focal length follows the camera", "Depth of field", "Pixel grid", "Values in pixels"),
        *("Focus peaking", "Loupe", "Grade of the shot", "Fit", "1:1", "Zoom in", "Zoom out"),
        *("Ruler", "Brighter", "Darker", "Reset exposure and gamma", "Metres or feet"),
        *("Safe areas", "Thirds", "Centre cross", "Frame selected", "Wipe", "Flip to B"),
        *("Difference", "Grid of looks", "More gain", "Less gain", "B is the reference"),
        *(f"Interpolate {how} after key" for how in Interpolation),
        *(f"Matte {name}" for name in MATTES),
        *(f"Compare with {method or 'pinhole'}" for method in (None, *Method)),
    )
)
_REQUESTS = ("Go", "Focus", "NudgeFocus", "FocusAt", "MarkAt", "Pull", "TakeLook", "MoveCamera")
_FIELDS: Mapping[str, tuple[str, ...]] = {
    "lens": ("focal_length_mm", "f_stop", "focus_distance_m"),
    "blur": ("quality",),
    "view": ("exposure_stops", "gamma", "depth_of_field", "unit"),
}


def shared() -> frozenset[str]:
    """Return the names of the commands that pages may give."""
    return _SHARED | {overlay.words for overlay in overlays.OVERLAYS}


def parsed(text: str) -> dict[str, object]:
    """Return a message as an object. Raises InputError with a sentence for anything else."""
    try:
        message = json.loads(text, parse_constant=_constant)
    except (ValueError, RecursionError) as error:
        raise InputError("A message should be a JSON object.") from error
    if not isinstance(message, dict) or not _is_shallow(message, _DEPTH_MOST):
        raise InputError("A message should be a JSON object in braces, of few levels.")
    return message


def _constant(name: str) -> object:
    raise ValueError(f"{name} is not JSON")


def _is_shallow(value: object, left: int) -> bool:
    inner = value.values() if isinstance(value, dict) else value if isinstance(value, list) else ()
    return left > 0 and all(_is_shallow(item, left - 1) for item in inner)


def check(message: Mapping[str, object]) -> None:
    """Raise InputError for messages that ask for what is not shared."""
    if "change" in message:
        of = message["change"]
        allowed = _FIELDS.get(of, ()) if isinstance(of, str) else ()
        wrong = [name for name in message if name != "change" and name not in allowed]
        if wrong:
            may = ", ".join(allowed) or f"{', '.join(_FIELDS)} after 'change'"
            raise InputError(f"A page cannot change {wrong[0]!r}; it can change {may}.")
    name = message.get("do")
    if isinstance(name, str) and name not in _REQUESTS and name not in shared():
        raise InputError(
            f"A page has no {name!r}: files are opened and written only in the window."
        )


def turns_lens(message: Mapping[str, object], menus: Mapping[str, str]) -> bool:
    """Return True for a message that changes the shot or the playhead, for one hand at a time."""
    if "change" in message:
        return message["change"] != "view"
    return menus.get(str(message.get("do")), "") not in ("View", "Compare")
