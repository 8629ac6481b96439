"""`heatlens export`: render a shot to EXR frames, pictures or a movie; runs can be resumed.

With `--submit` the export is written as a job for a render farm instead.
"""

import argparse
import json
import subprocess
from collections.abc import Callable, Iterable, Iterator
from contextlib import ExitStack, closing, contextmanager
from pathlib import Path

from heatlens.core.base.errors import InputError
from heatlens.core.model.shot.lens_parameter import LensParameter
from heatlens.core.model.shot.shot import Shot
from heatlens.core.model.view.guides import Guides
from heatlens.deliver.export.job import read_job
from heatlens.deliver.export.movie_sound import find_sound
from heatlens.deliver.export.plan import ExportPlan, plan_export
from heatlens.deliver.export.run import FrameDone, export_frames
from heatlens.deliver.farm.cluster import ClusterMaker, PartTask, topic_of
from heatlens.deliver.farm.connection import check_for_scheduler, connected
from heatlens.deliver.farm.elsewhere import Make, export_elsewhere
from heatlens.deliver.farm.job import command_words
from heatlens.deliver.farm.processes import ProcessMaker
from heatlens.fronts.commands.export_options import (
    add_export_options,
    frames_of_part,
    make_export_job,
)
from heatlens.fronts.commands.options.device_option import use_device
from heatlens.fronts.commands.options.display_options import print_view_transform
from heatlens.fronts.commands.options.farm_options import make_renderer_function
from heatlens.fronts.commands.options.field_options import fill_fields
from heatlens.fronts.commands.options.reel_options import add_reel_options, refuse_reel_options
from heatlens.fronts.commands.output.export_progress import progress_of, report_failure
from heatlens.fronts.commands.output.plate_words import (
    first_plate,
    overscan_of_shot,
    print_shot_doubts,
    shot_timecodes,
)
from heatlens.fronts.commands.output.say import print_messages
from heatlens.fronts.commands.reel_export import ReelActions, ShotToExport, export_reel
from heatlens.fronts.commands.submit import SubmittedShot, submit, task_words
from heatlens.fronts.commands.worker import make_part
from heatlens.media.camera.ring_samples import sample_of_shot
from heatlens.media.documents.reel_file import is_reel
from heatlens.media.documents.shot_file import is_shot_file
from heatlens.media.files.picture_formats import words_written
from heatlens.media.live.ring.address import opentrackio_address
from heatlens.media.live.ring.sender import SOURCE, LensOutput, LensSender
from heatlens.render.frame_renderer import headless_renderer
from heatlens.version import __version__

DESCRIPTION = """\
Renders the frames of a shot: EXR scene-linear with the lens of each frame in its header, PNG,
JPEG or TIFF through a view transform, or a movie. If you run it again after a stop or a change, it
renders only the frames that are missing or out of date.
"""
EPILOG = """\
examples:
  heatlens export shot.heatlens.json -o out/name.####.exr --quality film
  heatlens export shot.heatlens.json -o out/name.####.exr --frames 1001-1100x2 --with-depth
  heatlens export shot.heatlens.json -o look.mov --view 'ACES 2.0 - SDR 100 nits (Rec.709)' \\
      --burn-in --proxy 0.5
  heatlens export 'plate.####.exr' -o out/####.png --f-stop 2 --focus-distance 2.24
  heatlens export demo -o out/####.png --frames 1-10 --size 320x180
  heatlens export scene.glb -o pinhole.####.exr --frames 1-48 --pinhole
  heatlens export shot.heatlens.json -o out/name.####.exr --submit openjd --chunk 5 > job.yaml
  heatlens export cut.otio -o 'out/{shot}/{shot}.####.exr' --f-stop 2 --handles 8
"""
# Options that need one of several others, and options that exclude each other.
_REQUIRED_OPTIONS = {
    **dict.fromkeys(("memory", "cpus", "gpus", "bundle"), ("submit",)),
    "chunk": ("submit", "cluster"),
    "fetch": ("cluster",),
}
_FETCH_ADVICE = (
    " The workers may have written to disks of their own: --fetch brings the files to this machine."
)
_EXCLUSIVE_OPTIONS = ("submit", "cluster", "processes", "part")


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "shot",
        metavar="SHOT",
        help="shot file, plate.####.exr with a constant lens, a 3D scene, or demo; or a reel or an "
        "edit (.otio, .edl, .xml, .aaf), of which every shot is exported",
    )
    parser.add_argument(
        "-o",
        "--output",
        required=True,
        metavar="FILES",
        help=f"out/name.####.exr; as displayed: {words_written()}; or a movie: .mov (ProRes), "
        ".mp4 (H.264). For a reel, {shot} is a shot's name; without it a movie is the cut",
    )
    add_export_options(parser)
    add_reel_options(parser)
    add_send_option(parser)
    parser.add_argument(
        "--after-export",
        metavar="COMMAND",
        help="run this shell command when all frames of a shot are written, with a line of JSON on "
        "its standard input: shot, files, frames, lens (a value for each frame) and timecode. If "
        "it fails, the export fails",
    )
    parser.add_argument(
        "--job",
        type=Path,
        metavar="FILE",
        help="options as JSON, as the window passes them; options on the command line take "
        "precedence",
    )


