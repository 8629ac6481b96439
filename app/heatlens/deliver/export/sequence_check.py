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
# Centimetres or inches read as metres are a factor of 100 or 39, and 1/z is mostly more than 20.
_JUMP = 20.0
_SAMPLES_A_SIDE = 128  # a grid of this many pixels a side gives the median to within a few per cent
_NUMBER = re.compile(r"[0-9]+(?:[.,][0-9]+)*")


@dataclass(frozen=True)
class Remark:
    """A remark on an unusual frame: a sentence, and a key that is equal for similar frames."""

    key: str
    sentence: str


class SequenceCheck:
    """Compares each plate with those before it; the first one sets the standard."""

    def __init__(self, scene_unit_m: float) -> None:
        self._scene_unit_m = scene_unit_m
        self._display: Box | None = None
        self._dioptres: float | None = None  # median of the latest frame without a jump
        self._usual: set[str] = set()  # keys of the notes of the first plate

    def remarks(self, plate: Plate) -> tuple[Remark, ...]:
        """Return remarks on the plate of the next frame; () for the first one."""
        noted = self._noted(plate)
        if self._display is None:
            self._display, self._dioptres = plate.display_window, median_dioptres(plate)
            self._usual = {remark.key for remark in noted}
            return ()
        new = tuple(remark for remark in noted if remark.key not in self._usual)
        return (*self._of_size(plate, self._display), *self._of_depth(plate), *new)

    def _of_size(self, plate: Plate, usual: Box) -> tuple[Remark, ...]:
        own = plate.display_window
        if own == usual:
            return ()
        sentence = (
            f"The display window is {_window_words(own)}, that of the frames before "
            f"{_window_words(usual)}. Most programs expect one size in a sequence."
        )
        return (Remark(sentence, sentence),)

    def _of_depth(self, plate: Plate) -> tuple[Remark, ...]:
        before, now = self._dioptres, median_dioptres(plate)
        if now is None:
            return ()
        if before is None or 1 / _JUMP <= now / before <= _JUMP:
            self._dioptres = now
            return ()
        factor, word = (before / now, "far") if now < before else (now / before, "near")
        sentence = (
            f"The depths are about {factor:.0f} times as {word} as in the frames before, as in "
            "another unit or convention. Render the frame like the others, or export it by "
            "itself with its own --scene-unit or --depth-convention."
        )
        return (Remark(f"depths {word}", sentence),)

    def _noted(self, plate: Plate) -> list[Remark]:
        """Return the notes and doubts about a plate, except those reported in other ways."""
        reported = {report.sentence for report in plate.behind} | {plate.surfaces_lost}
        doubtful = [it.sentence for it in span_doubts(depth_span(plate, self._scene_unit_m))]
        notes = [note for note in (*plate.notes, *doubtful) if note not in reported]
        plain = [note.replace(f"{plate.path}: ", "") for note in notes]
        return [Remark(_NUMBER.sub("#", note), note) for note in plain]


def median_dioptres(plate: Plate) -> float | None:
    """Return the median of 1/depth of the surfaces; None without distances or surfaces."""
    if plate.depth_m is None:
        return None
    rows, columns = (max(side // _SAMPLES_A_SIDE, 1) for side in plate.depth_m.shape)
    sample = plate.depth_m[::rows, ::columns]
    surfaces = sample[np.isfinite(sample)]
    return float(1 / np.median(surfaces)) if surfaces.size else None


def _window_words(box: Box) -> str:
    at = f" at {box.x0}, {box.y0}" if box.x0 or box.y0 else ""
    return f"{box.width}x{box.height}{at}"
