"""Write the state of a session as entries of JSON: the protocol of pages and other programs."""

from collections.abc import Sequence
from dataclasses import fields

from heatlens.core.model.shot.look import Look
from heatlens.core.model.value_bins import DepthHistogram
from heatlens.core.model.view.guides import NO_GUIDES, Guides, frame_lines_for, guide_shapes
from heatlens.core.model.view.view_geometry import PictureShape
from heatlens.media.files.json_record import record_to_json, to_json
from heatlens.studio.board.command import Command
from heatlens.studio.board.state import IS_OBJECT, State

_DIGITS = 3  # decimals of the histogram's heights
_PLAIN = tuple(field.name for field in fields(State) if not field.metadata.get(IS_OBJECT))
# An entry without a value is missing, but for these, which are null.
_NULL = ("hyperfocal_m", "keyed_focus_m", "timecode", "part_done")

_OWN = ("looks", "commands", "shape")  # entries that are shorter than their fields


class StateJson:
    """Writes states as JSON; the same state and the same histogram are written once."""

    def __init__(self, remote: Sequence[Command]) -> None:
        """Write of the commands only those in `remote`."""
        self._remote = {command.name for command in remote}
        self._table = [[it.name, it.key, it.sheet] for it in remote]
        self._state: State | None = None
        self._entries: dict[str, object] = {}
        self._histogram: DepthHistogram | None = None
        self._scale: dict[str, object] | None = None

    def entries(self, state: State) -> dict[str, object]:
        """Return the entries of a state; the same object until the state changes."""
        if state is not self._state:
            self._state, self._entries = state, self._entries_of(state)
        return self._entries

    def _entries_of(self, state: State) -> dict[str, object]:
        """Return the entries of a state: plain values, and those of a form of their own."""
        values = {name: getattr(state, name) for name in _PLAIN if name not in _OWN}
        plain = {name: to_json(value) for name, value in values.items() if value is not None}
        shape = state.shape
        own: dict[str, object] = {
            "looks": [_look_entry(look) for look in state.looks],
            "commands": {
                it.name: [it.is_on, it.barred]  # None: it is no switch; "": it is there
                for it in state.commands
                if it.name in self._remote
            },
            "shape": [shape.width_px, shape.height_px, shape.pixel_aspect],
            "table": self._table,
            "guides": _guides_entry(state.view.guides, shape),
            "scale": self._depth_scale(state.histogram),
        }
        return dict.fromkeys(_NULL) | plain | own

    def _depth_scale(self, histogram: DepthHistogram | None) -> dict[str, object] | None:
        """Return the depth histogram of the picture; the same object until the depths change."""
        if histogram is not self._histogram:
            self._histogram = histogram
            self._scale = None if histogram is None else _histogram_entry(histogram)
        return self._scale


def _look_entry(look: Look) -> list[object]:
    """Return name, f-stop, focal length, focus distance and thumbnail of a look."""
    lens = look.lens
    return [
        look.name,
        lens.f_stop,
        lens.focal_length_mm,
        to_json(lens.focus_distance_m),
        look.still,
    ]


def _guides_entry(guides: Guides, shape: PictureShape) -> dict[str, object] | None:
    """Return the shapes of the guides, in units of picture rows; None without guides."""
    if guides == NO_GUIDES:
        return None
    picture = (0.0, 0.0, shape.width_px * shape.pixel_aspect, float(shape.height_px))
    lines = frame_lines_for(guides.canvases, shape.width_px, shape.height_px)
    return record_to_json(guide_shapes(guides, picture, lines)) | {"opacity": guides.opacity}


def _histogram_entry(histogram: DepthHistogram) -> dict[str, object]:
    heights = [round(float(height), _DIGITS) for height in histogram.heights]
    return {"heights": heights, "most_dioptres": histogram.most_dioptres}
