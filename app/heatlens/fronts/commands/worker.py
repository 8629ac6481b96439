"""`heatlens worker`: make frames for exports on other machines, as a worker of a Dask cluster."""

import argparse
from collections.abc import Callable, Iterator
from contextlib import ExitStack, closing, contextmanager
from dataclasses import replace
from functools import lru_cache
from pathlib import Path

from heatlens.core.base.errors import InputError
from heatlens.core.base.paths import read_file_bytes
from heatlens.core.base.stopping import temporary_folder
from heatlens.deliver.export.job import ExportJob
from heatlens.deliver.export.plan import ExportPlan, plan_export
from heatlens.deliver.export.run import FrameDone, export_frames
from heatlens.deliver.farm import connection
from heatlens.deliver.farm.answers import (
    FetchedPart,
    PartDone,
    answer_with,
    event_text,
    pack_frames,
)
from heatlens.deliver.farm.cluster import PartTask
from heatlens.deliver.farm.connection import (
    NO_ANSWER,
    check_own_address,
    identify_scheduler,
    library,
    no_answer_error,
    parse_address,
)
from heatlens.deliver.farm.frame_worker import renderer
from heatlens.deliver.farm.processes import device_option, start_process, stop
from heatlens.fronts.commands.export_options import make_export_job
from heatlens.fronts.commands.options.device_option import add_device_option, use_device
from heatlens.fronts.commands.options.value_types import parse_whole_number
from heatlens.fronts.commands.output.say import print_messages
from heatlens.media.sequence.names import parse_frames
from heatlens.version import __version__

DESCRIPTION = """\
Makes frames for `heatlens export --cluster` on other machines, until you stop it or the scheduler
ends. Start the scheduler with `dask scheduler` on one machine, and a worker on each machine that
is to render, or several on a machine with many processors. Anyone who can reach the port of a
scheduler or a worker can run programs there: use a network that you trust, or Dask's certificates.
"""


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("address", metavar="tcp://HOST:8786", help="address of the Dask scheduler")
    parser.add_argument(
        "--processes",
        type=parse_whole_number,
        default=1,
        metavar="N",
        help="work with N processes (default 1)",
    )
    parser.add_argument(
        "--host",
        metavar="ADDRESS",
        help="address of this machine to listen on (default: the one that reaches the scheduler, "
        "so a scheduler on this machine has workers that no network reaches)",
    )
    add_device_option(parser, has_processes=True)


def run(args: argparse.Namespace) -> int:
    """Work until the scheduler ends. Raises InputError."""
    # Imported here, because every export imports this module for the function that workers run.
    # This saves 40 ms of processor time of 700 at the start of an export.
    import asyncio

    library()
    parse_address(args.address)
    if args.processes < 1:
        raise InputError(f"--processes must be 1 or more, got {args.processes}.")
    use_device(args)
    if args.host is not None:
        check_own_address(args.host)
    if args.processes > 1:
        return _run_processes(args)
    try:
        with temporary_folder() as folder:  # else Dask takes a known name in a shared folder
            own_address = identify_scheduler(args.address).own_host
            asyncio.run(_run_worker(args.address, args.host or own_address, folder))
    except NO_ANSWER as error:
        raise no_answer_error(args.address) from error
    print_messages("the scheduler has ended")
    return 0


def _run_processes(args: argparse.Namespace) -> int:
    """Work with several processes until the scheduler ends; if one dies, the others go on."""
    with ExitStack() as cleanup:
        processes = []
        for number in range(args.processes):
            words = ["worker", args.address, *device_option(args.device, number)]
            words += [f"--host={args.host}"] if args.host else []
            process = start_process(words, is_shown=True, count=args.processes)
            processes.append(cleanup.enter_context(process))
            cleanup.callback(stop, processes[-1])
        codes = [process.wait() for process in processes]
    if any(codes):
        failed_count = sum(code != 0 for code in codes)
        raise InputError(
            f"{failed_count} of the {len(codes)} processes of the worker ended early: the lines "
            "above say why. Start it again."
        )
    return 0


async def _run_worker(address: str, host: str, folder: Path) -> None:
    """Run a Dask worker with one thread until the scheduler ends.

    Only the thread that opened the GPU can draw. The worker listens on `host` alone, and
    shows its Dask page to this machine alone.
    """
    # Whoever reaches the port of a worker can run programs there. By default, Dask listens on every
    # address of the machine, and shows a page of all its work.
    settings: dict[str, object] = {
        "nthreads": 1,
        "memory_limit": 0,
        "death_timeout": connection.PATIENCE_S,
    }
    settings |= {"host": host, "dashboard_address": "127.0.0.1:0", "local_directory": str(folder)}
    async with library().Worker(address, **settings) as worker:
        print_messages(f"works for {address}")
        await worker.finished()


def make_part(task: PartTask) -> bytes:
    """Make the frames of a task, on the thread of a worker; return them as an answer."""
    worker = library().get_worker()

    def report(done: PartDone) -> None:
        worker.log_event(task.topic, {"frame": event_text(done)})

    return answer_with(lambda: pack_frames(_make_frames(task, report)), worker.address)


def _make_frames(task: PartTask, report: Callable[[PartDone], None]) -> list[FetchedPart]:
    """Make the frames of a task; report each one at once unless the files are fetched.

    Raises InputError if the task is from another version of heatlens.
    """
    if task.version != __version__:
        raise InputError(
            f"A worker has heatlens {__version__}, but {task.version} sent the work: install the "
            "same version on both."
        )
    parts_done = []
    with _open_plan(task) as plan, closing(export_frames(plan, renderer)) as steps:
        for done in steps:
            parts_done.append(_pack_frame(done, task))
            if not task.fetch:
                report(parts_done[-1][0])
    return parts_done


def _pack_frame(done: FrameDone, task: PartTask) -> FetchedPart:
    """Return a finished frame in the form of an answer, with its file if it is fetched."""
    remarks = tuple((remark.key, remark.sentence) for remark in done.remarks)
    data = read_file_bytes(done.path) if task.fetch else None
    driver = None if done.was_there else (_driver_name(), library().get_worker().address)
    facts = done.frame, done.was_there, done.surfaces_lost
    size = None if data is None else len(data)
    return PartDone(*facts, remarks, driver, done.pace, size), data


def _driver_name() -> str:
    return renderer().ctx.name


@contextmanager
def _open_plan(task: PartTask) -> Iterator[ExportPlan]:
    """Yield the plan of a task; files to fetch are written to a temporary folder."""
    if not task.fetch:
        yield _plan_task(task)
        return
    with temporary_folder() as folder:
        yield _plan_task(task, folder)


def _plan_task(task: PartTask, folder: Path | None = None) -> ExportPlan:
    """Return the plan of a task; `folder` replaces its output folder."""
    job = _job_of_words(task.words, task.topic)
    if folder is not None:
        job = replace(job, output=replace(job.output, folder=folder))
    return plan_export(job, parse_frames(task.frames))


@lru_cache(maxsize=1)
def _job_of_words(words: tuple[str, ...], topic: str) -> ExportJob:
    """Return the job of an export, which is the same for all of its tasks."""
    from heatlens.fronts.commands.command_parser import build_parser

    return make_export_job(build_parser(["export"]).parse_args(words))
