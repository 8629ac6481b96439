"""Write the facts of a session as entries of JSON: the protocol of pages and other programs."""

import re
from collections.abc import Sequence

from heatlens.core.model.shot.look import Look
from heatlens.core.model.value_bins import DepthHistogram
from heatlens.core.model.view.guides import NO_GUIDES, Guides, frame_lines_for, guide_shapes
from heatlens.core.model.view.view_geometry import PictureShape
from heatlens.media.files.json_record import record_to_json, to_json
from heatlens.studio.board.command import Command, CommandState
from heatlens.studio.board.facts import Facts

_DIGITS = 3  # decimals of the histogram's heights
# The facts that are entries by their own names. One without a value is missing, but for `_NULL`.
_PLAIN = (
    *("opening", "title", "message", "is_problem", "frame", "direction", "near_m", "far_m"),
    *(
        "lens_number",
        "view",
        "marks",
        "size_px",
        "is_whole",
        "picture",
        "hyperfocal_m",
        "keyed_focus_m",
    ),
    *("timecode", "beats_left", "recorded_keys", "has_camera", "part_done"),
)
_NAMES_A_KEY = re.compile(r"\b(Ctrl|Shift)\+")
_NULL = ("hyperfocal_m", "keyed_focus_m", "timecode", "part_done")  # null without a value


class StateJson:
    """Writes facts as JSON; the same facts and the same histogram are written once."""

    def __init__(self, remote: Sequence[Command]) -> None:
        """Write of the commands only those in `remote`."""
        self._remote = {command.name for command in remote}
        self._table = [[it.name, it.key, it.sheet] for it in remote]
        self._written: tuple[Facts, tuple[CommandState, ...]] | None = None
        self._entries: dict[str, object] = {}
        self._histogram: DepthHistogram | None = None
        self._scale: dict[str, object] | None = None

    def entries(self, facts: Facts, commands: tuple[CommandState, ...]) -> dict[str, object]:
        """Return the entries of the facts; the same object until they change."""
        if self._written != (facts, commands):
            self._written, self._entries = (facts, commands), self._entries_of(facts, commands)
        return self._entries

    def _entries_of(self, facts: Facts, commands: tuple[CommandState, ...]) -> dict[str, object]:
        values = {name: getattr(facts, name) for name in _PLAIN}
        values["message"] = _without_keys(facts.message)
        if facts.has_lens:
            values["lens"] = facts.lens
        plain = {name: to_json(value) for name, value in values.items() if value is not None}
        shot, shape = facts.shot, facts.shape
        own: dict[str, object] = {
            "source": shot.source or "",
            "first": facts.played.first,
            "last": facts.played.last,
            "blur": to_json(shot.defocus),
            "looks": [_look_entry(look) for look in shot.looks],
            "offset_m": facts.lens.measuring_offset_m,
            "focus_keys": [key.frame for key in shot.curves.focus_distance_m.keys],
            "frames_per_second": shot.frames_per_second,
            "recording": facts.recording.name.lower(),
            "commands": {
                it.name: [it.is_on, it.barred]  # None: it is no switch; "": it is there
                for it in commands
                if it.name in self._remote
            },
            "shape": [shape.width_px, shape.height_px, shape.pixel_aspect],
            "table": self._table,
            "guides": _guides_entry(facts.view.guides, shape),
            "scale": self._depth_scale(facts.histogram),
        }
        return dict.fromkeys(_NULL) | plain | own

    def _depth_scale(self, histogram: DepthHistogram | None) -> dict[str, object] | None:
        """Return the depth histogram of the picture; the same object until the depths change."""
        if histogram is not self._histogram:
            self._histogram = histogram
            self._scale = None if histogram is None else _histogram_entry(histogram)
        return self._scale


def _without_keys(message: str) -> str:
    """Return a message without its sentences on keys, which a tablet does not have."""
    sentences = re.split(r"(?<=\.) ", message)
    return " ".join(it for it in sentences if not _NAMES_A_KEY.search(it))


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
    """Return the depth histogram for pages, its heights rounded."""
    heights = [round(float(height), _DIGITS) for height in histogram.heights]
    return {"heights": heights, "most_dioptres": histogram.most_dioptres}
