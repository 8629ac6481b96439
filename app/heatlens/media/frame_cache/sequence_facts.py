"""Survey the frames of a shot and how heatlens reads them, as plain values for JSON."""

from collections.abc import Callable, Collection
from dataclasses import replace
from pathlib import Path
from statistics import fmean

from heatlens.core.base.errors import InputError
from heatlens.core.model.focus.plausibility import span_doubts
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.media.files.picture_formats import is_picture
from heatlens.media.frame_cache.neighbour_reader import NeighbourReader
from heatlens.media.plate.mattes.cryptomatte import thing_names
from heatlens.media.plate.mattes.things import require_things
from heatlens.media.plate.parts.header_read import read_headers
from heatlens.media.plate.plate import BehindReport, Plate, depth_span
from heatlens.media.sequence.depth_files import PlateFiles
from heatlens.media.sequence.names import frames_text
from heatlens.media.sequence.sequence import Sequence

Facts = dict[str, object]


def sequence_facts(
    sequence: Sequence,
    options: PlateOptions,
    report_frame: Callable[[int], None] = lambda frame: None,
) -> Facts:
    """Return frames, gaps, sizes, the depths of the shot, and faults of single frames.

    Reads every frame, and calls `report_frame` before each one. Lengths are in meters; values that
    no frame has are None. A sentence that applies to several frames is returned once. Raises
    InputError if no frame has a thing that the options name.
    """
    require_things(sequence.path_at(sequence.present[0]), options)
    survey = _Survey(options)
    reader = NeighbourReader(options, sequence)
    for frame in sequence.present:
        report_frame(frame)
        try:
            survey.add(frame, reader.read_alone(sequence.path_at(frame)))
        except InputError as error:
            survey.damaged[frame] = str(error)
    return {
        "path": sequence.pattern,
        "frames": frames_text(sequence.present),
        "frame_count": len(sequence.present),
        "missing": frames_text(sequence.missing) if sequence.missing else None,
        **survey.facts(),
        "things": _thing_names(sequence, survey.damaged),
        "neighbours": _neighbour_facts(sequence, reader, survey.damaged),
    }


def _thing_names(sequence: Sequence, damaged: Collection[int]) -> dict[str, list[str]]:
    """Return the names of things in the Cryptomattes of all frames."""
    things: dict[str, set[str]] = {}
    for frame in sequence.present:
        path = sequence.path_at(frame)
        if frame in damaged or is_picture(path):
            continue
        for layer, names in thing_names(path.parent, read_headers(path)).items():
            things.setdefault(layer, set()).update(names)
    return {layer: sorted(names) for layer, names in things.items()}


def _neighbour_facts(
    sequence: Sequence, reader: NeighbourReader, damaged: Collection[int]
) -> Facts:
    """Return the number and step of the neighbors, and the hidden share that they show.

    The share is the mean of three frames.
    """
    neighbourhood = reader.neighbourhood
    readable_frames = [frame for frame in sequence.present if frame not in damaged]
    facts: Facts = {
        "count": neighbourhood.count,
        "step": neighbourhood.step,
        "words": neighbourhood.words,
        "found": None,
    }
    if neighbourhood.count and readable_frames:
        sampled_frames = sorted(
            {readable_frames[0], readable_frames[len(readable_frames) // 2], readable_frames[-1]}
        )
        plates = (reader.read_alone(sequence.path_at(sampled)) for sampled in sampled_frames)
        facts["found"] = fmean(reader.add_hidden_surfaces(plate).hidden_part for plate in plates)
    return facts


class _Survey:
    """Collects facts about single frames: which values occur, and in which frames."""

    def __init__(self, options: PlateOptions) -> None:
        self._options = options
        self._companion_files = {
            Path(companion).name: PlateFiles((companion,)) for companion in options.files_beside
        }
        self._sizes: dict[str, list[int]] = {}
        self._readings: dict[str, list[int]] = {}
        self._notes: dict[str, list[int]] = {}
        self._behind: dict[str, list[BehindReport]] = {}
        self._near: tuple[float, int] | None = None
        self._far: tuple[float, int] | None = None
        self.damaged: dict[int, str] = {}

    def add(self, frame: int, plate: Plate) -> None:
        """Add one frame that could be read."""
        window, depth = plate.display_window, plate.depth
        self._sizes.setdefault(f"{window.width} x {window.height}", []).append(frame)
        reading = f"{depth.channel}, {depth.convention}, {depth.kind}"
        self._readings.setdefault(reading, []).append(frame)
        span = depth_span(plate, self._options.scene_unit_m)
        doubts = [doubt.sentence for doubt in span_doubts(span)]
        for report in plate.behind:
            self._behind.setdefault(report.name, []).append(report)
        behind_sentences = {report.sentence for report in plate.behind}
        for note in (*plate.notes, *doubts):
            if note not in behind_sentences:
                self._notes.setdefault(self._replace_paths(note, plate.path), []).append(frame)
        if span.has_surfaces:
            near, far = (span.near_m, frame), (span.far_m, frame)
            self._near = near if self._near is None else min(self._near, near)
            self._far = far if self._far is None else max(self._far, far)

    def _replace_paths(self, note: str, path: Path) -> str:
        """Return `note` with names that are equal in all frames in place of the frame's paths.

        The same sentence about several frames then becomes one note.
        """
        names = {path: path.name}
        for name, files in self._companion_files.items():
            names |= dict.fromkeys(files(path)[1:], name)
        for file, name in names.items():
            note = note.replace(f"{file}: ", "").replace(str(file), name)
        return note

    def facts(self) -> Facts:
        """Return the collected facts by their names in the JSON."""
        return {
            "sizes": _frames_by_value(self._sizes),
            "depth": _frames_by_value(self._readings),
            "near_m": None if self._near is None else self._near[0],
            "near_frame": None if self._near is None else self._near[1],
            "far_m": None if self._far is None else self._far[0],
            "far_frame": None if self._far is None else self._far[1],
            "behind": {name: _mean_words(reports) for name, reports in self._behind.items()},
            "notes": _frames_by_value(self._notes),
            "damaged": {str(frame): sentence for frame, sentence in self.damaged.items()},
        }


def _mean_words(reports: list[BehindReport]) -> str:
    """Return a phrase on the pixels that a picture behind adds, averaged over its frames."""
    count = len(reports)
    hidden = sum(report.hidden_part for report in reports) / count
    share = sum(report.seen_part for report in reports) / count
    return replace(reports[0], hidden_part=hidden, seen_part=share).words


def _frames_by_value(frames_of: dict[str, list[int]]) -> dict[str, str]:
    """Return the frames of each value as text, by the value."""
    return {name: frames_text(tuple(frames)) for name, frames in frames_of.items()}
