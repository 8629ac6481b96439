"""Build the lens for a plate from given values and the header.

For the first view of a plate, usual values replace missing ones; for a render, missing values are
an error.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from heatlens.core.base.errors import InputError, LensError
from heatlens.core.model.lens.aperture import APERTURE_FIELDS
from heatlens.core.model.lens.lens import Lens, LensModel
from heatlens.core.model.option import Values
from heatlens.media.plate.header.camera_header import lens_model_of
from heatlens.media.plate.plate import Plate

FULL_FRAME_WIDTH_MM = 36.0
# The values that blur depends on, with the names that users see.
NEEDED = {
    "focal_length_mm": "focal length",
    "sensor_width_mm": "sensor width",
    "f_stop": "f-stop",
    "focus_distance_m": "focus distance",
}

_OPTIONAL_FIELDS = (*APERTURE_FIELDS, "widest_f_stop", "close_focus_m")  # headers do not have these
# A normal lens on full frame at a medium stop, with which every change of a control is visible.
_USUAL_VALUES: Values = {"focal_length_mm": 50.0, "f_stop": 2.8, "sensor_width_mm": 36.0}


@dataclass(frozen=True)
class StartLens:
    """A lens, and the source of each of its values by field name."""

    lens: Lens
    sources: Mapping[str, str]


def start_lens(plate: Plate, given_fields: Mapping[str, Any]) -> StartLens:
    """Return the lens for the first view of a plate; `given_fields` are fields of Lens by name.

    Without a focus distance, the focus is on the middle of the picture. Raises LensError if the
    given values are impossible.
    """
    values: Values = {}
    sources: dict[str, str] = {}
    for name, usual_value in _USUAL_VALUES.items():
        header_value = getattr(plate.camera, name)
        if name in given_fields:
            values[name], sources[name] = given_fields[name], "given"
        elif _is_possible(name, header_value):
            values[name], sources[name] = header_value, f"header, {plate.camera.sources.get(name)}"
        else:
            values[name], sources[name] = usual_value, "assumed: not in the header"
    values["focus_distance_m"], sources["focus_distance_m"] = _choose_focus(
        plate, given_fields, values
    )
    values["model"], sources["model"] = _choose_model(plate, given_fields)
    optional_fields = {
        name: given_fields[name] for name in _OPTIONAL_FIELDS if name in given_fields
    }
    t_stop = plate.camera.t_stop if _is_possible("t_stop", plate.camera.t_stop) else None
    return StartLens(Lens(**values, **optional_fields, t_stop=t_stop), sources)


def _choose_model(plate: Plate, given_fields: Mapping[str, Any]) -> tuple[LensModel, str]:
    """Return the lens model and its source: the given one, or that of the header."""
    return (
        (given_fields["model"], "given") if "model" in given_fields else lens_model_of(plate.camera)
    )


def _is_possible(field_name: str, value: float | None) -> bool:
    """Return whether a lens can have this value; an absurd header must not block the plate."""
    if value is None:
        return False
    far: Values = {"focus_distance_m": math.inf}  # the focus must be beyond any focal length
    try:
        Lens(**{**_USUAL_VALUES, **far, field_name: value})
    except LensError:
        return False
    return True


def _choose_focus(
    plate: Plate, given_fields: Mapping[str, Any], values: Mapping[str, Any]
) -> tuple[float, str]:
    """Return the focus distance in meters and its source.

    It is the given one, that of the header, or the depth in the middle of the picture.
    """
    if "focus_distance_m" in given_fields:
        return given_fields["focus_distance_m"], "given"
    header_m = plate.camera.focus_distance_m
    # No lens can focus at its focal length or nearer.
    if header_m is not None and header_m * 1e3 > values["focal_length_mm"]:
        return header_m, f"header, {plate.camera.sources.get('focus_distance_m')}"
    middle_m = _middle_depth_m(plate)
    if middle_m * 1e3 > values["focal_length_mm"]:
        return middle_m, "what is in the middle of the picture"
    return math.inf, "infinity: no other distance is known"


def _middle_depth_m(plate: Plate) -> float:
    """Return the median depth of the middle ninth of the picture."""
    if plate.depth_m is None:
        return math.inf
    height, width = plate.depth_m.shape
    middle_area = plate.depth_m[height // 3 : height - height // 3, width // 3 : width - width // 3]
    ordered = np.sort(middle_area, axis=None)
    return float(ordered[len(ordered) // 2])


class MissingLensError(InputError):
    """Some values of the lens are given neither by the caller nor by the header."""

    def __init__(self, plate: Plate, fields: tuple[str, ...]) -> None:
        """Keep the names of all missing fields of Lens."""
        self.plate = plate
        self.fields = fields
        super().__init__(self.sentence({name: name for name in fields}))

    def sentence(self, option_names: Mapping[str, str]) -> str:
        """Return the message; `option_names` holds the option for each field of Lens."""
        missing_words = _join_with_and([NEEDED[name] for name in self.fields])
        pronoun = "it" if len(self.fields) == 1 else "them"
        option_words = _join_with_and([option_names[name] for name in self.fields])
        unusable_words = self._unusable_words()
        return (
            f"{self.plate.path}: the header has no {missing_words}{unusable_words}; give "
            f"{pronoun} with {option_words}."
        )

    def _unusable_words(self) -> str:
        """Return which of the missing values the header gives as a value that no lens can have."""
        refused = self.plate.camera.refused
        sentences = [refused[name] for name in self.fields if name in refused]
        if not sentences:
            return ""
        return f" ({_join_with_and(sentences)}: ignored: no real lens has this value)"


def plate_lens(plate: Plate, given_fields: Mapping[str, Any]) -> StartLens:
    """Return the lens of given fields and the plate's header, and the source of each value.

    Only the sensor may be assumed, as full frame; its source then says so. A plate with a circle of
    confusion needs no lens values. Raises MissingLensError if values are missing, and LensError if
    they are impossible.
    """
    if not plate.has_distances:
        without_effect: Values = {**_USUAL_VALUES, "focus_distance_m": math.inf}
        return StartLens(Lens(**without_effect, **_aperture_fields(given_fields)), {})
    values, sources = dict(given_fields), dict.fromkeys(given_fields, "given")
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


def _aperture_fields(given_fields: Mapping[str, object]) -> Values:
    """Return those of the given fields that describe the aperture."""
    return {name: given_fields[name] for name in APERTURE_FIELDS if name in given_fields}


def _join_with_and(words: list[str]) -> str:
    """Return the words joined as "a, b and c"."""
    return words[0] if len(words) == 1 else f"{', '.join(words[:-1])} and {words[-1]}"
