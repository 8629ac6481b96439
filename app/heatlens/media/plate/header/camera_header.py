"""Read and write the lens in an EXR header, by the OpenEXR list of standard attributes.

The focus distance is in meters; focal length and sensor size are in millimeters.
"""

import math
import textwrap
from collections.abc import Mapping, Sequence

import numpy as np

from heatlens.core.base.errors import InputError
from heatlens.core.model.lens.lens import LensModel
from heatlens.core.model.option import Values
from heatlens.media.plate.header.entries import rendering_program
from heatlens.media.plate.header.shoot_names import ShootLens, is_shoot_entry, read_shoot_lens
from heatlens.media.plate.plate import CameraHeader

Header = Values

# Each field of CameraHeader and the attributes that give it, most specific to pinholes first.
_ATTRIBUTES = {
    "focus_distance_m": ("focus",),
    "f_stop": ("aperture",),
    "focal_length_mm": ("pinholeFocalLength", "nominalFocalLength", "effectiveFocalLength"),
    "t_stop": ("tStop",),
}
_NUMBERS_MOST = 4  # entries with more numbers are not shown number by number
_SENSOR = "sensorOverallDimensions"
_MODEL = "heatlens:lensModel"  # our own attribute: the standard has none


def camera_at_header(headers: Sequence[Header]) -> CameraHeader:
    """Return the lens values of `headers`; the first header that has a value decides it.

    A value that no lens can have (zero, negative, not a number) counts as missing, and `refused`
    of the result says why. Only the focus may be infinite.
    """
    values: Values = {}
    sources: dict[str, str] = {}
    for name, attributes in _ATTRIBUTES.items():
        for attribute in attributes:
            value = _first_number(headers, attribute, allow_infinite=name == "focus_distance_m")
            if value is not None:
                values[name], sources[name] = value, attribute
                break
    for name, axis in (("sensor_width_mm", 0), ("sensor_height_mm", 1)):
        value = _first_sensor_side(headers, axis)
        if value is not None:
            values[name], sources[name] = value, _SENSOR
    _add_lens_of_shoot(headers, values, sources)
    if (model := _find_model(headers)) is not None:
        values["model"], sources["model"] = model
    return CameraHeader(**values, sources=sources, refused=_describe_unusable(headers, values))


def _describe_unusable(headers: Sequence[Header], values: Mapping[str, object]) -> dict[str, str]:
    """Return by field why the header gives no value for it, such as "aperture is 0"."""
    entries = {name: _first_entry(headers, names) for name, names in _ATTRIBUTES.items()}
    width = next((header[_SENSOR] for header in headers if _SENSOR in header), None)
    # A height of 0 says that it is not known.
    entries["sensor_width_mm"] = None if width is None else (_SENSOR, width)
    return {
        name: f"{entry[0]} is {_shorten_value(entry[1])}"
        for name, entry in entries.items()
        if entry is not None and name not in values
    }


def _first_entry(headers: Sequence[Header], names: Sequence[str]) -> tuple[str, object] | None:
    """Return the first attribute in `names` that a header has, with its value; or None."""
    return next(((name, h[name]) for name in names for h in headers if name in h), None)


def _shorten_value(value: object) -> str:
    """Return a value of a header as text, not longer than a few words."""
    if isinstance(value, float):
        return f"{value:g}"
    if isinstance(value, np.ndarray) and value.dtype.kind in "iuf" and value.size <= _NUMBERS_MOST:
        return " x ".join(f"{number:g}" for number in value.flat)
    try:
        return textwrap.shorten(repr(value), 40)
    except UnicodeDecodeError:  # the library shows the name of a type as it is in the file
        return "of an unknown type"


def _add_lens_of_shoot(
    headers: Sequence[Header], values: dict[str, object], sources: dict[str, str]
) -> None:
    """Add values from the metadata of cameras on set that `values` lacks, with their sources.

    A T-stop stands in for a missing f-stop.
    """
    entries = {n: v for header in reversed(headers) for n, v in header.items() if is_shoot_entry(n)}
    lens = read_shoot_lens(entries) if entries else ShootLens()
    for name in _ATTRIBUTES:
        value = getattr(lens, name)
        if value is not None and name not in values:
            unit = "" if name != "focus_distance_m" or lens.has_unit else ", taken as metres"
            values[name], sources[name] = value, f"{lens.sources[name]}{unit}"
    if "f_stop" not in values and lens.t_stop is not None:
        values["f_stop"] = lens.t_stop
        sources["f_stop"] = f"{lens.sources['t_stop']}, a T-stop taken as an f-stop"


def lens_model_of(camera: CameraHeader) -> tuple[LensModel, str]:
    """Return the lens model for a plate with this header, and a few words on what decides it."""
    if camera.model is None:
        return LensModel.PHOTOGRAPHIC, "the header names no CG renderer"
    return camera.model, camera.sources.get("model", "header")


def require_lens_mm(
    path: object, focal_length_mm: float | None, sensor_width_mm: float | None
) -> tuple[float, float]:
    """Return both lengths; raise InputError that names the option for a missing one."""
    if focal_length_mm is None or sensor_width_mm is None:
        missing = "--focal-length" if focal_length_mm is None else "--sensor-width"
        raise InputError(
            f"{path}: converting radial depth to planar needs the lens, which the header does not "
            f"give: add {missing} (mm)."
        )
    return focal_length_mm, sensor_width_mm


def _find_model(headers: Sequence[Header]) -> tuple[LensModel, str] | None:
    """Return the lens model that the headers give and its source; our own entry comes first."""
    for header in headers:
        if header.get(_MODEL) in list(LensModel):
            return LensModel(header[_MODEL]), f"header, {_MODEL}"
    program = rendering_program(headers)
    return (LensModel.RENDERER, f"header, written by {program}") if program else None


def lens_attributes(
    focal_length_mm: float,
    f_stop: float,
    focus_distance_m: float,
    sensor_width_mm: float,
    sensor_height_mm: float | None = None,
    t_stop: float | None = None,
    model: LensModel | None = None,
) -> dict[str, object]:
    """Return header attributes for a lens; the reverse of `camera_at_header`."""
    attributes: dict[str, object] = {
        "focus": float(focus_distance_m),
        "aperture": float(f_stop),
        "pinholeFocalLength": float(focal_length_mm),
    }
    if t_stop is not None:
        attributes["tStop"] = float(t_stop)
    if model is not None:
        attributes[_MODEL] = str(model)
    height = 0.0 if sensor_height_mm is None else sensor_height_mm  # 0: not known
    attributes[_SENSOR] = np.array([sensor_width_mm, height], dtype=np.float32)
    return attributes


def _first_number(headers: Sequence[Header], attribute: str, allow_infinite: bool) -> float | None:
    """Return the first usable value of `attribute` in the headers; None if there is none."""
    for header in headers:
        value = header.get(attribute)
        if isinstance(value, int | float) and _is_usable(value, allow_infinite):
            return float(value)
    return None


def _first_sensor_side(headers: Sequence[Header], axis: int) -> float | None:
    """Return the first usable width (axis 0) or height (axis 1) of the sensor in mm, or None."""
    for header in headers:
        size = np.asarray(header.get(_SENSOR, ()))
        if (
            size.shape == (2,)
            and size.dtype.kind in "if"
            and _is_usable(size[axis], allow_infinite=False)
        ):
            return float(size[axis])
    return None


def _is_usable(value: float, allow_infinite: bool) -> bool:
    """Return whether a number is positive; infinity counts only where `allow_infinite` says so."""
    return value > 0 and (allow_infinite or math.isfinite(value))