def run(args: argparse.Namespace) -> int:
    """Export the frames; print progress, and a summary or the reason of a failure at the end."""
    with report_failure(args.progress):
        for record in () if args.job is None else read_job(args.job):
            fill_fields(args, record)
            if isinstance(record, Guides):
                args.canvases = record.canvases
        _export(args)
    return 0


def _export(args: argparse.Namespace) -> None:
    """Export a shot or a reel, or submit it as a job. Raises InputError."""
    _check_combinations(args)
    use_device(args)
    if args.send is not None and args.submit is not None:
        raise InputError("--send is for frames that are rendered here; --submit renders none.")
    if is_reel(args.shot):

        def submit_all(shots: Iterable[ShotToExport]) -> None:
            submit(args, [SubmittedShot(*it) for it in shots])

        export_reel(args, ReelActions(_print_notes, _export_shot, submit_all, _open_frames))
        return
    refuse_reel_options(args)
    job = make_export_job(args)
    plan = plan_export(job, frames_of_part(args, job))
    if args.submit is not None:
        submit(args, [SubmittedShot(args, plan)])
        return
    _print_notes(args, plan)
    _export_shot(args, plan, job.options.shot_name or _shot_name(args))


def _shot_name(args: argparse.Namespace) -> str:
    """Return the name of a shot outside a reel: that of its file without suffixes."""
    return Path(args.shot).name.split(".")[0]


def _print_notes(args: argparse.Namespace, plan: ExportPlan) -> None:
    """Print the notes on a shot, its sound and its view transform before its frames are made."""
    if is_shot_file(args.shot):
        _print_shot_notes(plan)
    if plan.makes_movie:
        print_messages(*filter(None, find_sound(plan, plan.job.shot.frames_per_second)[1:]))
    if not plan.job.output.is_exr:
        print_view_transform(plan.job.display_settings.transform)


def _export_shot(args: argparse.Namespace, plan: ExportPlan, name: str) -> None:
    """Make the frames of a shot; report and send each one, then run the command of the user."""
    with (
        open_lens_sender(args.send, plan.job.shot, min(plan.job.frames)) as send,
        progress_of(args.progress, plan) as report_frame,
        _open_frames(args, plan) as steps,
    ):
        for done in steps:
            report_frame(done)
            send(done.frame)
    if args.after_export is not None:
        run_command_after_export(args.after_export, plan, name)


