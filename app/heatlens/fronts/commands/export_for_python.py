"""Plan the export that values describe; `Source.export` of Python calls this."""

from collections.abc import Mapping

from heatlens.core.model.lens.aperture import Aperture
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.core.model.shot.settings import DefocusSettings
from heatlens.deliver.export.options import ExportOptions
from heatlens.deliver.export.plan import ExportPlan, plan_export
from heatlens.fronts.commands.command_parser import build_parser
from heatlens.fronts.commands.export_options import make_export_job
from heatlens.fronts.commands.options.field_options import set_fields
from heatlens.fronts.commands.options.one_of_many import frame_in_sequence

_KINDS = (PlateOptions, DefocusSettings, Aperture, Lens, ExportOptions)
_OTHER_OPTIONS = ("scene_camera", "size", "focus_at")  # of no field


def plan_of_values(source: str, output: str, values: Mapping[str, object]) -> ExportPlan:
    """Return the plan of an export. Raises InputError for values that the command refuses.

    In Python the name of one frame stands for that frame alone, as `heatlens.open` reads it.
    """
    args = build_parser(("export",)).parse_args(["export", "source", "--output=file"])
    args.shot, args.output = source, output
    for kind in _KINDS:
        set_fields(args, kind, values)
    for name in _OTHER_OPTIONS:
        setattr(args, name, values.get(name))
    if args.frames is None and (found := frame_in_sequence(args.shot)) is not None:
        args.frames = str(found[0])
    return plan_export(make_export_job(args))
