"""Read the messages of a page: JSON objects of few levels."""

import json

from heatlens.core.base.errors import InputError

MESSAGE_MOST = 4096  # bytes
_DEPTH_MOST = 8  # nested braces and brackets


def parsed(text: str) -> dict[str, object]:
    """Return a message as an object. Raises InputError with a sentence for anything else."""
    try:
        message = json.loads(text, parse_constant=_constant)
    except (ValueError, RecursionError) as error:
        raise InputError("A message should be a JSON object.") from error
    if not isinstance(message, dict) or not _is_shallow(message, _DEPTH_MOST):
        raise InputError(
            f"A message should be a JSON object in braces, of at most {_DEPTH_MOST} levels."
        )
    return message


def _constant(name: str) -> object:
    raise ValueError(f"{name} is not JSON")


def _is_shallow(value: object, left: int) -> bool:
    """Return False if a value has more than `left` levels, its innermost values included."""
    inner = value.values() if isinstance(value, dict) else value if isinstance(value, list) else ()
    return left > 0 and all(_is_shallow(item, left - 1) for item in inner)