@contextmanager
def _open_frames(args: argparse.Namespace, plan: ExportPlan) -> Iterator[Iterator[FrameDone]]:
    """Yield an iterator over the finished frames, made by this process or by others."""
    if args.cluster is None and args.processes is None:
        with closing(export_frames(plan, make_renderer_function(args, plan))) as steps:
            yield steps
        return
    words = tuple(command_words(task_words(args, plan)))
    with ExitStack() as stack:
        make: Make = ProcessMaker(words, args.processes or 1, print_messages, args.device)
        advice = ""
        if args.cluster is not None:
            task = PartTask(words, "", __version__, args.fetch, topic_of(plan, args.fetch))
            client = stack.enter_context(connected(args.cluster, check_for_scheduler(args.agreed)))
            strict = plan.job.shot.plate_options.strict
            make = ClusterMaker(client, make_part, task, args.chunk, print_messages, strict)
            stack.callback(make.unpublish)
            advice = "" if args.fetch else _FETCH_ADVICE
        steps = export_elsewhere(plan, make, headless_renderer, advice)
        yield stack.enter_context(closing(steps))


def _check_combinations(args: argparse.Namespace) -> None:
    """Refuse options that need another one, and options that exclude each other."""
    for name, required_names in _REQUIRED_OPTIONS.items():
        if getattr(args, name) and all(
            getattr(args, required_name) is None for required_name in required_names
        ):
            raise InputError(f"--{name} needs --{' or --'.join(required_names)}.")
    exclusive_names = [
        f"--{option_name}"
        for option_name in _EXCLUSIVE_OPTIONS
        if getattr(args, option_name) is not None
    ]
    if len(exclusive_names) > 1:
        raise InputError(f"{' and '.join(exclusive_names)} cannot go together: give one of them.")
    if args.processes is not None and args.processes < 1:
        raise InputError(f"--processes must be 1 or more, got {args.processes}.")


def _print_shot_notes(plan: ExportPlan) -> None:
    """Print doubts about the lens, and warn if the plates have too little overscan."""
    shot = plan.job.shot
    plate = first_plate(shot)
    print_shot_doubts(shot, plate)
    need = overscan_of_shot(shot, plate, plan.job.frames)
    if need is not None and need.short:
        print_messages(need.sentence)


def add_send_option(parser: argparse.ArgumentParser) -> None:
    """Add `--send` to the options of an export."""
    parser.add_argument_group("sending live").add_argument(
        "--send",
        metavar="PROTOCOL[://HOST:PORT]",
        help="send the lens of each finished frame to an engine or another heatlens: "
        "opentrackio for this machine, or opentrackio://HOST:PORT. `heatlens camera --send` plays "
        "it in real time",
    )


@contextmanager
def open_lens_sender(
    address: str | None, shot: Shot, first: int
) -> Iterator[Callable[[int], None]]:
    """Yield a function that sends the lens of a frame; it does nothing if `address` is None.

    `first` is the first of the frames.

    If the network refuses the lens, the export reports this and goes on. Raises InputError for
    an invalid address.
    """
    if address is None:
        yield lambda frame: None
        return
    with LensSender(opentrackio_address(address)) as sender:
        output, timecode_at = LensOutput(sender, print_messages), shot_timecodes(shot, first)

        def send(frame: int) -> None:
            output.send(sample_of_shot(SOURCE, shot, frame, timecode_at(frame)))

        yield send


_STDERR = 2  # the descriptor


def run_command_after_export(command: str, plan: ExportPlan, name: str) -> None:
    """Run `command` by the shell, with a line of JSON on its standard input.

    Its standard output goes to standard error. Raises InputError if the command fails.
    """
    facts_line = f"{json.dumps(_command_facts(plan, name))}\n"
    process = subprocess.run(command, shell=True, input=facts_line, text=True, stdout=_STDERR)
    if process.returncode:
        raise InputError(
            f"--after-export: the frames of {name} are written, but {command!r} ended with exit "
            f"code {process.returncode}."
        )


def _command_facts(plan: ExportPlan, name: str) -> dict[str, object]:
    """Return the facts for the command's standard input; the lens has a value for each frame."""
    frames = plan.frames
    lens = {str(name): [getattr(it.lens, name) for it in frames] for name in LensParameter}
    timecode = shot_timecodes(plan.job.shot, frames[0].frame)(frames[0].frame)
    files = dict.fromkeys(str(frame.path.absolute()) for frame in frames)
    return {
        "shot": name,
        "files": list(files),
        "frames": [frame.frame for frame in frames],
        "lens": lens,
        "timecode": None if timecode is None else str(timecode),
    }
