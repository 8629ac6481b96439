"""The frames of one sequence, all read in the way that its first frame was."""

import threading
from dataclasses import replace
from pathlib import Path

from heatlens.errors import InputError
from heatlens.model.plate_options import DepthConvention, PlateOptions
from heatlens.plate.plate import Plate
from heatlens.plate.read import read_plate


class SequenceReader:
    """Reads plates; what nobody said about their depth is found out once, and then kept.

    A guess is made from the values of a frame, and those of the next may look different: a
    sequence must not change its mind in the middle. `first` is the frame that decides, the first
    one read where it is None or cannot be read. May be called from several threads.
    """

    def __init__(self, options: PlateOptions, first: Path | None = None) -> None:
        self._options = options
        self._first = first
        self._lock = threading.Lock()

    def __call__(self, path: Path) -> Plate:
        """Read the plate at `path`. Raises InputError as `read_plate`."""
        with self._lock:  # held while the frame that decides is read: the others depend on it
            options = self._options
            is_open = len(options.behind_conventions) < len(options.behind)
            if options.depth_convention is DepthConvention.AUTO or is_open:
                return self._decided(path)
        return read_plate(path, options)

    def _decided(self, path: Path) -> Plate:
        """Read the plate at `path` once it is settled how the frames are read."""
        if self._first is not None and self._first != path:
            try:
                self._settle(read_plate(self._first, self._options))
            except InputError:  # it will be told when its turn comes; another one decides
                self._first = None
        plate = read_plate(path, self._options)
        self._settle(plate)
        return plate

    def _settle(self, plate: Plate) -> None:
        self._options = settled_options(self._options, plate)


def settled_options(options: PlateOptions, plate: Plate) -> PlateOptions:
    """Return `options` with the conventions that `plate` and those behind were found to follow."""
    of_behind = {report.name: report.convention for report in plate.behind}
    return replace(
        options,
        depth_convention=plate.depth.convention,
        behind_conventions=tuple(of_behind[text] for text in options.behind),
    )
