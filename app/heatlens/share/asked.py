"""What a page may ask of a session, which is less than the window may.

Nothing here names a file, opens one, or writes one: that stays in the window.
"""

import json
from collections.abc import Mapping

from heatlens.base.errors import InputError

MESSAGE_MOST = 4096  # bytes
_DEPTH_MOST = 8  # nested braces and brackets
_MENUS = ("Edit", "Lens", "Play", "Animate", "View", "Compare")
_NOT_SHARED = (
    "Render frames ahead",
    "Clear rendered frames",
)  # commands that change the kept frames on disk
_REQUESTS = ("Go", "Focus", "NudgeFocus", "FocusAt", "MarkAt", "Pull", "TakeLook", "MoveCamera")
_FIELDS: Mapping[str, tuple[str, ...]] = {
    "lens": ("focal_length_mm", "f_stop", "focus_distance_m"),
    "blur": ("quality",),
    "view": ("exposure_stops", "gamma", "depth_of_field", "unit"),
}


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


def is_command(name: str, menu: str) -> bool:
    """Return True for a named command that a page may do."""
    return menu in _MENUS and name not in _NOT_SHARED


def check(message: Mapping[str, object], menus: Mapping[str, str]) -> None:
    """Raise InputError for forbidden messages; `menus` has the menu of each named command."""
    if "change" in message:
        of = message["change"]
        allowed = _FIELDS.get(of, ()) if isinstance(of, str) else ()
        wrong = [name for name in message if name != "change" and name not in allowed]
        if wrong:
            may = ", ".join(allowed) or f"{', '.join(_FIELDS)} after 'change'"
            raise InputError(f"A page cannot change {wrong[0]!r}; it can change {may}.")
    name = message.get("do")
    if (
        isinstance(name, str)
        and name not in _REQUESTS
        and not is_command(name, menus.get(name, ""))
    ):
        raise InputError(
            f"A page has no {name!r}: files are opened and written only in the window."
        )


def turns_lens(message: Mapping[str, object], menus: Mapping[str, str]) -> bool:
    """Return True for a message that changes the shot or the playhead, for one hand at a time."""
    if "change" in message:
        return message["change"] != "view"
    return menus.get(str(message.get("do")), "") not in ("View", "Compare")
