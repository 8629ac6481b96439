"""Follow the lens that a running renderer sends, except for values that the user has set.

If nobody gave a focus, it is chosen once the depth is complete, so that it does not depend on which
part of the picture arrived first.
"""

from collections.abc import Mapping
from dataclasses import replace

from heatlens.core.base.errors import LensError
from heatlens.core.model.option import Values
from heatlens.media.plate.plate import CameraHeader, Plate
from heatlens.render.source.stream_source import OpenedStream
from heatlens.studio.session.lens.lens_commands import LensCommands
from heatlens.studio.session.messages import Worker
from heatlens.studio.session.shared import Commands, Shared
from heatlens.studio.session.shot.start import first_lens

_FOLLOWED = ("focal_length_mm", "f_stop", "focus_distance_m", "sensor_width_mm")


class SentLens(Commands, Worker):
    """Applies changes of the lens of a stream to the shot.

    A value set by the user stays until the renderer changes it; options of the command line always
    win.
    """

    def __init__(self, shared: Shared, lens_commands: LensCommands) -> None:
        super().__init__(shared)
        self._lens_commands = lens_commands
        self._of: object = None  # the opened stream
        self._plate: Plate | None = None
        self._known: Mapping[str, float] = {}
        self._guessed_m: float | None = None  # a focus that was chosen while depth was missing

    def poll(self) -> None:
        """Apply lens values that the renderer has changed; call this once a frame."""
        stream, opened, plate = self._source.stream, self._source.opened, self._source.plate
        if stream is None or not stream.is_shown or plate is None or plate is self._plate:
            return
        if not isinstance(opened, OpenedStream):
            return
        sent, is_first = _values(plate.camera), self._of is not opened
        changed = {name: v for name, v in sent.items() if self._known.get(name) != v}
        self._of, self._plate = opened, plate
        self._known = {**self._known, **sent}  # a newly created camera sends no values at first
        given = self._given.lens_of(opened.text)
        if is_first:  # the shot already began with the lens of the first frame
            self._guessed_m = self._first_guess_m()
        else:
            self._follow(changed, given)
        if self._guessed_m is not None and not plate.missing_count:
            self._focus_again(replace(opened, plate=plate))

    def _first_guess_m(self) -> float | None:
        """Return the focus chosen from the depth for the first lens; None if it was given."""
        first = self._lens_commands.start_lens
        is_told = first is None or first.sources["focus_distance_m"].startswith(("given", "header"))
        return None if first is None or is_told else first.lens.focus_distance_m

    def _focus_again(self, whole: OpenedStream) -> None:
        """Choose the focus of the whole depth, if neither user nor renderer has changed it."""
        guessed_m, self._guessed_m = self._guessed_m, None
        lens = self._editing.lens
        if lens.focus_distance_m != guessed_m or "focus_distance_m" in self._known:
            return
        start, _ = first_lens(whole, self._given)
        self._lens_commands.start_lens = start
        if start.lens.focus_distance_m != guessed_m:
            self._editing.edit_lens(replace(lens, focus_distance_m=start.lens.focus_distance_m))

    def _follow(self, changed: Mapping[str, float], given: Mapping[str, float]) -> None:
        values: Values = {name: v for name, v in changed.items() if name not in given}
        if not values:
            return
        try:
            self._editing.edit_lens(replace(self._editing.lens, **values))
        except LensError as error:
            self._say(f"The renderer sent a lens that cannot be used: {error}")


def _values(camera: CameraHeader) -> dict[str, float]:
    values = {name: getattr(camera, name) for name in _FOLLOWED}
    return {name: value for name, value in values.items() if value is not None}
