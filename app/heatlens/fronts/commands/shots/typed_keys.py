"""Keys of the lens as they are typed: `focus@1001=0.94:linear`, `f-stop@1010=2.8`."""

import re

from heatlens.core.base.errors import InputError
from heatlens.core.model.curves.curve import Key
from heatlens.core.model.curves.interpolation import Interpolation
from heatlens.core.model.option import or_meant
from heatlens.core.model.shot.lens_parameter import LensParameter
from heatlens.core.model.units import parse_distance_m

KEYED = {parameter.typed: parameter for parameter in LensParameter}
_KEY = re.compile(r"([^@=]+)@([^@=]+)=([^:]+)(?::(.*))?")

Keys = dict[LensParameter, list[Key]]


def keys_of(texts: list[str]) -> Keys:
    """Parse keys into a list for each parameter. Raises InputError for an invalid key."""
    keys: Keys = {}
    for text in texts:
        match = _KEY.fullmatch(text)
        if match is None or match[1] not in KEYED:
            raise _no_key(text, _key_hint(text))
        parameter = KEYED[match[1]]
        keys.setdefault(parameter, []).append(_key(text, parameter, match))
    return {name: sorted(typed, key=lambda key: key.frame) for name, typed in keys.items()}


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


def _key_hint(text: str) -> str:
    """Return a sentence on a key without a frame, or with a name like another one; else ""."""
    name, sign, value = text.partition("=")
    if sign and name in KEYED:
        return f" The frame is missing, as in {name}@1001={value}."
    return or_meant(name.partition("@")[0], KEYED)


def _no_key(text: str, hint: str = "") -> InputError:
    return InputError(
        f"--key takes PARAMETER@FRAME=VALUE, such as focus@1001=6'3\" or f-stop@1010=2.8:linear; "
        f"parameters are {', '.join(KEYED)}; paths are {', '.join(Interpolation)}; "
        f"got {text!r}.{hint}"
    )
