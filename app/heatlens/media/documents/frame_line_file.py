"""Read the lines of an ASC framing decision list (FDL), by the library of the ASC."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any, Protocol

from heatlens.core.base.errors import InputError
from heatlens.core.base.extras import import_extra
from heatlens.core.base.outside_text import one_line
from heatlens.core.base.paths import file_bytes, unreadable
from heatlens.core.model.view.guides import Canvas, FrameLine, Part
from heatlens.media.files.apart import called_apart
from heatlens.media.files.limits import allow_for, is_bounded

FDL_SUFFIX = ".fdl"
_BYTES_MOST = 16_000_000


def read_canvases(path: Path) -> tuple[Canvas, ...]:
    """Return the canvases of a file with their lines.

    A canvas of which only a part is used, and one that is squeezed, is there in each of its shapes.
    Raises InputError if the file cannot be read, or has no line.
    """
    if is_bounded():
        return _bounded(path)
    return called_apart(_bounded, path, str(path))


def _bounded(path: Path) -> tuple[Canvas, ...]:
    allow_for(path)
    fdl = import_extra("fdl", "Reading framing decisions")
    try:
        data = file_bytes(path)
        if len(data) > _BYTES_MOST:
            raise ValueError(f"it has more than {_BYTES_MOST // 1_000_000} MB")
        with fdl.read_from_string(data.decode("utf-8")) as decisions:
            canvases = [it for context in decisions.contexts for it in context.canvases]
            shapes = tuple(shape for canvas in canvases for shape in _shapes(canvas))
    except OSError as error:
        raise unreadable(path, error) from error
    except (ValueError, TypeError, fdl.FDLError) as error:
        reason = one_line(error)
        raise InputError(f"{path} is not a framing decision list (ASC FDL): {reason}") from error
    if not shapes:
        raise InputError(f"{path} has no framing decision.")
    return shapes


class _Rect(Protocol):
    x: float
    y: float
    width: float
    height: float


def _shapes(canvas: Any) -> Iterator[Canvas]:
    """Yield a canvas as it is and desqueezed, then the same for the part of it that is used."""
    decisions = list(canvas.framing_decisions)
    for area in filter(None, (canvas.get_rect(), canvas.get_effective_rect())):
        lines = tuple(_line(decision, area) for decision in decisions)
        for squeeze in dict.fromkeys((1.0, canvas.anamorphic_squeeze)) if lines else ():
            yield Canvas(area.width * squeeze, area.height, lines)


def _line(decision: Any, area: _Rect) -> FrameLine:
    protection = decision.get_protection_rect()
    inner = None if protection is None else _part(protection, area)
    return FrameLine(decision.label or decision.id, _part(decision.get_rect(), area), inner)


def _part(rect: _Rect, area: _Rect) -> Part:
    x, y = (rect.x - area.x) / area.width, (rect.y - area.y) / area.height
    return x, y, x + rect.width / area.width, y + rect.height / area.height
