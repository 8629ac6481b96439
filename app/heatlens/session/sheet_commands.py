"""Write the pull sheet of the shot in hand."""

from collections.abc import Callable
from pathlib import Path

from heatlens.errors import HeatlensError
from heatlens.model.marks import DistanceMark
from heatlens.plate.timecode import Timecode, timecode_of
from heatlens.session.editing import Editing
from heatlens.session.focus_track import MarkTrack
from heatlens.session.messages import Problem
from heatlens.session.open_source import OpenSource
from heatlens.session.pull_sheet import sheet_rows, write_sheet
from heatlens.session.shot_documents import ShotDocuments
from heatlens.session.timeline import Timeline


class SheetCommands:
    """Takes keys, marks and timecode from what is open."""

    def __init__(
        self,
        source: OpenSource,
        editing: Editing,
        timeline: Timeline,
        documents: ShotDocuments,
        tracks: Callable[[], tuple[MarkTrack, ...]],
        say: Callable[[str], None],
    ) -> None:
        self._source = source
        self._editing = editing
        self._timeline = timeline
        self._documents = documents
        self._tracks = tracks
        self._say = say

    def write(self, path: Path) -> None:
        """Write the pull as a page for the set, with a table beside it."""
        shot, frames = self._editing.shot, self._timeline.played
        title = self._documents.title.removesuffix(" *") or path.name.split(".")[0]
        try:
            rows = sheet_rows(shot, frames, self.marks_at, self._timecode)
            table = write_sheet(path, title, shot, rows)
            self._say(f"Written {path}, and {table.name} beside it.")
        except (HeatlensError, OSError) as error:
            self._say(Problem(error))

    @property
    def _timecode(self) -> tuple[Timecode, int] | None:
        """The timecode of the frame at the playhead, where its plate tells one."""
        plate = self._source.plate
        told = None if plate is None else timecode_of(plate.attributes)
        return None if told is None else (told, self._editing.frame)

    def marks_at(self, frame: float) -> list[tuple[str, float]]:
        """Return how far marks are at a frame, as far as that is known, in metres."""
        marks = self._editing.shot.marks
        found = [(mark.name, mark.distance_m) for mark in marks if isinstance(mark, DistanceMark)]
        for track in self._tracks():
            points = {at: dioptres for line in track.lines for at, dioptres in line}
            if points.get(round(frame), 0.0) > 0.0:
                found.append((track.name, 1.0 / points[round(frame)]))
        return found
