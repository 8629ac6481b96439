"""The state of a session that a page shows, as entries of JSON."""

from collections.abc import Mapping

from heatlens.core.base.errors import HeatlensError
from heatlens.core.model.focus.coc import hyperfocal_m
from heatlens.core.model.shot.look import Look
from heatlens.core.model.value_bins import DepthHistogram
from heatlens.core.model.view.guides import NO_GUIDES, Guides, frame_lines_for, guide_shapes
from heatlens.core.model.view.view_geometry import PictureShape
from heatlens.media.files.json_record import record_to_json, to_json
from heatlens.studio.board.board import Board
from heatlens.studio.session.session import Session

_DIGITS = 3  # decimals of the histogram's heights


class PageState:
    """Collects the state of a session for pages."""

    def __init__(self, session: Session, board: Board) -> None:
        self._session = session
        self._board = board
        self._scale_histogram: DepthHistogram | None = None
        self._scale: Mapping[str, object] | None = None

    def entries(self) -> dict[str, object]:
        """Return the state: that of the board, and what a focus wheel and a timeline need."""
        state, remote = self._board.state(), {it.name for it in self._board.remote_commands}
        entries = record_to_json(state)
        entries["commands"] = {
            command.name: [command.is_on, command.barred]  # None: it is no switch; "": it is there
            for command in state.commands
            if command.name in remote
        }
        return entries | self._page_entries()

    def _page_entries(self) -> dict[str, object]:
        """Return the entries that a page needs beside the state of the commands."""
        facts, time, shot = self._session.facts, self._session.time, self._session.facts.shot
        shape, recording = facts.picture_shape, time.recording
        keyed_m = facts.keyed_focus_m if facts.has_lens else None
        return {
            "shape": [shape.width_px, shape.height_px, shape.pixel_aspect],
            "scale": self._depth_scale(),
            "offset_m": facts.lens.measuring_offset_m,
            "hyperfocal_m": self._hyperfocal_m(),
            "keyed_focus_m": to_json(keyed_m),
            "focus_keys": [key.frame for key in shot.curves.focus_distance_m.keys],
            "frames_per_second": shot.frames_per_second,
            "timecode": time.timeline.timecode,
            "looks": [_look_entry(look) for look in shot.looks],
            "table": [[it.name, it.key, it.sheet] for it in self._board.remote_commands],
            "guides": _guides_entry(facts.view.guides, shape),
            "recording": recording.state.name.lower(),
            "beats_left": recording.beats_left,
            "recorded_keys": recording.key_count,
            "has_camera": facts.has_camera,
            "part_done": facts.rendered_share,
        }

    def _depth_scale(self) -> Mapping[str, object] | None:
        """Return the depth histogram of the picture; the same object until the depths change."""
        histogram = self._session.facts.histogram
        if histogram is not self._scale_histogram:
            self._scale_histogram = histogram
            self._scale = None if histogram is None else _histogram_entry(histogram)
        return self._scale

    def _hyperfocal_m(self) -> float | None:
        try:
            return hyperfocal_m(self._session.facts.lens)
        except HeatlensError:  # between two keys, the lens may be impossible
            return None


def _look_entry(look: Look) -> list[object]:
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
