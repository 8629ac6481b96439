"""Find frames of a sequence whose plates differ from those before: size, depth, new notes.

All frames are read with the conventions of the first one, so a frame in another unit would silently
become a wrong picture.
"""

import re
from dataclasses import dataclass

import numpy as np

from heatlens.core.model.boxes import Box
from heatlens.core.model.focus.plausibility import span_doubts
from heatlens.media.plate.plate import Plate, depth_span

# From one frame to the next, a cut or a person crossing the picture may change the median tenfold.
# Centimeters or inches read as meters are a factor of 100 or 39, and 1/z is mostly more than 20.
_JUMP = 20.0
_SAMPLES_PER_SIDE = (
    128  # a grid of this many pixels a side gives the median to within a few per cent
)
_NUMBER = re.compile(r"[0-9]+(?:[.,][0-9]+)*")


@dataclass(frozen=True)
class Remark:
    """A remark on an unusual frame: a sentence, and a key that is equal for similar frames."""

    key: str
    sentence: str


class SequenceCheck:
    """Compares the plate of each frame with those of earlier frames, beginning with the first."""

    def __init__(self, scene_unit_m: float) -> None:
        self._scene_unit_m = scene_unit_m
        self._usual_window: Box | None = None
        self._usual_dioptres: float | None = None  # median of the latest frame without a jump
        self._usual_notes: set[str] = set()  # keys of the notes of the first plate

    def check(self, plate: Plate) -> tuple[Remark, ...]:
        """Return remarks on the next plate; the first one only sets what is usual, and has none."""
        note_remarks = self._notes_as_remarks(plate)
        if self._usual_window is None:
            self._usual_window, self._usual_dioptres = plate.display_window, median_dioptres(plate)
            self._usual_notes = {remark.key for remark in note_remarks}
            return ()
        new_remarks = tuple(
            remark for remark in note_remarks if remark.key not in self._usual_notes
        )
        return (
            *self._compare_size(plate, self._usual_window),
            *self._compare_depth(plate),
            *new_remarks,
        )

    def _compare_size(self, plate: Plate, usual_window: Box) -> tuple[Remark, ...]:
        """Return a remark if the display window is not that of earlier frames."""
        window = plate.display_window
        if window == usual_window:
            return ()
        sentence = (
            f"The display window is {_window_text(window)}, that of the frames before "
            f"{_window_text(usual_window)}. Most programs expect one size in a sequence."
        )
        return (Remark(sentence, sentence),)

    def _compare_depth(self, plate: Plate) -> tuple[Remark, ...]:
        """Return a remark if the median of 1/depth jumps; otherwise it becomes the usual one."""
        previous, current = self._usual_dioptres, median_dioptres(plate)
        if current is None:
            return ()
        if previous is None or 1 / _JUMP <= current / previous <= _JUMP:
            self._usual_dioptres = current
            return ()
        factor, word = (
            (previous / current, "far") if current < previous else (current / previous, "near")
        )
        sentence = (
            f"The depths are about {factor:.0f} times as {word} as in the frames before. Render "
            "the frame like the others, or export it by itself with its own --scene-unit or "
            "--depth-convention."
        )
        return (Remark(f"depths {word}", sentence),)

    def _notes_as_remarks(self, plate: Plate) -> list[Remark]:
        """Return the notes and doubts about a plate, except those reported in other ways."""
        reported = {report.sentence for report in plate.behind} | {plate.surfaces_lost}
        doubts = [it.sentence for it in span_doubts(depth_span(plate, self._scene_unit_m))]
        notes = [note for note in (*plate.notes, *doubts) if note not in reported]
        texts = [note.replace(f"{plate.path}: ", "") for note in notes]
        return [Remark(_NUMBER.sub("#", note), note) for note in texts]


def median_dioptres(plate: Plate) -> float | None:
    """Return the median of 1/depth of the surfaces; None without distances or surfaces."""
    if plate.depth_m is None:
        return None
    rows, columns = (max(side // _SAMPLES_PER_SIDE, 1) for side in plate.depth_m.shape)
    sample = plate.depth_m[::rows, ::columns]
    surfaces = sample[np.isfinite(sample)]
    return float(1 / np.median(surfaces)) if surfaces.size else None


def _window_text(box: Box) -> str:
    """Return the size of a data window, and its origin unless that is 0, 0."""
    origin = f" at {box.x0}, {box.y0}" if box.x0 or box.y0 else ""
    return f"{box.width}x{box.height}{origin}"
