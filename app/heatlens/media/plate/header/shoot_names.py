"""Read lens metadata of cameras on set, from the headers of EXR files and from tables.

The known names are those of ARRI (Meta Extract, and `com.arri.camera.` in headers), of Cooke /i and
Zeiss eXtended Data as cameras pass them on, of RED and of Sony. Names are compared without path,
unit, case and punctuation, so that "Lens Focus Distance", "lens_focus_distance_m" and
"com.arri.camera.LensFocusDistance" are the same.

Distances, irises and squeezes are read as cameras write them.
"""

import math
import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field

from heatlens.core.base.errors import InputError
from heatlens.core.base.outside_text import join_first_names
from heatlens.core.model.units import FOOT_M, INCH_M, is_bare_number, parse_distance_m, with_points

_FOCUS = ("lensfocusdistance", "focusdistance", "focusdist", "lensdistance", "focus")
_LENGTH = ("lensfocallength", "focallength", "lenszoom", "zoom", "length")
_F_STOP = ("lensfstop", "fstop", "fnumber", "lensfnumber")
_T_STOP = (
    *("lenststop", "tstop", "tnumber", "lensiris", "iris", "lensaperture", "aperture"),
    *("aperturevalue", "lenststopnumber", "iriststop"),
)
_LINEAR_IRIS = ("lenslineariris",)  # ARRI: thousandths of a stop, 1000 is T1
_SQUEEZE = ("lenssqueeze", "lenssqueezefactor", "anamorphicsqueeze", "squeeze")
_UNDERSTOOD = "Focus Distance, Focal Length, F-Stop, T-Stop, Iris, Squeeze"
_LENS_WORDS = re.compile(r"lens|foc|fok|iris|stop|apert|blend|zoom|brenn|dist", re.IGNORECASE)
_FAR_FROM = 1000.0  # all larger values count as equal
_ROUNDING = 0.05  # relative difference: two columns may round the same value differently
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
_MISSING = ("", "-", "--", "n.a.", "n/a", "na", "nan", "none", "null", "unknown", "invalid")
_NUMBER = r"[0-9]+(?:\.[0-9]+)?"
_STOP_AND_TENTHS = re.compile(rf"[tf]?/?\s*({_NUMBER})\s*\+\s*([0-9])/10")  # 1.4 + 7/10
_STOPS_FROM_ONE = re.compile(r"[tf]\s+([0-9]{1,2})(?:\s+([0-9])/10)?")  # T 2 3/10
_MILLIMETRE_M = 1e-3
_LEAST, _MOST = 1e-6, 1e6  # limits in any unit; no lens has a length or a focus beyond them


@dataclass(frozen=True)
class ShootLens:
    """The values of a lens in the metadata of one frame; None for missing ones.

    sources     field -> the name of the entry that gave it
    has_unit    False if the distance had no unit and meters were assumed
    unreadable  field -> the name of an entry whose value cannot be read, where no other gave one
    conflicts   field -> the name of an entry with a value other than the one used
    """

    focus_distance_m: float | None = None
    focal_length_mm: float | None = None
    f_stop: float | None = None
    t_stop: float | None = None
    squeeze: float | None = None
    sources: Mapping[str, str] = field(default_factory=dict)
    has_unit: bool = True
    unreadable: Mapping[str, str] = field(default_factory=dict)
    conflicts: Mapping[str, str] = field(default_factory=dict)


def read_shoot_lens(
    entries: Mapping[str, object], unit_m: float | None = None, user_unit_m: float | None = None
) -> ShootLens:
    """Return the lens values in the entries of a header or the cells of a table row.

    `unit_m` is the length in meters of the unit of distances, for metadata that does not name one,
    and `user_unit_m` that of the unit that the user chose. A unit written with a value takes
    precedence over `user_unit_m`, and that over the unit in a name. Zero, which cameras write for
    unknown values, counts as missing. Impossible values count as unreadable.
    """
    lens_entries = _Entries(entries, unit_m, user_unit_m)
    values: dict[str, float] = {}
    sources: dict[str, str] = {}
    unreadable: dict[str, str] = {}
    conflicts: dict[str, str] = {}
    for target, name, value in lens_entries.read_values():
        if value is None:
            unreadable.setdefault(target, name)
        elif target not in values:
            values[target], sources[target] = value, name
        elif not _are_roundings_of_one(values[target], value):
            conflicts.setdefault(target, name)
    focus = sources.get("focus_distance_m")
    return ShootLens(
        **values,
        sources=sources,
        has_unit=focus is None or lens_entries.unit_of(focus) is not None,
        unreadable={target: name for target, name in unreadable.items() if target not in values},
        conflicts=conflicts,
    )


