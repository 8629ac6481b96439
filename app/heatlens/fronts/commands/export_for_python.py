"""Plan the export that words of a command line describe; `Source.export` of Python calls this."""

import io
from collections.abc import Sequence
from contextlib import redirect_stderr

from heatlens.core.base.errors import InputError
from heatlens.deliver.export.plan import ExportPlan, plan_export
from heatlens.fronts.commands.command_parser import build_parser
from heatlens.fronts.commands.export_options import make_export_job
from heatlens.fronts.commands.options.one_of_many import frame_in_sequence


def plan_of_words(words: Sequence[str]) -> ExportPlan:
    """Return the plan of an export. Raises InputError for words that the command refuses.

    In Python the name of one frame stands for that frame alone, as `heatlens.open` reads it.
    """
    with io.StringIO() as text, redirect_stderr(text):
        try:
            args = build_parser(("export",)).parse_args(["export", *words])
        except SystemExit:
            message = text.getvalue().partition("\n")[0].removeprefix("heatlens: ")
            raise InputError(message) from None
    if args.frames is None and (found := frame_in_sequence(args.shot)) is not None:
        args.frames = str(found[0])
    return plan_export(make_export_job(args))
