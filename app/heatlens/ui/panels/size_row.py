"""Draw the choice of what a change of the focal length keeps."""

from heatlens.session.scenes.size_keeping import SizeKeeping
from heatlens.ui import widgets

_ZOOMS = "the picture zooms"
_FRAMING_TIP = (
    "What a change of the focal length keeps. With the size of a mark, the camera of a scene moves "
    "along its axis until what is there is as large as before: focus, keys and marks follow. "
    "Ctrl and the wheel move the camera, and the focal length follows."
)


def size_row(size: SizeKeeping) -> None:
    """Draw the choice of the mark whose thing keeps its size while the focal length changes."""
    words: dict[str | None, str] = {None: _ZOOMS} | {it: f"same size of {it}" for it in size.names}
    chosen = widgets.pick("framing", size.chosen, words, _FRAMING_TIP)
    if chosen != size.chosen:
        size.chosen = chosen
