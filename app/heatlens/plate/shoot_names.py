"""Read lens metadata of cameras on set, from the headers of EXR files and from tables.

The known names are those of ARRI (Meta Extract, and `com.arri.camera.` in headers), of Cooke /i and
Zeiss eXtended Data as cameras pass them on, of RED and of Sony. Names are compared without path,
unit, case and punctuation, so that "Lens Focus Distance", "lens_focus_distance_m" and
"com.arri.camera.LensFocusDistance" are the same.
"""

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from heatlens.model.units import FOOT_M, INCH_M

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
_UNIT_AT_END = re.compile(r"(?:\(\s*([a-z]+)\s*\)|[_ ]([a-z]{1,2}))\s*$")
_VENDOR = re.compile(r"arri|cooke|zeiss|sony|red\b", re.IGNORECASE)
_NUMBER = r"[0-9]+(?:\.[0-9]+)?"
_STOP_AND_TENTHS = re.compile(rf"[tf]?/?\s*({_NUMBER})\s*\+\s*([0-9])/10")  # 1.4 + 7/10
_STOPS_FROM_ONE = re.compile(r"[tf]\s+([0-9]{1,2})(?:\s+([0-9])/10)?")  # T 2 3/10
_MISSING = ("", "-", "--", "n.a.", "n/a", "none", "unknown")


@dataclass(frozen=True)
class ShootLens:
    """The values of a lens in the metadata of one frame; None for missing ones.

    sources       field -> the name of the entry that gave it
    has_unit  False if the distance had no unit and metres were assumed
    """

    focus_distance_m: float | None = None
    focal_length_mm: float | None = None
    f_stop: float | None = None
    t_stop: float | None = None
    squeeze: float | None = None
    sources: Mapping[str, str] = field(default_factory=dict)
    has_unit: bool = True


def shoot_lens(entries: Mapping[str, Any], unit_m: float | None = None) -> ShootLens:
    """Return the lens values in the entries of a header or the cells of a table row.

    `unit_m` is the length in metres of the unit of distances, for metadata that does not name one.
    Impossible values count as missing.
    """
    names = {_plain(name): name for name in entries}
    values: dict[str, float] = {}
    sources: dict[str, str] = {}

    def take(target: str, known: tuple[str, ...], parse: Any) -> str | None:
        for plain in known:
            name = names.get(plain)
            value = None if name is None else parse(entries[name])
            if name is not None and value is not None and 0 < value:
                values[target], sources[target] = value, name
                return name
        return None

    focus = take("focus_distance_m", _FOCUS, _number)
    take("focal_length_mm", _LENGTH, _finite)
    take("f_stop", _F_STOP, _stop)
    take("t_stop", _LINEAR_IRIS, _linear_iris) or take("t_stop", _T_STOP, _stop)
    take("squeeze", _SQUEEZE, _squeeze)
    known_m = unit_m if focus is None else _unit_of(focus, names, entries) or unit_m
    if focus is not None:
        values["focus_distance_m"] *= known_m or 1.0
    return ShootLens(**values, sources=sources, has_unit=focus is None or known_m is not None)


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
    match = _UNIT_AT_END.search(re.sub(r"(?<=[a-z])(?=[A-Z])", " ", name).lower())
    unit = None if match is None else match[1] or match[2]
    if unit in _UNITS_M:
        return _UNITS_M[unit]
    units = (
        str(entries[names[plain]]).strip().lower() for plain in _DISTANCE_UNIT if plain in names
    )
    return next((_UNITS_M[unit] for unit in units if unit in _UNITS_M), None)


def _number(value: Any) -> float | None:
    """Return a number, which may be infinite; None for anything else."""
    if isinstance(value, bool):
        return None
    if isinstance(value, int | float):
        return None if math.isnan(value) else float(value)
    text = str(value).strip().lower()
    if text in ("inf", "infinity", "∞"):
        return math.inf
    match = re.fullmatch(rf"({_NUMBER})\s*[a-z]*", text)
    return float(match[1]) if match else None


def _finite(value: Any) -> float | None:
    number = _number(value)
    return None if number is None or math.isinf(number) else number


def _squeeze(value: Any) -> float | None:
    number = _finite(value)
    return number if number is not None and 1.0 <= number <= 2.0 else None


def _linear_iris(value: Any) -> float | None:
    thousandths = _finite(value)
    if thousandths is None or not 0 < thousandths < 20_000:
        return None
    return float(2.0 ** ((thousandths - 1000.0) / 2000.0))


def _stop(value: Any) -> float | None:
    """Return the f- or T-number of a number, "T2.8", ARRI's "1.4 + 7/10" or Sony's "T 2 3/10"."""
    text = str(value).strip().lower()
    stop: float | None = None
    if match := _STOP_AND_TENTHS.fullmatch(text):
        stop = float(match[1]) * 2.0 ** (int(match[2]) / 20.0)
    elif match := _STOPS_FROM_ONE.fullmatch(text):
        stop = float(2.0 ** ((int(match[1]) + int(match[2] or 0) / 10.0) / 2.0))
    elif text not in _MISSING:
        stop = _finite(text.removeprefix("t").removeprefix("f").removeprefix("/"))
    return stop if stop is not None and 0.3 <= stop <= 128.0 else None
