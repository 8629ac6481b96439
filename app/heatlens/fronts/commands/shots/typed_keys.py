"""Keys of the lens as they are typed: `focus@1001=0.94:linear`, `f-stop@1010=2.8`."""

import re

from heatlens.core.base.errors import InputError
from heatlens.core.model.curves.curve import Key
from heatlens.core.model.curves.interpolation import Interpolation
from heatlens.core.model.option import suggest_similar
from heatlens.core.model.shot.lens_parameter import LensParameter
from heatlens.core.model.units import parse_distance_m

PARAMETER_BY_NAME = {parameter.typed: parameter for parameter in LensParameter}
_KEY = re.compile(r"([^@=]+)@([^@=]+)=([^:]+)(?::(.*))?")

Keys = dict[LensParameter, list[Key]]


def parse_keys(texts: list[str]) -> Keys:
    """Parse keys into a list for each parameter. Raises InputError for an invalid key."""
    keys: Keys = {}
    for text in texts:
        match = _KEY.fullmatch(text)
        if match is None or match[1] not in PARAMETER_BY_NAME:
            raise _key_error(text, _key_hint(text))
        parameter = PARAMETER_BY_NAME[match[1]]
        keys.setdefault(parameter, []).append(_make_key(text, parameter, match))
    return {
        name: sorted(parameter_keys, key=lambda key: key.frame)
        for name, parameter_keys in keys.items()
    }


def _make_key(text: str, parameter: LensParameter, match: re.Match[str]) -> Key:
    """Return the key from the parts of its text. Raises InputError for invalid parts."""
    _, frame, value, path = match.groups()
    is_focus = parameter is LensParameter.FOCUS_DISTANCE
    try:
        return Key(
            frame=float(frame),
            value=parse_distance_m(value) if is_focus else float(value),
            interpolation=Interpolation.SMOOTH if path is None else Interpolation(path),
        )
    except ValueError:
        raise _key_error(text) from None


def _key_hint(text: str) -> str:
    """Return a hint on a key without a frame, or with a misspelled parameter; else ""."""
    name, sign, value = text.partition("=")
    if sign and name in PARAMETER_BY_NAME:
        return f" The frame is missing, as in {name}@1001={value}."
    return suggest_similar(name.partition("@")[0], PARAMETER_BY_NAME)


def _key_error(text: str, hint: str = "") -> InputError:
    """Return the error for a text that is no key, with how one is written."""
    return InputError(
        f"--key takes PARAMETER@FRAME=VALUE, such as focus@1001=6'3\" or f-stop@1010=2.8:linear; "
        f"parameters are {', '.join(PARAMETER_BY_NAME)}; paths are {', '.join(Interpolation)}; "
        f"got {text!r}.{hint}"
    )
