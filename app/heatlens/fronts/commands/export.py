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
from heatlens.deliver.export.movie_sound import heard
from heatlens.deliver.export.plan import ExportPlan, planned
from heatlens.deliver.export.run import FrameDone, export_frames
from heatlens.deliver.farm.cluster import ClusterMaker, PartTask, topic_of
from heatlens.deliver.farm.connection import connected, only
from heatlens.deliver.farm.elsewhere import Make, made_elsewhere
from heatlens.deliver.farm.job import typed
from heatlens.deliver.farm.processes import ProcessMaker
from heatlens.fronts.commands.export_options import add_export_options, job_of, part_of
from heatlens.fronts.commands.options.device_option import use_device
from heatlens.fronts.commands.options.display_options import say_seen_through
from heatlens.fronts.commands.options.farm_options import renderer_of
from heatlens.fronts.commands.options.field_options import fill_fields
from heatlens.fronts.commands.output.export_progress import failure_reported, progress_of
from heatlens.fronts.commands.output.plate_words import (
    first_plate,
    overscan_of_shot,
    say_doubts_of_shot,
    shot_timecodes,
)
from heatlens.fronts.commands.output.say import say
from heatlens.fronts.commands.reel_export import ReelWork, ShotToExport, export_reel
from heatlens.fronts.commands.reel_options import add_reel_options, refuse_reel_options
from heatlens.fronts.commands.submit import SentShot, submit, task_words
from heatlens.fronts.commands.worker import made_part
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
_NEEDED = {
    **dict.fromkeys(("memory", "cpus", "gpus", "bundle"), ("submit",)),
    "chunk": ("submit", "cluster"),
    "fetch": ("cluster",),
}
_ELSEWHERE = (
    " The workers may have written to disks of their own: --fetch brings the files to this machine."
)
_WAYS = ("submit", "cluster", "processes", "part")


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
        help=f"out/name.####.exr; as they look: {words_written()}; or a movie: name.mov (ProRes), "
        "name.mp4 (H.264). All but EXR show the display window. One missing folder is made. Files "
        "of earlier exports are replaced where they are out of date; others need --overwrite. For "
        "a reel, {shot} stands for the name of each shot, and a movie whose name lacks it shows "
        "the whole cut",
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
    with failure_reported(args.progress):
        for record in () if args.job is None else read_job(args.job):
            fill_fields(args, record)
            if isinstance(record, Guides):
                args.canvases = record.canvases
        _export(args)
    return 0


def _export(args: argparse.Namespace) -> None:
    _check_together(args)
    use_device(args)
    if args.send is not None and args.submit is not None:
        raise InputError("--send is for frames that are rendered here; --submit renders none.")
    if is_reel(args.shot):

        def submit_all(shots: Iterable[ShotToExport]) -> None:
            submit(args, [SentShot(*it) for it in shots])

        export_reel(args, ReelWork(_say_before, _export_shot, submit_all, _steps))
        return
    refuse_reel_options(args)
    job = job_of(args)
    plan = planned(job, part_of(args, job))
    if args.submit is not None:
        submit(args, [SentShot(args, plan)])
        return
    _say_before(args, plan)
    _export_shot(args, plan, job.options.shot_name or _name_of(args))


def _name_of(args: argparse.Namespace) -> str:
    """Return what a shot is called that no reel names."""
    return Path(args.shot).name.split(".")[0]


def _say_before(args: argparse.Namespace, plan: ExportPlan) -> None:
    """Print what is to be known of a shot before its frames are made."""
    if is_shot_file(args.shot):
        _say_of_shot(plan)
    if plan.makes_movie:
        say(*filter(None, heard(plan, plan.job.shot.frames_per_second)[1:]))
    if not plan.job.output.is_exr:
        say_seen_through(plan.job.look.transform)


def _export_shot(args: argparse.Namespace, plan: ExportPlan, name: str) -> None:
    """Make the frames."""
    with (
        sending(args.send, plan.job.shot, min(plan.job.frames)) as send,
        progress_of(args.progress, plan) as tell,
        _steps(args, plan) as steps,
    ):
        for done in steps:
            tell(done)
            send(done.frame)
    if args.after_export is not None:
        run_after(args.after_export, plan, name)


