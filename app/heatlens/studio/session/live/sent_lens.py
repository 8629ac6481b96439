"""Follow the lens that a running renderer sends, except for values that the user has set.

Without a focus from the user or the renderer, it is chosen once the depth is complete: it must not
depend on which part of the picture arrives first.
"""

from collections.abc import Mapping
from dataclasses import replace

from heatlens.core.base.errors import LensError
from heatlens.core.base.messages import Worker
from heatlens.core.model.option import Values, known_values
from heatlens.media.plate.plate import Plate
from heatlens.render.source.stream_source import OpenedStream
from heatlens.studio.session.lens.lens_commands import LensCommands
from heatlens.studio.session.shared import Commands, Shared
from heatlens.studio.settings.start import first_lens

_FOLLOWED_FIELDS = ("focal_length_mm", "f_stop", "focus_distance_m", "sensor_width_mm")


class SentLens(Commands, Worker):
    """Applies changes of the lens of a stream to the shot.

    A value set by the user stays until the renderer changes it; options of the command line always
    win.
    """

    def __init__(self, shared: Shared, lens_commands: LensCommands) -> None:
        super().__init__(shared)
        self._lens_commands = lens_commands
        self._followed_stream: object = None  # the opened stream
        self._plate: Plate | None = None
        self._last_values: dict[str, float] = {}
        self._guessed_m: float | None = None  # a focus that was chosen while depth was missing

    def poll(self) -> None:
        """Apply lens values that the renderer has changed, and focus once its depth is complete."""
        stream, opened, plate = self._source.stream, self._source.opened, self._source.plate
        if stream is None or not stream.is_shown or plate is None or plate is self._plate:
            return
        if not isinstance(opened, OpenedStream):
            return
        sent_values = known_values(plate.camera, _FOLLOWED_FIELDS)
        is_first = self._followed_stream is not opened
        changed_values = {
            name: value
            for name, value in sent_values.items()
            if self._last_values.get(name) != value
        }
        self._followed_stream, self._plate = opened, plate
        self._last_values |= sent_values  # a newly created camera sends no values at first
        command_line_values = self._command_line.lens_of(opened.text)
        if is_first:  # the shot already began with the lens of the first frame
            self._guessed_m = self._start_guess_m()
        else:
            self._apply_changes(changed_values, command_line_values)
        if self._guessed_m is not None and not plate.missing_count:
            self._focus_on_whole_depth(replace(opened, plate=plate))

    def _start_guess_m(self) -> float | None:
        """Return the focus chosen from the depth for the first lens; None if it was given."""
        start_lens = self._lens_commands.start_lens
        is_given = start_lens is None or start_lens.sources["focus_distance_m"].startswith(
            ("given", "header")
        )
        return None if start_lens is None or is_given else start_lens.lens.focus_distance_m

    def _focus_on_whole_depth(self, whole_stream: OpenedStream) -> None:
        """Choose the focus of the whole depth, if neither user nor renderer has changed it."""
        guessed_m, self._guessed_m = self._guessed_m, None
        lens = self._editing.lens
        if lens.focus_distance_m != guessed_m or "focus_distance_m" in self._last_values:
            return
        start, _ = first_lens(whole_stream, self._command_line)
        self._lens_commands.start_lens = start
        if start.lens.focus_distance_m != guessed_m:
            self._editing.edit_lens(replace(lens, focus_distance_m=start.lens.focus_distance_m))

    def _apply_changes(
        self, changed_values: Mapping[str, float], command_line_values: Mapping[str, float]
    ) -> None:
        """Apply changed values to the lens, except those that the command line set."""
        values: Values = {
            name: value for name, value in changed_values.items() if name not in command_line_values
        }
        if not values:
            return
        try:
            self._editing.edit_lens(replace(self._editing.lens, **values))
        except LensError as error:
            self._notify(f"The renderer sent a lens that cannot be used: {error}")
