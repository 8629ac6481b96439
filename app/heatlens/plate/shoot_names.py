"""Read lens metadata of cameras on set, from the headers of EXR files and from tables.

The known names are those of ARRI (Meta Extract, and `com.arri.camera.` in headers), of Cooke /i and
Zeiss eXtended Data as cameras pass them on, of RED and of Sony. Names are compared without path,
unit, case and punctuation, so that "Lens Focus Distance", "lens_focus_distance_m" and
"com.arri.camera.LensFocusDistance" are the same.
"""

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

from heatlens.model.units import FOOT_M, INCH_M
from heatlens.plate.shoot_values import (
    Length,
    distance,
    focal_length,
    is_missing,
    linear_iris,
    squeeze,
    stop,
)

_FOCUS = ("lensfocusdistance", "focusdistance", "focusdist", "lensdistance", "focus")
_LENGTH = ("lensfocallength", "focallength", "lenszoom", "zoom", "length")
_F_STOP = ("lensfstop", "fstop", "fnumber", "lensfnumber")
_T_STOP = (
    *("lenststop", "tstop", "tnumber", "lensiris", "iris", "lensaperture", "aperture"),
    *("aperturevalue", "lenststopnumber"),
)
_LINEAR_IRIS = ("lenslineariris",)  # ARRI: thousandths of a stop, 1000 is T1
_SQUEEZE = ("lenssqueeze", "lenssqueezefactor", "anamorphicsqueeze", "squeeze")
_DISTANCE_UNIT = ("lensdistanceunit", "distanceunit", "lensunit")
_UNITS_M = {
    **dict.fromkeys(("m", "meter", "metre", "meters", "metres", "metric"), 1.0),
    **dict.fromkeys(("mm", "millimeter", "millimetre"), 1e-3),
    **dict.fromkeys(("cm", "centimeter", "centimetre"), 1e-2),
    **dict.fromkeys(("ft", "feet", "foot", "imperial"), FOOT_M),
    **dict.fromkeys(("in", "inch", "inches"), INCH_M),
}
_UNIT_AT_END = re.compile(r"(?:[(\[]\s*([a-z]+)\s*[)\]]|[_ ]([a-z]+))\s*$")
_VENDOR = re.compile(r"arri|cooke|zeiss|sony|red\b", re.IGNORECASE)


@dataclass(frozen=True)
class ShootLens:
    """The values of a lens in the metadata of one frame; None for missing ones.

    sources     field -> the name of the entry that gave it
    has_unit    False if the distance had no unit and metres were assumed
    unreadable  field -> the name of an entry whose value cannot be read, where no other gave one
    """

    focus_distance_m: float | None = None
    focal_length_mm: float | None = None
    f_stop: float | None = None
    t_stop: float | None = None
    squeeze: float | None = None
    sources: Mapping[str, str] = field(default_factory=dict)
    has_unit: bool = True
    unreadable: Mapping[str, str] = field(default_factory=dict)


def shoot_lens(entries: Mapping[str, Any], unit_m: float | None = None) -> ShootLens:
    """Return the lens values in the entries of a header or the cells of a table row.

    `unit_m` is the length in metres of the unit of distances, for metadata that does not name one;
    a unit beside a value goes before that of its name, and before `unit_m`. Zero, as cameras write
    it for what they do not know, counts as missing. Impossible values count as unreadable.
    """
    names = {_plain(name): name for name in entries}
    values: dict[str, Any] = {}
    sources: dict[str, str] = {}
    unreadable: dict[str, str] = {}

    def take(target: str, known: tuple[str, ...], parse: Callable[[Any], Any]) -> str | None:
        for name in (names[plain] for plain in known if plain in names):
            if is_missing(entries[name]):
                continue
            value = parse(entries[name])
            if value is not None:
                values[target], sources[target] = value, name
                unreadable.pop(target, None)
                return name
            unreadable.setdefault(target, name)
        return None

    focus = take("focus_distance_m", _FOCUS, distance)
    length = take("focal_length_mm", _LENGTH, focal_length)
    take("f_stop", _F_STOP, stop)
    take("t_stop", _LINEAR_IRIS, linear_iris) or take("t_stop", _T_STOP, stop)
    take("squeeze", _SQUEEZE, squeeze)
    has_unit = True
    if focus is not None:
        told: Length = values["focus_distance_m"]
        known_m = told.unit_m or _unit_of(focus, names, entries) or unit_m
        values["focus_distance_m"], has_unit = told.in_metres(known_m or 1.0), known_m is not None
    if length is not None:
        values["focal_length_mm"] = values["focal_length_mm"].in_millimetres(_named_unit(length))
    return ShootLens(**values, sources=sources, has_unit=has_unit, unreadable=unreadable)


def is_of_shoot(name: str) -> bool:
    """Return True for a header entry of a camera on set, False for one of a CG renderer."""
    plain = _plain(name)
    return plain.startswith("lens") or bool(_VENDOR.search(name))


def _plain(name: str) -> str:
    """Return the last component of a name, without unit, as lower-case letters and digits."""
    last = re.split(r"[/:]|\.(?=[A-Za-z])", name.strip())[-1]
    words = re.sub(r"(?<=[a-z])(?=[A-Z])", " ", last).lower()
    return re.sub(r"[^a-z0-9]", "", _UNIT_AT_END.sub(_without_unit, words))


def _without_unit(match: re.Match[str]) -> str:
    unit = match[1] or match[2]
    return "" if unit in _UNITS_M else match[0]


def _unit_of(name: str, names: Mapping[str, str], entries: Mapping[str, Any]) -> float | None:
    named = _named_unit(name)
    if named is not None:
        return named
    units = (
        str(entries[names[plain]]).strip().lower() for plain in _DISTANCE_UNIT if plain in names
    )
    return next((_UNITS_M[unit] for unit in units if unit in _UNITS_M), None)


def _named_unit(name: str) -> float | None:
    """Return the metres in the unit at the end of a name, as in "Focus (ft)"; None without one."""
    match = _UNIT_AT_END.search(re.sub(r"(?<=[a-z])(?=[A-Z])", " ", name).lower())
    return None if match is None else _UNITS_M.get(match[1] or match[2])
