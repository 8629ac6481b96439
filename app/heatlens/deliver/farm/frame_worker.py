"""Render frames for the window of another machine, on the thread of a Dask worker."""

import time
from dataclasses import replace
from functools import cache, lru_cache
from pathlib import Path
from typing import Any, NoReturn

from heatlens.core.base.errors import InputError
from heatlens.core.model.shot.framing import Framing, WorldAxis
from heatlens.deliver.farm.answers import OTHER, answered, opened, packed
from heatlens.deliver.farm.connection import library
from heatlens.deliver.farm.inputs import plain_path
from heatlens.media.scene.placing import placed
from heatlens.media.scene.scene import Scene
from heatlens.media.sequence.sequence import Stamp
from heatlens.render.defocus.line_solver import SOLVERS, SolverName
from heatlens.render.frame_renderer import FrameRenderer, headless_renderer
from heatlens.render.rendered_frames.frame_filler import FrameFiller, FrameJob
from heatlens.render.rendered_frames.frame_key import program_contents
from heatlens.render.rendered_frames.kept_pictures import (
    KeptPicture,
    RenderedPicture,
    decoded,
    decoded_whole,
    encoded,
)
from heatlens.render.source.source import Source, StampedFile, stamped
from heatlens.version import __version__

Program = tuple[str, ...]

_SLICE_S, _READING_S = 0.1, 0.002  # between two looks whether the frame is still wanted


def program_of(solver: SolverName) -> bytes:
    """Answer what identifies the renderer of this worker: programs that are equal draw alike."""

    def program() -> bytes:
        device = _filler(solver).renderer.ctx
        here = program_on(device.name, device.version, solver)
        return packed({"program": here})

    return answered(program, library().get_worker().address)


def program_in(answer: bytes) -> Program:
    """Return the program of a worker. Raises InputError with the sentence of the worker."""
    entry, _ = opened(answer)
    program = entry.members(("program",), ("program",))["program"]
    return tuple(item.text() for item in program.items())


def program_on(driver: str, version: str, solver: str) -> Program:
    """Return the program of this machine on an OpenGL driver."""
    return __version__, program_contents(), driver, version, solver


def sent(job: FrameJob) -> FrameJob:
    """Return a job with absolute paths and nothing that was read, to be sent to a worker."""
    assert job.source is not None
    plate = job.plate
    if plate is not None:
        files = tuple(StampedFile(plain_path(it.path), it.stamp) for it in plate.files)
        plate = replace(plate, files=files, read=_unread)
    return replace(job, source=job.source.located(), plate=plate)


def _unread(path: Path) -> NoReturn:
    raise AssertionError(f"{path} is read by the worker.")


def rendered(job: FrameJob, solver: SolverName, is_kept: bool) -> bytes:
    """Answer with a frame, or with none if it has been recalled.

    With `is_kept` the picture is sent as it is kept.
    """
    worker = library().get_worker()

    def made() -> bytes:
        picture = _rendered(job, _filler(solver), worker)
        if picture is None:
            return packed({"recalled": True})
        sent = picture.kept() if is_kept else picture
        return packed({"kept": is_kept}, [encoded(sent, "")])

    return answered(made, worker.address)


def picture_in(answer: bytes) -> RenderedPicture | KeptPicture | None:
    """Return the picture of an answer; None if it was recalled. Raises InputError."""
    entry, data = opened(answer)
    entries = entry.members(("recalled", "kept"))
    if "recalled" in entries:
        return None
    is_kept = "kept" in entries and entries["kept"].flag()
    picture = decoded(data, "") if is_kept else decoded_whole(data, "")
    if picture is None:
        raise InputError(OTHER)
    return picture


def _rendered(job: FrameJob, filler: FrameFiller, worker: Any) -> RenderedPicture | None:
    key = worker.get_current_task()
    ready = _ready(job, filler)
    while (picture := filler.work(ready, None, _SLICE_S)) is None:
        task = worker.state.tasks.get(key)
        if task is None or task.state == "cancelled":
            filler.stop()
            return None
        if filler.is_reading:
            time.sleep(_READING_S)
    return picture


def _ready(job: FrameJob, filler: FrameFiller) -> FrameJob:
    """Return the job with its plate to be read here, or load its scene."""
    named: Any = job.source
    source = _source(named, job.stamps)
    if source.has_many_views:
        framing = job.shot.framing or Framing()
        scene = _scene(source, framing.up_axis, framing.meters_per_unit)
        if scene is not filler.renderer.scene:
            filler.renderer.load_scene(scene)
        return job
    assert job.plate is not None
    return replace(job, plate=replace(job.plate, read=source.read))


@lru_cache(maxsize=1)
def _source(source: Source, stamps: tuple[Stamp | None, ...]) -> Any:
    """Return a source that stays open from task to task. Raises InputError if it has changed."""
    if stamps and tuple(file.stamp for file in stamped(source.all_files)) != stamps:
        raise InputError(f"{source.text} is not the file that the window has open.")
    return source


@lru_cache(maxsize=1)
def _scene(source: Any, up_axis: WorldAxis, meters_per_unit: float) -> Scene:
    return placed(source.scene, Framing(up_axis=up_axis, meters_per_unit=meters_per_unit))


# OpenGL belongs to one thread, so a worker has one, and what it made stays in the module from task
# to task: a context, the built programs, the open source. Two renderers in one process share its
# context, since the second is for the window that asks, with that window's solver.
@cache
def renderer() -> FrameRenderer:
    """Return the renderer of this process, which stays warm from task to task."""
    return headless_renderer()


@cache
def _filler(solver: SolverName) -> FrameFiller:
    """Return what makes frames with the solver of the window, beside `renderer`."""
    ctx = renderer().ctx
    return FrameFiller(FrameRenderer(ctx, SOLVERS[solver](ctx)))
