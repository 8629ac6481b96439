"""Export a source to files, with the same result as the command `heatlens export`."""

from collections.abc import Callable, Mapping
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from heatlens.core.base.extras import OnUse
from heatlens.core.model.lens.lens import MeasuredFrom
from heatlens.deliver.export.run import export_frames
from heatlens.fronts.api.engine import ENGINE
from heatlens.fronts.api.request import RenderRequest

_plan_of_values = OnUse("fronts.commands.export_for_python", "plan_of_values")


@dataclass(frozen=True)
class ExportedFrame:
    """A frame whose file is complete.

    number     its frame number
    path       its file; all frames of a movie have the same
    was_there  True if an earlier export finished it
    done       how many frames are finished, this one included
    count      how many frames the export has
    """

    number: int
    path: Path
    was_there: bool
    done: int
    count: int


Progress = Callable[[ExportedFrame], object]


def request_values(request: RenderRequest) -> dict[str, Any]:
    """Return the values of the options of the command line for the lens and the blur."""
    focus_at = None if request.focus_at is None else "{},{}".format(*request.focus_at)
    return {**_as_measured(request.lens_fields), **request.blur_fields, "focus_at": focus_at}


def _as_measured(lens_fields: Mapping[str, Any]) -> dict[str, Any]:
    """Return the fields of a lens with its focus measured from where the command line does."""
    fields = dict(lens_fields)
    measured_from = fields.get("measured_from", MeasuredFrom.PUPIL)
    if measured_from is MeasuredFrom.PUPIL:
        fields.pop("pupil_offset_mm", None)  # the command line takes it for a film plane only
    elif "focus_distance_m" in fields:
        fields["focus_distance_m"] += measured_from.offset_m(fields["pupil_offset_mm"])
    return fields


def run_export(
    source: str,
    output: str,
    values: Mapping[str, object],
    progress: Progress | None,
    is_cancelled: Callable[[], bool] | None,
) -> tuple[Path, ...]:
    """Export a source with the options of these values; return the files of finished frames."""
    plan = _plan_of_values(source, output, values)
    paths: dict[Path, None] = {}  # in order, each once: all frames of a movie share one file
    ENGINE.unload_all()  # the export loads its own frames
    with closing(export_frames(plan, ENGINE.renderer)) as steps:
        for done, frame in enumerate(steps, start=1):
            paths[frame.path] = None
            if progress is not None:
                count = len(plan.frames)
                progress(ExportedFrame(frame.frame, frame.path, frame.was_there, done, count))
            if is_cancelled is not None and is_cancelled():
                break
    # the file of a movie is missing if the export was cancelled
    return tuple(path for path in paths if path.exists())
