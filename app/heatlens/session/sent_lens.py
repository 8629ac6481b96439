"""Follow the lens that a running renderer sends, except for values that the user has set."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

from heatlens.errors import LensError
from heatlens.plate.plate import CameraHeader, Plate
from heatlens.session.editing import Editing
from heatlens.session.open_source import OpenSource
from heatlens.session.start import GivenOptions

_FOLLOWED = ("focal_length_mm", "f_stop", "focus_distance_m", "sensor_width_mm")


class SentLens:
    """Applies changes of the lens of a stream to the shot.

    A value set by the user stays until the renderer changes it; options of the command line always
    win.
    """

    def __init__(
        self,
        source: OpenSource,
        editing: Editing,
        given: GivenOptions,
        say: Callable[[str], None],
    ) -> None:
        self._source = source
        self._editing = editing
        self._given = given
        self._say = say
        self._of: object = None  # the opened stream
        self._plate: Plate | None = None
        self._known: Mapping[str, float] = {}

    def poll(self) -> None:
        """Apply lens values that the renderer has changed; call this once a frame."""
        stream, opened, plate = self._source.stream, self._source.opened, self._source.plate
        if stream is None or opened is None or not stream.is_shown or plate is None:
            return
        if plate is self._plate:
            return
        sent, is_first = _values(plate.camera), self._of is not opened
        changed = {name: v for name, v in sent.items() if self._known.get(name) != v}
        self._of, self._plate = opened, plate
        self._known = {**self._known, **sent}  # a newly created camera sends no values at first
        if not is_first:  # the shot already began with the lens of the first frame
            self._follow(changed, self._given.lens_of(opened.text))

    def _follow(self, changed: Mapping[str, float], given: Mapping[str, float]) -> None:
        values: dict[str, Any] = {name: v for name, v in changed.items() if name not in given}
        if not values:
            return
        try:
            self._editing.edit_lens(replace(self._editing.lens, **values))
        except LensError as error:
            self._say(f"The renderer sent a lens that is not taken over: {error}")


def _values(camera: CameraHeader) -> dict[str, float]:
    found = {name: getattr(camera, name) for name in _FOLLOWED}
    return {name: value for name, value in found.items() if value is not None}
