"""Light up the matte of a mark in the picture: while it is pointed at, and after it was set."""

import time
from functools import partial
from pathlib import Path

from heatlens.core.base.background import Background
from heatlens.core.base.errors import InputError
from heatlens.core.base.messages import Worker
from heatlens.core.model.boxes import Box
from heatlens.core.model.marks.marks import MatteMark
from heatlens.media.plate.mattes.mattes import read_matte
from heatlens.media.plate.plate import FloatImage, Plate
from heatlens.studio.session.shared import Commands, Shared

FLASH_S = 0.6


# The coverage (H, W) of each pixel of a data window by a thing, the top row first.
LitMatte = tuple[FloatImage, Box]
_Key = tuple[Path, str]  # the file of a plate, and the name of the matte


class MatteLight(Commands, Worker):
    """Reads the matte that is to be lit, on a thread, and tells how long it is."""

    def __init__(self, shared: Shared) -> None:
        super().__init__(shared)
        self._clock = time.monotonic
        self._reader: Background[LitMatte] = Background(self._wake)
        self.pointed_name: str | None = None  # the mark that a front end points at
        self._new_name: str | None = None  # the mark that was just set
        self._new_until_s: float | None = None  # None until its matte is read
        self._key: _Key | None = None  # of what is read or being read
        self._matte: LitMatte | None = None

    def flash(self, name: str) -> None:
        """Light up the matte of a new mark for a moment, as soon as it is read."""
        self._new_name, self._new_until_s = name, None

    @property
    def matte(self) -> LitMatte | None:
        """The matte that is lit now; None for none."""
        key = self._wished_key
        return self._matte if key is not None and key == self._key else None

    @property
    def _wished_key(self) -> _Key | None:
        """The matte that is to be lit in the plate that is shown."""
        plate, name = self._source.plate, self.pointed_name or self._new_name
        mark = None if name is None else self._editing.shot.mark_named(name)
        if plate is None or not isinstance(mark, MatteMark):
            return None
        return plate.path, mark.matte

    def poll(self) -> None:
        """Read the matte that is to be lit, and end a light that has been long enough."""
        key = self._wished_key
        if key is not None and key != self._key:
            self._key, self._matte = key, None
            assert self._source.plate is not None
            self._reader.start(partial(_read, self._source.plate, key[1]))
        try:
            matte = self._reader.poll()
        except InputError:  # a matte that cannot be read is told where its distance is shown
            self._new_name = None
            return
        if matte is not None:
            self._matte = matte
            self._new_until_s = self._clock() + FLASH_S
        if self._new_until_s is not None and self._clock() >= self._new_until_s:
            self._new_name = self._new_until_s = None

    def seconds_until_needed(self) -> float | None:
        """Return the seconds until the light ends; None if none does by itself."""
        return None if self._new_until_s is None else max(self._new_until_s - self._clock(), 0.0)


def _read(plate: Plate, matte: str) -> LitMatte:
    return read_matte(plate, matte), plate.data_window