@contextmanager
def _steps(args: argparse.Namespace, plan: ExportPlan) -> Iterator[Iterator[FrameDone]]:
    """Yield an iterator over the finished frames, made by this process or by others."""
    if args.cluster is None and args.processes is None:
        with closing(export_frames(plan, renderer_of(args, plan))) as steps:
            yield steps
        return
    words = tuple(typed(task_words(args, plan)))
    with ExitStack() as stack:
        make: Make = ProcessMaker(words, args.processes or 1, say, args.device)
        advice = ""
        if args.cluster is not None:
            task = PartTask(words, "", __version__, args.fetch, topic_of(plan, args.fetch))
            client = stack.enter_context(connected(args.cluster, only(args.agreed)))
            strict = plan.job.shot.plate_options.strict
            make = ClusterMaker(client, made_part, task, args.chunk, say, strict)
            stack.callback(make.forget)
            advice = "" if args.fetch else _ELSEWHERE
        steps = made_elsewhere(plan, make, headless_renderer, advice)
        yield stack.enter_context(closing(steps))


def _check_together(args: argparse.Namespace) -> None:
    """Refuse options that need another one, and options that exclude each other."""
    for name, others in _NEEDED.items():
        if getattr(args, name) and all(getattr(args, other) is None for other in others):
            raise InputError(f"--{name} needs --{' or --'.join(others)}.")
    ways = [f"--{way}" for way in _WAYS if getattr(args, way) is not None]
    if len(ways) > 1:
        raise InputError(f"{' and '.join(ways)} cannot go together: give one of them.")
    if args.processes is not None and args.processes < 1:
        raise InputError(f"--processes must be 1 or more, got {args.processes}.")


def _say_of_shot(plan: ExportPlan) -> None:
    """Print doubts about the lens, and warn if the plates have too little overscan."""
    shot = plan.job.shot
    plate = first_plate(shot)
    say_doubts_of_shot(shot, plate)
    need = overscan_of_shot(shot, plate, plan.job.frames)
    if need is not None and need.short:
        say(need.sentence)


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
def sending(address: str | None, shot: Shot, first: int) -> Iterator[Callable[[int], None]]:
    """Yield a function that sends the lens of a frame; it does nothing if `address` is None.

    `first` is the first of the frames.

    If the network refuses the lens, the export reports this and goes on. Raises InputError for
    an invalid address.
    """
    if address is None:
        yield lambda frame: None
        return
    with LensSender(opentrackio_address(address)) as sender:
        output, timecode_at = LensOutput(sender, say), shot_timecodes(shot, first)

        def send(frame: int) -> None:
            output.send(sample_of_shot(SOURCE, shot, frame, timecode_at(frame)))

        yield send


_STDERR = 2  # the descriptor


def run_after(command: str, plan: ExportPlan, name: str) -> None:
    """Run `command` by the shell, with a line of JSON on its standard input.

    What it prints goes to standard error. Raises InputError if it fails.
    """
    facts = f"{json.dumps(_facts(plan, name))}\n"
    done = subprocess.run(command, shell=True, input=facts, text=True, stdout=_STDERR)
    if done.returncode:
        raise InputError(
            f"--after-export: the frames of {name} are written, but {command!r} ended with exit "
            f"code {done.returncode}."
        )


def _facts(plan: ExportPlan, name: str) -> dict[str, object]:
    """Return what the command is told; the lens has one value for each frame."""
    frames = plan.frames
    lens = {str(p): [getattr(frame.lens, p) for frame in frames] for p in LensParameter}
    timecode = shot_timecodes(plan.job.shot, frames[0].frame)(frames[0].frame)
    files = dict.fromkeys(str(frame.path.absolute()) for frame in frames)
    return {
        "shot": name,
        "files": list(files),
        "frames": [frame.frame for frame in frames],
        "lens": lens,
        "timecode": None if timecode is None else str(timecode),
    }
