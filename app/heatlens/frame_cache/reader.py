"""Read all frames of a sequence in the same way as its first frame."""

import threading
from dataclasses import replace
from pathlib import Path

from heatlens.base.errors import InputError
from heatlens.model.depth_words import DepthConvention
from heatlens.model.shot.plate_options import PlateOptions
from heatlens.plate.plate import Plate
from heatlens.plate.read import read_plate


class SequenceReader:
    """Reads plates; if their depth convention is not given, it is guessed once and then kept.

    A guess depends on the values of a frame, and a sequence must not change its convention from one
    frame to the next. `first` is the frame that decides; if it is None or cannot be read, the
    first frame that is read decides. May be called from several threads.

    The bins of the depths are counted here as well, because the thread that shows a plate is busier
    than the one that reads it.
    """

    def __init__(self, options: PlateOptions, first: Path | None = None) -> None:
        self._options = options
        self._first = first
        self._lock = threading.Lock()

    def __call__(self, path: Path) -> Plate:
        """Read the plate at `path`. Raises InputError as `read_plate` does."""
        with self._lock:  # held while the deciding frame is read, because the others wait for it
            options = self._options
            is_open = len(options.behind_conventions) < len(options.behind)
            if options.depth_convention is DepthConvention.AUTO or is_open:
                return self._decided(path)
        return read_plate(path, options).counted()

    def _decided(self, path: Path) -> Plate:
        """Read the plate at `path` after the deciding frame has settled the options."""
        if self._first is not None and self._first != path:
            try:
                self._settle(read_plate(self._first, self._options))
            except InputError:  # reported when that frame is shown; another one decides
                self._first = None
        plate = read_plate(path, self._options)
        self._settle(plate)
        return plate.counted()

    def _settle(self, plate: Plate) -> None:
        self._options = settled_options(self._options, plate)


def settled_options(options: PlateOptions, plate: Plate) -> PlateOptions:
    """Return `options` with the conventions that were used for `plate` and the pictures behind."""
    of_behind = {report.name: report.convention for report in plate.behind}
    return replace(
        options,
        depth_convention=plate.depth.convention,
        behind_conventions=tuple(of_behind[text] for text in options.behind),
    )