class _Entries:
    """Entries of a header or a table row, and the units of their distances (`read_shoot_lens`)."""

    def __init__(
        self, entries: Mapping[str, object], unit_m: float | None, user_unit_m: float | None
    ) -> None:
        self._entries, self._unit_m, self._user_unit_m = entries, unit_m, user_unit_m
        self._names = {_normalize_name(name): name for name in entries}

    def read_values(self) -> Iterator[tuple[str, str, float | None]]:
        """Yield (field, entry name, value) of each known entry; value is None if unreadable."""
        readers: tuple[tuple[str, tuple[str, ...], Callable[[str], float | None]], ...] = (
            ("focus_distance_m", _FOCUS, self._read_metres),
            ("focal_length_mm", _LENGTH, self._read_millimetres),
            ("f_stop", _F_STOP, lambda name: parse_stop(self._entries[name])),
            ("t_stop", _LINEAR_IRIS, lambda name: parse_linear_iris(self._entries[name])),
            ("t_stop", _T_STOP, lambda name: parse_stop(self._entries[name])),
            ("squeeze", _SQUEEZE, lambda name: parse_squeeze(self._entries[name])),
        )
        for target, known_names, read_value in readers:
            for name in (
                self._names[normalized] for normalized in known_names if normalized in self._names
            ):
                if not is_missing(self._entries[name]):
                    yield target, name, read_value(name)

    def unit_of(self, name: str) -> float | None:
        """Return the length in meters of the unit of distance `name`; None if it is unknown."""
        length = parse_distance(self._entries[name])
        written_unit_m = None if length is None else length.unit_m
        return written_unit_m or self._user_unit_m or self._named_unit_of(name) or self._unit_m

    def _named_unit_of(self, name: str) -> float | None:
        """Return the length in meters of the unit that the name, or an entry for all, states."""
        unit_in_name_m = _named_unit(name)
        if unit_in_name_m is not None:
            return unit_in_name_m
        names = (
            self._names[normalized] for normalized in _DISTANCE_UNIT if normalized in self._names
        )
        units = (str(self._entries[name]).strip().lower() for name in names)
        return next((_UNITS_M[unit] for unit in units if unit in _UNITS_M), None)

    def _read_metres(self, name: str) -> float | None:
        length = parse_distance(self._entries[name])
        return None if length is None else length.in_metres(self.unit_of(name) or 1.0)

    def _read_millimetres(self, name: str) -> float | None:
        length = parse_focal_length(self._entries[name])
        return None if length is None else length.in_millimetres(_named_unit(name))


def unknown_columns_sentence(columns: Iterable[str]) -> str:
    """Return a sentence on columns that contain no known lens value; "" if all do."""
    known_names = {*_FOCUS, *_LENGTH, *_F_STOP, *_T_STOP, *_LINEAR_IRIS, *_SQUEEZE, *_DISTANCE_UNIT}
    unknown_names = [name for name in columns if _normalize_name(name) not in known_names]
    if not unknown_names:
        return ""
    unknown_names.sort(key=lambda name: not _LENS_WORDS.search(name))
    return (
        f"Not understood of its columns: {join_first_names([*map(repr, unknown_names)])}; "
        f"understood are names such as {_UNDERSTOOD}."
    )


def _are_roundings_of_one(first: float, second: float) -> bool:
    """Return whether two numbers may be roundings of one value; all above 1000 count as equal."""
    return math.isclose(min(first, _FAR_FROM), min(second, _FAR_FROM), rel_tol=_ROUNDING)


def is_shoot_entry(name: str) -> bool:
    """Return True for a header entry of a camera on set, False for one of a CG renderer."""
    normalized = _normalize_name(name)
    return normalized.startswith("lens") or bool(_VENDOR.search(name))


