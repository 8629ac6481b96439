"""`heatlens worker`: make frames for exports on other machines, as a worker of a Dask cluster."""

import argparse
from collections.abc import Callable, Iterator
from contextlib import ExitStack, closing, contextmanager
from dataclasses import replace
from functools import lru_cache
from pathlib import Path

from heatlens.core.base.errors import InputError
from heatlens.core.base.paths import file_bytes
from heatlens.core.base.stopping import temporary_folder
from heatlens.deliver.export.job import ExportJob
from heatlens.deliver.export.plan import ExportPlan, planned
from heatlens.deliver.export.run import FrameDone, export_frames
from heatlens.deliver.farm import connection
from heatlens.deliver.farm.answers import FetchedPart, PartDone, answered, packed_parts, part_text
from heatlens.deliver.farm.cluster import PartTask
from heatlens.deliver.farm.connection import (
    NO_ANSWER,
    check_own,
    checked_address,
    library,
    no_answer,
    who_answers,
)
from heatlens.deliver.farm.frame_worker import renderer
from heatlens.deliver.farm.processes import device_words, started, stop
from heatlens.fronts.commands.export_options import job_of
from heatlens.fronts.commands.options.device_option import add_device_option, use_device
from heatlens.fronts.commands.options.value_types import whole
from heatlens.fronts.commands.output.say import say
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
        "--processes", type=whole, default=1, metavar="N", help="work with N processes (default 1)"
    )
    parser.add_argument(
        "--host",
        metavar="ADDRESS",
        help="address of this machine to listen on (default: the one that reaches the scheduler, "
        "so a scheduler on this machine has workers that no network reaches)",
    )
    add_device_option(parser, has_processes=True)


def run(args: argparse.Namespace) -> int:
    """Work until the scheduler ends."""
    # Here, because every export imports this module for what a worker is sent: its start takes
    # 40 ms of processor less, of 700.
    import asyncio

    library()
    checked_address(args.address)
    if args.processes < 1:
        raise InputError(f"--processes must be 1 or more, got {args.processes}.")
    use_device(args)
    if args.host is not None:
        check_own(args.host)
    if args.processes > 1:
        return _several(args)
    try:
        with temporary_folder() as folder:  # else Dask takes a known name in a shared folder
            own = who_answers(args.address).own_host
            asyncio.run(_work(args.address, args.host or own, folder))
    except NO_ANSWER as error:
        raise no_answer(args.address) from error
    say("the scheduler has ended")
    return 0


def _several(args: argparse.Namespace) -> int:
    """Work with several processes until the scheduler ends; if one dies, the others go on."""
    with ExitStack() as undone:
        processes = []
        for number in range(args.processes):
            words = ["worker", args.address, *device_words(args.device, number)]
            words += [f"--host={args.host}"] if args.host else []
            process = started(words, is_shown=True, count=args.processes)
            processes.append(undone.enter_context(process))
            undone.callback(stop, processes[-1])
        codes = [process.wait() for process in processes]
    if any(codes):
        early = sum(code != 0 for code in codes)
        raise InputError(f"{early} of the {len(codes)} processes ended early.")
    return 0


async def _work(address: str, host: str, folder: Path) -> None:
    """Work with one thread, because only the thread that made an OpenGL context can draw.

    It listens on `host` alone, and shows its page of Dask to this machine alone.
    """
    # Whoever reaches the port of a worker can run programs there. Dask listens on every address of
    # the machine, and shows a page of all that it does, unless it is told otherwise.
    settings: dict[str, object] = {
        "nthreads": 1,
        "memory_limit": 0,
        "death_timeout": connection.PATIENCE_S,
    }
    settings |= {"host": host, "dashboard_address": "127.0.0.1:0", "local_directory": str(folder)}
    async with library().Worker(address, **settings) as worker:
        say(f"works for {address}")
        await worker.finished()


def made_part(task: PartTask) -> bytes:
    """Make the frames of a task, on the thread of a worker; return them as an answer."""
    worker = library().get_worker()

    def tell(done: PartDone) -> None:
        worker.log_event(task.topic, {"frame": part_text(done)})

    return answered(lambda: packed_parts(_made(task, tell)), worker.address)


def _made(task: PartTask, tell: Callable[[PartDone], None]) -> list[FetchedPart]:
    if task.version != __version__:
        raise InputError(
            f"A worker has heatlens {__version__}, but {task.version} sent the work: install the "
            "same version on both."
        )
    parts_done = []
    with _plan(task) as plan, closing(export_frames(plan, renderer)) as steps:
        for done in steps:
            parts_done.append(_part_done(done, task))
            if not task.fetch:
                tell(parts_done[-1][0])
    return parts_done


def _part_done(done: FrameDone, task: PartTask) -> FetchedPart:
    remarks = tuple((remark.key, remark.sentence) for remark in done.remarks)
    data = file_bytes(done.path) if task.fetch else None
    driver = None if done.was_there else (_driver(), library().get_worker().address)
    of = done.frame, done.was_there, done.surfaces_lost
    size = None if data is None else len(data)
    return PartDone(*of, remarks, driver, done.pace, size), data


def _driver() -> str:
    return renderer().ctx.name


@contextmanager
def _plan(task: PartTask) -> Iterator[ExportPlan]:
    """Yield the plan of a task; files to fetch are written to a temporary folder."""
    if not task.fetch:
        yield _planned(task)
        return
    with temporary_folder() as folder:
        yield _planned(task, folder)


def _planned(task: PartTask, folder: Path | None = None) -> ExportPlan:
    job = _job(task.words, task.topic)
    if folder is not None:
        job = replace(job, output=replace(job.output, folder=folder))
    return planned(job, parse_frames(task.frames))


@lru_cache(maxsize=1)
def _job(words: tuple[str, ...], topic: str) -> ExportJob:
    """Return the job of an export, which is the same for all of its tasks."""
    from heatlens.fronts.commands.command_parser import build_parser

    return job_of(build_parser(["export"]).parse_args(words))
