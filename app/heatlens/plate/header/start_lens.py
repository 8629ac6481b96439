"""The lens to start with: from given values, else from the plate's header, else usual values."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from heatlens.base.errors import LensError
from heatlens.model.lens.aperture import APERTURE_FIELDS
from heatlens.model.lens.lens import Lens
from heatlens.model.lens.lens_model import LensModel
from heatlens.model.option import Values
from heatlens.plate.header.camera_header import lens_model_of
from heatlens.plate.plate import Plate

_OTHERS = (*APERTURE_FIELDS, "widest_f_stop", "close_focus_m")  # headers do not have these
# A normal lens on full frame at a medium stop, with which every change of a control is visible.
_USUAL: Values = {"focal_length_mm": 50.0, "f_stop": 2.8, "sensor_width_mm": 36.0}


@dataclass(frozen=True)
class StartLens:
    """A lens, and the source of each of its values by field name."""

    lens: Lens
    sources: Mapping[str, str]


def start_lens(plate: Plate, given: Mapping[str, Any]) -> StartLens:
    """Return the lens to start with; `given` holds fields of Lens.

    Without a focus distance, the focus is on the middle of the picture. Raises LensError if the
    given values are impossible.
    """
    values: Values = {}
    sources: dict[str, str] = {}
    for name, usual in _USUAL.items():
        header = getattr(plate.camera, name)
        if name in given:
            values[name], sources[name] = given[name], "given"
        elif _is_possible(name, header):
            values[name], sources[name] = header, f"header, {plate.camera.sources.get(name)}"
        else:
            values[name], sources[name] = usual, "assumed: not in the header"
    values["focus_distance_m"], sources["focus_distance_m"] = _focus(plate, given, values)
    values["model"], sources["model"] = _model(plate, given)
    extra = {name: given[name] for name in _OTHERS if name in given}
    t_stop = plate.camera.t_stop if _is_possible("t_stop", plate.camera.t_stop) else None
    return StartLens(Lens(**values, **extra, t_stop=t_stop), sources)


def _model(plate: Plate, given: Mapping[str, Any]) -> tuple[LensModel, str]:
    return (given["model"], "given") if "model" in given else lens_model_of(plate.camera)


def _is_possible(name: str, value: float | None) -> bool:
    """Return whether a lens can have this value; an absurd header must not block the plate."""
    if value is None:
        return False
    try:
        Lens(**{**_USUAL, "focus_distance_m": math.inf, name: value})
    except LensError:
        return False
    return True


def _focus(plate: Plate, given: Mapping[str, Any], values: Mapping[str, Any]) -> tuple[float, str]:
    if "focus_distance_m" in given:
        return given["focus_distance_m"], "given"
    header = plate.camera.focus_distance_m
    if header is not None and header * 1e3 > values["focal_length_mm"]:
        return header, f"header, {plate.camera.sources.get('focus_distance_m')}"
    middle = _middle_depth_m(plate)
    if middle * 1e3 > values["focal_length_mm"]:
        return middle, "what is in the middle of the picture"
    return math.inf, "infinity: no other distance is known"


def _middle_depth_m(plate: Plate) -> float:
    """Return the median depth of the middle ninth of the picture."""
    if plate.depth_m is None:
        return math.inf
    height, width = plate.depth_m.shape
    third = plate.depth_m[height // 3 : height - height // 3, width // 3 : width - width // 3]
    ordered = np.sort(third, axis=None)
    return float(ordered[len(ordered) // 2])
