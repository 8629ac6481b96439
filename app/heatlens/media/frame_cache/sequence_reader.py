"""Read all frames of a sequence in the same way as its first frame."""

import threading
from dataclasses import replace
from pathlib import Path

from heatlens.core.base.errors import InputError
from heatlens.core.model.depth_words import DepthConvention
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.media.plate.plate import DepthReport, Plate
from heatlens.media.plate.read import read_plate


class SequenceReader:
    """Reads plates; an unknown depth convention is guessed once for all frames.

    A guess depends on the values of a frame, and a sequence must not change its convention from one
    frame to the next. The frame at `deciding_path` decides; if it is None or cannot be read, the
    first frame that is read decides. May be called from several threads.

    The bins of the depths are counted here as well, because the thread that shows a plate is busier
    than the one that reads it.
    """

    def __init__(self, options: PlateOptions, deciding_path: Path | None = None) -> None:
        self._options, self._deciding_path = options, deciding_path
        self._guess: DepthReport | None = None  # how the frame was read that decided
        self._lock = threading.Lock()

    def __call__(self, path: Path) -> Plate:
        """Read the plate at `path`. Raises InputError as `read_plate` does."""
        with self._lock:  # held while the deciding frame is read, because the others wait for it
            options = self._options
            has_unknown_convention = len(options.behind_conventions) < len(options.behind)
            if options.depth_convention is DepthConvention.AUTO or has_unknown_convention:
                return self._read_and_decide(path)
        return read_plate(path, options).with_reason(self._guess).count_bins()

    def _read_and_decide(self, path: Path) -> Plate:
        """Read the plate at `path` after the deciding frame has fixed the conventions."""
        if self._deciding_path is not None and self._deciding_path != path:
            try:
                self._fix_conventions(read_plate(self._deciding_path, self._options))
            except InputError:  # reported when that frame is shown; another one decides
                self._deciding_path = None
        plate = read_plate(path, self._options)
        self._fix_conventions(plate)
        return plate.with_reason(self._guess).count_bins()

    def _fix_conventions(self, plate: Plate) -> None:
        """Make all later plates be read with the conventions of this one."""
        if self._options.depth_convention is DepthConvention.AUTO:
            self._guess = plate.depth
        self._options = fix_conventions(self._options, plate)


def fix_conventions(options: PlateOptions, plate: Plate) -> PlateOptions:
    """Return `options` with the conventions that were used for `plate` and the pictures behind."""
    convention_by_name = {report.name: report.convention for report in plate.behind}
    return replace(
        options,
        depth_convention=plate.depth.convention,
        behind_conventions=tuple(convention_by_name[text] for text in options.behind),
    )
