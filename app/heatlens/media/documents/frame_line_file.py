"""Read the lines of an ASC framing decision list (FDL), by the library of the ASC."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any, Protocol

from heatlens.core.base.errors import InputError
from heatlens.core.base.extras import import_extra
from heatlens.core.base.outside_text import one_line
from heatlens.core.base.paths import read_file_bytes, unreadable_error
from heatlens.core.model.view.guides import Canvas, FrameLine, Part
from heatlens.media.files.apart import call_in_process
from heatlens.media.files.limits import allow_for, is_bounded

FDL_SUFFIX = ".fdl"
_BYTES_MOST = 16_000_000


def read_canvases(path: Path) -> tuple[Canvas, ...]:
    """Return the canvases of a file with their lines.

    A canvas of which only a part is used, or which is squeezed, is returned once for each shape.
    Raises InputError if the file cannot be read, or has no line.
    """
    if is_bounded():
        return _read_bounded(path)
    return call_in_process(_read_bounded, path, str(path))


def _read_bounded(path: Path) -> tuple[Canvas, ...]:
    """Read the canvases in a process with limits of time and memory."""
    allow_for(path)
    fdl = import_extra("fdl", "Reading framing decisions")
    try:
        data = read_file_bytes(path)
        if len(data) > _BYTES_MOST:
            raise ValueError(f"it has more than {_BYTES_MOST // 1_000_000} MB")
        with fdl.read_from_string(data.decode("utf-8")) as decisions:
            canvases = [
                canvas_entry for context in decisions.contexts for canvas_entry in context.canvases
            ]
            shapes = tuple(shape for canvas in canvases for shape in _canvas_shapes(canvas))
    except OSError as error:
        raise unreadable_error(path, error) from error
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


def _canvas_shapes(canvas: Any) -> Iterator[Canvas]:
    """Yield a canvas as it is and desqueezed, then the same for the part of it that is used."""
    decisions = list(canvas.framing_decisions)
    for area in filter(None, (canvas.get_rect(), canvas.get_effective_rect())):
        lines = tuple(_frame_line(decision, area) for decision in decisions)
        for squeeze in dict.fromkeys((1.0, canvas.anamorphic_squeeze)) if lines else ():
            yield Canvas(area.width * squeeze, area.height, lines)


def _frame_line(decision: Any, area: _Rect) -> FrameLine:
    """Return the frame line of a framing decision, relative to `area`."""
    protection = decision.get_protection_rect()
    inner = None if protection is None else _relative_part(protection, area)
    return FrameLine(
        name=decision.label or decision.id,
        frame=_relative_part(decision.get_rect(), area),
        protection=inner,
    )


def _relative_part(rect: _Rect, area: _Rect) -> Part:
    """Return a rectangle as (x0, y0, x1, y1), in shares of the width and height of `area`."""
    x, y = (rect.x - area.x) / area.width, (rect.y - area.y) / area.height
    return x, y, x + rect.width / area.width, y + rect.height / area.height
