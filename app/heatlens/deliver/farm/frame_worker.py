"""Render frames for the window of another machine, on the thread of a Dask worker."""

import time
from dataclasses import replace
from functools import cache, lru_cache
from pathlib import Path
from typing import Any, NoReturn

from heatlens.core.base.errors import InputError
from heatlens.core.model.shot.framing import Framing, WorldAxis
from heatlens.deliver.farm.answers import FOREIGN_ANSWER, answer_with, pack_answer, unpack_answer
from heatlens.deliver.farm.connection import library
from heatlens.deliver.farm.inputs import absolute_path
from heatlens.media.scene.placing import place_scene
from heatlens.media.scene.scene import Scene
from heatlens.media.sequence.sequence import Stamp, StampedFile, stamp_files
from heatlens.render.defocus.line_solver import SOLVERS, SolverName
from heatlens.render.frame_renderer import FrameRenderer, headless_renderer
from heatlens.render.rendered_frames.cached_pictures import (
    CachedPicture,
    RenderedPicture,
    decode_float_picture,
    decode_picture,
    encode_picture,
)
from heatlens.render.rendered_frames.frame_filler import FrameFiller, FrameJob
from heatlens.render.rendered_frames.frame_key import program_contents
from heatlens.render.source.source import Source
from heatlens.version import __version__

Program = tuple[str, ...]

_WORK_STEP_S, _READING_POLL_S = 0.1, 0.002  # between two checks whether the frame was recalled


def answer_program(solver: SolverName) -> bytes:
    """Return an answer with the program of this worker; equal programs render equal pictures."""

    def program() -> bytes:
        device = _filler(solver).renderer.ctx
        worker_program = own_program(device.name, device.version, solver)
        return pack_answer({"program": worker_program})

    return answer_with(program, library().get_worker().address)


def program_of_answer(answer: bytes) -> Program:
    """Return the program in a worker's answer. Raises InputError with the worker's message."""
    entry, _ = unpack_answer(answer)
    program = entry.members(("program",), ("program",))["program"]
    return tuple(item.text() for item in program.items())


def own_program(driver: str, version: str, solver: str) -> Program:
    """Return the program of this machine on a graphics driver."""
    return __version__, program_contents(), driver, version, solver


def job_to_send(job: FrameJob) -> FrameJob:
    """Return a job that can be sent to a worker: with absolute paths, and without read pixels."""
    assert job.source is not None
    plate = job.plate
    if plate is not None:
        files = tuple(StampedFile(absolute_path(it.path), it.stamp) for it in plate.files)
        plate = replace(plate, files=files, read=_read_by_worker_only)
    return replace(job, source=job.source.with_absolute_paths(), plate=plate)


def _read_by_worker_only(path: Path) -> NoReturn:
    raise AssertionError(f"{path} is read by the worker.")


def answer_frame(job: FrameJob, solver: SolverName, is_kept: bool) -> bytes:
    """Return an answer with a rendered frame, or one without a picture if it was recalled.

    With `is_kept`, the picture is sent in the half floats in which it is kept.
    """
    worker = library().get_worker()

    def render() -> bytes:
        """Return the packed answer: the picture, or that the task was recalled."""
        picture = _render_frame(job, _filler(solver), worker)
        if picture is None:
            return pack_answer({"recalled": True})
        sent_picture = picture.as_kept() if is_kept else picture
        return pack_answer({"kept": is_kept}, [encode_picture(sent_picture, "")])

    return answer_with(render, worker.address)


def picture_of_answer(answer: bytes) -> RenderedPicture | CachedPicture | None:
    """Return the picture of an answer; None if the frame was recalled.

    Raises InputError with the worker's message, or for an answer that is not one of heatlens.
    """
    entry, data = unpack_answer(answer)
    entries = entry.members(("recalled", "kept"))
    if "recalled" in entries:
        return None
    is_kept = "kept" in entries and entries["kept"].flag()
    picture = decode_picture(data, "") if is_kept else decode_float_picture(data, "")
    if picture is None:
        raise InputError(FOREIGN_ANSWER)
    return picture


def _render_frame(job: FrameJob, filler: FrameFiller, worker: Any) -> RenderedPicture | None:
    """Render a frame in short steps; return None if the window recalls it meanwhile."""
    key = worker.get_current_task()
    prepared_job = _prepare_job(job, filler)
    while (picture := filler.work(prepared_job, None, _WORK_STEP_S)) is None:
        task = worker.state.tasks.get(key)
        if task is None or task.state == "cancelled":
            filler.stop()
            return None
        if filler.is_reading:
            time.sleep(_READING_POLL_S)
    return picture


def _prepare_job(job: FrameJob, filler: FrameFiller) -> FrameJob:
    """Return the job with a plate that this worker itself reads; load a scene instead."""
    source_to_open: Any = job.source  # Any: no type says that a Source can be the key of a cache
    source = _open_source(source_to_open, job.stamps)
    if source.has_many_views:  # it is a scene
        framing = job.shot.framing or Framing()
        scene = _placed_scene(source, framing.up_axis, framing.meters_per_unit)
        if scene is not filler.renderer.scene:  # it is the same object while nothing changed
            filler.renderer.load_scene(scene)
        return job
    assert job.plate is not None
    return replace(job, plate=replace(job.plate, read=source.read))


@lru_cache(maxsize=1)
def _open_source(source: Source, stamps: tuple[Stamp | None, ...]) -> Any:
    """Return a source that stays open from task to task. Raises InputError if it has changed.

    The result is Any, because only a scene has a `scene`, and only plates have a `read`.
    """
    if stamps and tuple(file.stamp for file in stamp_files(source.all_files)) != stamps:
        raise InputError(
            f"{source.text} differs on this machine from the file that the window has open: put "
            "the same file there."
        )
    return source


@lru_cache(maxsize=1)
def _placed_scene(source: Any, up_axis: WorldAxis, meters_per_unit: float) -> Scene:
    """Return the scene of a source in the axes and units of the shot; kept for the next task."""
    return place_scene(source.scene, Framing(up_axis=up_axis, meters_per_unit=meters_per_unit))


# Only one thread can draw, so a worker has one thread. The module keeps the context, the built
# programs and the open source from task to task. The two renderers of a process share its context:
# this one, and that of `_filler`, with the solver of the window that sends the frames.
@cache
def renderer() -> FrameRenderer:
    """Return the renderer of this process, which stays warm from task to task."""
    return headless_renderer()


@cache
def _filler(solver: SolverName) -> FrameFiller:
    """Return the filler with the solver of the window; it shares the context of `renderer`."""
    ctx = renderer().ctx
    return FrameFiller(FrameRenderer(ctx, SOLVERS[solver](ctx)))
