"""The lens for a plate from given values and the header, where nothing may be assumed."""

import math
from collections.abc import Mapping
from typing import Any

from heatlens.base.errors import InputError
from heatlens.model.lens.aperture import APERTURE_FIELDS
from heatlens.model.lens.lens import Lens
from heatlens.model.option import Values
from heatlens.plate.header.camera_header import lens_model_of
from heatlens.plate.header.start_lens import StartLens
from heatlens.plate.plate import Plate

FULL_FRAME_WIDTH_MM = 36.0
# The values that blur depends on, with the names that users see.
NEEDED = {
    "focal_length_mm": "focal length",
    "sensor_width_mm": "sensor width",
    "f_stop": "f-stop",
    "focus_distance_m": "focus distance",
}


class MissingLensError(InputError):
    """Some values of the lens are given neither by the caller nor by the header."""

    def __init__(self, plate: Plate, fields: tuple[str, ...]) -> None:
        """Keep the names of all missing fields of Lens."""
        self.plate = plate
        self.fields = fields
        super().__init__(self.sentence({name: name for name in fields}))

    def sentence(self, how: Mapping[str, str]) -> str:
        """Return the message; `how` names for each field of Lens the option that gives it."""
        what = _listed([NEEDED[name] for name in self.fields])
        them = "it" if len(self.fields) == 1 else "them"
        given = _listed([how[name] for name in self.fields])
        why = self._refused_words()
        return f"{self.plate.path}: the header has no {what}{why}; give {them} with {given}."

    def _refused_words(self) -> str:
        """Return which of the missing values the header gives as a value that no lens can have."""
        refused = self.plate.camera.refused
        found = [refused[name] for name in self.fields if name in refused]
        if not found:
            return ""
        return f" ({_listed(found)}: ignored: no real lens has this value)"


def plate_lens(plate: Plate, given: Mapping[str, Any]) -> StartLens:
    """Return the lens of `given` fields and the plate's header, and the source of each value.

    Only the sensor may be assumed, as full frame; its source then says so. A plate with a circle of
    confusion needs no lens values. Raises MissingLensError if values are missing, and LensError if
    they are impossible.
    """
    if not plate.has_distances:
        return StartLens(Lens(50.0, 2.8, math.inf, FULL_FRAME_WIDTH_MM, **_opening(given)), {})
    values, sources = dict(given), dict.fromkeys(given, "given")
    for name in NEEDED:
        value = getattr(plate.camera, name)
        if name not in values and value is not None:
            values[name] = value
            sources[name] = f"header, {plate.camera.sources.get(name, 'camera')}"
    if "sensor_width_mm" not in values:
        values["sensor_width_mm"] = FULL_FRAME_WIDTH_MM
        sources["sensor_width_mm"] = "assumed full frame"
    if "model" not in values:
        values["model"], sources["model"] = lens_model_of(plate.camera)
    missing = tuple(name for name in NEEDED if name not in values)
    if missing:
        raise MissingLensError(plate, missing)
    return StartLens(Lens(**values), sources)


def _opening(given: Mapping[str, object]) -> Values:
    return {name: given[name] for name in APERTURE_FIELDS if name in given}


def _listed(words: list[str]) -> str:
    """Return the words joined as "a, b and c"."""
    return words[0] if len(words) == 1 else f"{', '.join(words[:-1])} and {words[-1]}"
