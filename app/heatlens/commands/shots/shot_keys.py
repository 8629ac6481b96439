"""Parse keys and focus marks as typed: `focus@1001=0.94:linear`, `A=6'3"`, `B@960,540`."""

import re

from heatlens.base.errors import InputError
from heatlens.model.curve import Key
from heatlens.model.interpolation import Interpolation
from heatlens.model.marks import DistanceMark, Mark, PointMark
from heatlens.model.other_names import or_meant
from heatlens.model.shot import LensParameter
from heatlens.model.units import parse_distance_m

# Typed name -> the parameter, and the lens option that its first key replaces.
KEYED = {
    "focus": (LensParameter.FOCUS_DISTANCE, "focus_distance"),
    "f-stop": (LensParameter.F_STOP, "f_stop"),
    "focal-length": (LensParameter.FOCAL_LENGTH, "focal_length"),
    "squeeze": (LensParameter.SQUEEZE, "squeeze"),
}
_KEY = re.compile(r"([^@=]+)@([^@=]+)=([^:]+)(?::(.*))?")
_MARK = re.compile(r"([^@=]+)(=|@)(.+)")

Keys = dict[LensParameter, list[Key]]


def keys_of(texts: list[str]) -> Keys:
    """Parse keys into a list for each parameter. Raises InputError for an invalid key."""
    keys: Keys = {}
    for text in texts:
        match = _KEY.fullmatch(text)
        if match is None or match[1] not in KEYED:
            raise _no_key(text, or_meant(text.partition("@")[0], KEYED))
        parameter = KEYED[match[1]][0]
        keys.setdefault(parameter, []).append(_key(text, parameter, match))
    return {name: sorted(found, key=lambda key: key.frame) for name, found in keys.items()}


def _key(text: str, parameter: LensParameter, match: re.Match[str]) -> Key:
    _, frame, value, path = match.groups()
    is_focus = parameter is LensParameter.FOCUS_DISTANCE
    try:
        return Key(
            float(frame),
            parse_distance_m(value) if is_focus else float(value),
            Interpolation.SMOOTH if path is None else Interpolation(path),
        )
    except ValueError:
        raise _no_key(text) from None


def _no_key(text: str, hint: str = "") -> InputError:
    return InputError(
        f"--key takes PARAMETER@FRAME=VALUE, as focus@1001=6'3\" or f-stop@1010=2.8:linear; "
        f"parameters are {', '.join(KEYED)}, paths {', '.join(Interpolation)}; got {text!r}.{hint}"
    )


def mark_of(text: str) -> Mark:
    """Parse a focus mark of --mark. Raises InputError for an invalid one."""
    match = _MARK.fullmatch(text)
    if match is None:
        raise InputError(f"--mark takes NAME=DISTANCE or NAME@X,Y; got {text!r}.")
    name, sign, place = match.groups()
    if sign == "=":
        return DistanceMark(name, parse_distance_m(place))
    try:
        x, y = (float(part) for part in place.split(","))
    except ValueError:
        raise InputError(f"--mark takes a pixel as NAME@X,Y; got {text!r}.") from None
    return PointMark(name, x, y)