def _normalize_name(name: str) -> str:
    """Return the last component of a name, without unit, as lower-case letters and digits."""
    last_component = re.split(r"[/:]|\.(?=[A-Za-z])", name.strip())[-1]
    words = re.sub(r"(?<=[a-z])(?=[A-Z])", " ", last_component).lower()
    return re.sub(r"[^a-z0-9]", "", _UNIT_AT_END.sub(_drop_unit, words))


def _drop_unit(match: re.Match[str]) -> str:
    """Return "" for a match that is a unit of length, and the match itself otherwise."""
    unit = match[1] or match[2]
    return "" if unit in _UNITS_M else match[0]


def _named_unit(name: str) -> float | None:
    """Return the length in meters of the unit that ends a name, as in "Focus (ft)"; else None."""
    match = _UNIT_AT_END.search(re.sub(r"(?<=[a-z])(?=[A-Z])", " ", name).lower())
    return None if match is None else _UNITS_M.get(match[1] or match[2])


@dataclass(frozen=True)
class Length:
    """A length above zero as it was written.

    `unit_m` is 1.0 if the text had a unit, and `value` is then in meters. It is None for a number
    without a unit, whose unit is unknown.
    """

    value: float
    unit_m: float | None

    def in_metres(self, bare_m: float) -> float:
        """Return meters; `bare_m` is the length in meters of the unit of a number without one."""
        return self.value * (bare_m if self.unit_m is None else 1.0)

    def in_millimetres(self, bare_m: float | None) -> float:
        """Return millimeters; `bare_m` is as in `in_metres`, and None stands for millimeters."""
        if self.unit_m is None and bare_m in (None, _MILLIMETRE_M):
            return self.value
        return self.in_metres(bare_m or 1.0) / _MILLIMETRE_M


def is_missing(value: object) -> bool:
    """Return True for an empty value, a word for a missing one, NaN, and zero."""
    if isinstance(value, int | float):
        return isinstance(value, bool) or value == 0 or math.isnan(value)
    text = str(value).strip().lower()
    return text in _MISSING or _parse_number(text) == 0


def parse_distance(value: object) -> Length | None:
    """Return a distance, which may be infinite but not zero; None if it cannot be read."""
    if isinstance(value, int | float):
        return Length(float(value), unit_m=None) if value >= _LEAST else None
    text = str(value)
    try:
        distance_m = parse_distance_m(text)
    except InputError:
        return None
    if distance_m < _LEAST:
        return None
    # A text with a unit has been converted to meters; a bare number has no unit.
    return Length(distance_m, unit_m=None if is_bare_number(text) else 1.0)


def parse_focal_length(value: object) -> Length | None:
    """Return a finite length above zero; None if it cannot be read."""
    length = parse_distance(value)
    return None if length is None or length.value > _MOST else length


def parse_squeeze(value: object) -> float | None:
    """Return the squeeze of an anamorphic lens, 1 to 2, as in 1.8 or "2x"; None for others."""
    number = _parse_number(str(value).strip().lower().removesuffix("x"))
    return number if number is not None and 1.0 <= number <= 2.0 else None


def parse_linear_iris(value: object) -> float | None:
    """Return the T-number of thousandths of a stop, of which 1000 are T1; None for others."""
    thousandths = _parse_number(value)
    if thousandths is None or not 0 < thousandths < 20_000:
        return None
    return float(2.0 ** ((thousandths - 1000.0) / 2000.0))


def parse_stop(value: object) -> float | None:
    """Return the f- or T-number of a number, "T2.8", ARRI's "1.4 + 7/10" or Sony's "T 2 3/10".

    None for any other text, and for impossible numbers.
    """
    text = with_points(str(value).strip().lower())
    number: float | None = None
    if match := _STOP_AND_TENTHS.fullmatch(text):
        number = float(match[1]) * 2.0 ** (int(match[2]) / 20.0)
    elif match := _STOPS_FROM_ONE.fullmatch(text):
        number = float(2.0 ** ((int(match[1]) + int(match[2] or 0) / 10.0) / 2.0))
    else:
        number = _parse_number(text.removeprefix("t").removeprefix("f").removeprefix("/"))
    return number if number is not None and 0.3 <= number <= 128.0 else None


def _parse_number(value: object) -> float | None:
    """Return a finite number; None for anything else."""
    text = with_points(str(value).strip().lower())
    if not is_bare_number(text):
        return None
    number = float(text)
    return number if math.isfinite(number) else None
