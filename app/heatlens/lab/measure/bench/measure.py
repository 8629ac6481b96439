"""The measurements of `heatlens bench`: a frame and its passes, series, and the bare sweeps.

Two bare Thomas sweeps over a picture are the reference for a frame with one layer of heat.
"""

from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from heatlens.core.base.errors import GpuError
from heatlens.core.model.shot.settings import Bokeh, DefocusSettings
from heatlens.lab.measure.bench.report import BareReport, CocRow, FrameReport, PassRow, SizeRow
from heatlens.lab.measure.bench.synthetic_plate import (
    LENS,
    lens_with_largest_coc,
    scene_coc_px,
    scene_plate,
    uniform_coc_plate,
)
from heatlens.lab.measure.bench.timing import (
    BenchFrames,
    PassSeconds,
    frame_seconds,
    median_seconds,
)
from heatlens.render.defocus.kernels import named_kernel
from heatlens.render.defocus.pass_costs import Traffic, Work
from heatlens.render.defocus.pass_list import pass_named
from heatlens.render.defocus.plate_passes import proxy_size
from heatlens.render.defocus.quality import kernel_for
from heatlens.render.gpu.context import is_software
from heatlens.render.gpu.device import Device
from heatlens.render.gpu.program import ComputeProgram, groups_for, pixel_groups
from heatlens.render.gpu.resources import Texture
from heatlens.render.gpu.shader_constants import ROW_GROUP
from heatlens.render.gpu.stopwatch import Stopwatch
from heatlens.render.gpu.textures import FloatArray, new_texture, upload

Size = tuple[int, int]
ReportProgress = Callable[[str], None]

SWEEP_COC_PX = (2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 200.0)
SWEEP_SIZES = ((960, 540), (1920, 1080), (3840, 2160))
BARE_MESSAGE = "one layer of heat beside two bare sweeps"


def copy_message(size: Size, settings: DefocusSettings) -> str:
    """Return the progress message of the copy."""
    width, height = proxy_size(size, settings.proxy)
    return f"copying {width}x{height}"


def frame_message(size: Size, runs: int) -> str:
    """Return the progress message of the frame."""
    return f"frame of {size[0]}x{size[1]}, {runs} runs, twice"


def coc_message(coc_px: float) -> str:
    """Return the progress message of an amount of blur."""
    return f"circle of confusion {coc_px:g} px"


def size_message(size: Size) -> str:
    """Return the progress message of a size."""
    return f"size {size[0]}x{size[1]}"


def measure_frame(
    frames: BenchFrames,
    size: Size,
    settings: DefocusSettings,
    runs: int,
    report_progress: ReportProgress,
) -> FrameReport:
    """Measure whole frames of the scene at `size`, alternating with frames that time every pass."""
    working_size = proxy_size(size, settings.proxy)
    report_progress(copy_message(size, settings))
    copy_rate = copy_bytes_per_second(frames.ctx, working_size)
    report_progress(frame_message(size, runs))
    frame = frames.frame(scene_plate(size), LENS, settings)
    seconds = frame_seconds(frames.stopwatch, runs, frame.render)
    work = Work(working_size, kernel_for(settings), frames.solver.name, settings.proxy)
    return FrameReport(
        renderer=frames.ctx.name,
        is_software=is_software(frames.ctx),
        width=size[0],
        height=size[1],
        proxy=settings.proxy,
        method=str(settings.method),
        bokeh=str(settings.bokeh),
        quality=str(settings.effective_quality),
        layer_count=frame.layer_count,
        solver=frames.solver.name,
        runs=runs,
        copy_gb_per_s=1e-9 * copy_rate,
        passes=tuple(pass_row(*item, work, copy_rate) for item in seconds.passes.items()),
        frame_ms=1e3 * seconds.stopwatch_off,
        stopwatch_frame_ms=1e3 * seconds.stopwatch_on,
    )


def pass_row(name: str, entry: PassSeconds, work: Work, copy_bytes_per_s: float) -> PassRow:
    """Combine the measured time of a pass with the bytes of the cost table; '-' if it has none."""
    try:
        traffic = pass_named(name).traffic(work, entry.runs)
    except KeyError:
        traffic = Traffic(None, None)
    pixels = work.size[0] * work.size[1]
    moved = None if traffic.moved is None else round(traffic.moved * pixels)
    rate = None if moved is None or entry.seconds <= 0.0 else moved / entry.seconds
    return PassRow(
        name=name,
        ms=1e3 * entry.seconds,
        runs=entry.runs,
        bytes_moved=moved,
        bytes_least=None if traffic.least is None else round(traffic.least * pixels),
        at_least=traffic.at_least,
        at_most=traffic.at_most,
        moved_gb_per_s=None if rate is None else 1e-9 * rate,
        copy_share=None if rate is None else rate / copy_bytes_per_s,
    )


def measure_coc_sweep(
    frames: BenchFrames,
    size: Size,
    settings: DefocusSettings,
    runs: int,
    report_progress: ReportProgress,
) -> tuple[CocRow, ...]:
    """Return the time of a frame at each amount of blur."""
    measured = []
    for coc in SWEEP_COC_PX:
        report_progress(coc_message(coc))
        one_layer = _time_uniform_coc(frames, size, coc, replace(settings, layers=1), runs)
        layered = _time_uniform_coc(frames, size, coc, settings, runs)
        scene = _time_scene(frames, size, coc, settings, runs)
        measured.append((coc, one_layer, layered, scene))
    _, first_one, first_layered, first_scene = measured[0]
    return tuple(
        CocRow(
            coc_px=coc,
            one_layer_ms=one_layer.ms,
            one_layer_ratio=one_layer.ms / first_one.ms,
            layered_ms=layered.ms,
            layered_ratio=layered.ms / first_layered.ms,
            layered_layer_count=layered.layer_count,
            scene_ms=scene.ms,
            scene_ratio=scene.ms / first_scene.ms,
            scene_layer_count=scene.layer_count,
        )
        for coc, one_layer, layered, scene in measured
    )


class _FrameTime(NamedTuple):
    """The milliseconds of a frame, and into how many layers it is divided."""

    ms: float
    layer_count: int


def _time_uniform_coc(
    frames: BenchFrames, size: Size, coc: float, settings: DefocusSettings, runs: int
) -> _FrameTime:
    """Measure a frame that has the same coc everywhere."""
    frame = frames.frame(uniform_coc_plate(size, coc), LENS, settings)
    return _FrameTime(1e3 * median_seconds(frames.ctx, runs, frame.render)[0], frame.layer_count)


def _time_scene(
    frames: BenchFrames, size: Size, coc: float, settings: DefocusSettings, runs: int
) -> _FrameTime:
    """Measure a frame of the scene with `coc` as its largest coc."""
    frame = frames.frame(scene_plate(size), lens_with_largest_coc(coc, size), settings)
    return _FrameTime(1e3 * median_seconds(frames.ctx, runs, frame.render)[0], frame.layer_count)


def measure_size_sweep(
    frames: BenchFrames, settings: DefocusSettings, runs: int, report_progress: ReportProgress
) -> tuple[SizeRow, ...]:
    """Measure the time of a frame against its number of pixels.

    A size that needs more memory than this machine has is left out, with a progress message.
    """
    measured: list[tuple[Size, float, float, int]] = []
    for size in SWEEP_SIZES:
        report_progress(size_message(size))
        try:
            frames.check_fits(size, settings)
            frame = frames.frame(scene_plate(size), LENS, settings)
        except GpuError as error:
            report_progress(f"left out: {error}")
            continue
        single = replace(frame, shot=replace(frame.shot, defocus=replace(settings, layers=1)))
        one_s, layered_s = median_seconds(frames.ctx, runs, single.render, frame.render)
        measured.append((size, 1e3 * one_s, 1e3 * layered_s, frame.layer_count))
    return size_rows(measured)


def size_rows(measured: list[tuple[Size, float, float, int]]) -> tuple[SizeRow, ...]:
    """Return rows from (size, one layer ms, layered ms, layers), relative to the first size."""
    per_pixel = [(one / (w * h), layered / (w * h)) for (w, h), one, layered, _ in measured]
    return tuple(
        SizeRow(*size, one, a / per_pixel[0][0], layered, b / per_pixel[0][1], layer_count)
        for (size, one, layered, layer_count), (a, b) in zip(measured, per_pixel, strict=True)
    )


def measure_bare(
    frames: BenchFrames, size: Size, runs: int, report_progress: ReportProgress
) -> BareReport:
    """Measure a frame of one layer of heat and its two line sweeps alone, in turn."""
    report_progress(BARE_MESSAGE)
    plate = scene_plate(size)
    frame = frames.frame(plate, LENS, DefocusSettings(Bokeh.HEAT, layers=1))
    bare = BareSweeps(frames.ctx, plate.color, scene_coc_px(size))
    heat_s, bare_s = median_seconds(frames.ctx, runs, frame.render, bare.run)
    bare.release()
    return BareReport(1e3 * heat_s, 1e3 * bare_s, heat_s / bare_s)


_BYTES_PER_PIXEL = 32  # rgba32f read and written
_GPU_COPY_SIZE = (4096, 4096)  # 256 MiB, more than the caches of any GPU
_COPIES = 7


def copy_bytes_per_second(ctx: Device, size: tuple[int, int]) -> float:
    """Return the bytes per second of the fastest of several copies; the first copy is not counted.

    A software rasterizer copies a picture of `size`, on which the processor's caches have the same
    effect as on the passes; a GPU copies a large picture.
    """
    size = size if is_software(ctx) else _GPU_COPY_SIZE
    program = ComputeProgram(ctx, "lab/bandwidth_copy.comp.glsl")
    source, target = (new_texture(ctx, size, 4) for _ in range(2))
    source.write(
        bytes(16 * size[0] * size[1])
    )  # reading memory that was never written would be too fast
    seconds = [_copy_seconds(ctx, program, source, target) for _ in range(_COPIES + 1)]
    for resource in (program, source, target):
        resource.release()
    return _BYTES_PER_PIXEL * size[0] * size[1] / min(seconds[1:])


def _copy_seconds(ctx: Device, program: ComputeProgram, source: Texture, target: Texture) -> float:
    """Return the seconds of one copy of a texture."""
    stopwatch = Stopwatch(ctx, is_on=True)
    with stopwatch.measure("copy"):
        images = {"out_color_img": target}
        program.dispatch(pixel_groups(source.size), textures={"color_tx": source}, images=images)
    return stopwatch.times["copy"].seconds


class BareSweeps:
    """Sweeps rows, then columns, with precomputed conductances; owns all its GPU objects."""

    def __init__(self, ctx: Device, color: FloatArray, coc_px: FloatArray) -> None:
        """Upload `color` (H, W, 4) and `coc_px` (H, W), diameters of either sign, to the GPU."""
        size = (coc_px.shape[1], coc_px.shape[0])
        _check_scratch_fits(ctx, size)
        self._size = size
        self._program = ComputeProgram(ctx, "lab/bare_sweep.comp.glsl")
        self._color, self._rows, self.out = (new_texture(ctx, size, 4) for _ in range(3))
        self._conductances = [new_texture(ctx, size, 1) for _ in range(2)]
        self._scratch = {
            block: ctx.buffer(reserve=per_pixel * size[0] * size[1])
            for block, per_pixel in (("bare_weight_block", 4), ("bare_constant_block", 16))
        }
        upload(self._color, color)
        for axis, texture in enumerate(self._conductances):
            upload(texture, conductances(coc_px, axis=1 - axis))

    def run(self) -> None:
        """Write the diffused picture to `out`."""
        self._sweep((1, 0), self._conductances[0], self._color, self._rows)
        self._sweep((0, 1), self._conductances[1], self._rows, self.out)

    def _sweep(
        self, axis: tuple[int, int], conductance: Texture, color: Texture, out_color: Texture
    ) -> None:
        """Diffuse `color` along one axis to `out_color`."""
        length, lines = self._size if axis == (1, 0) else self._size[::-1]
        self._program.dispatch(
            (groups_for(lines, ROW_GROUP), 1),
            images={"conductance_img": conductance, "color_img": color, "out_color_img": out_color},
            buffers=self._scratch,
            uniforms={"axis": axis, "line_count": lines, "line_length": length},
        )

    def release(self) -> None:
        for texture in (self._color, self._rows, self.out, *self._conductances):
            texture.release()
        for buffer in self._scratch.values():
            buffer.release()
        self._program.release()


def conductances(coc_px: FloatArray, axis: int) -> FloatArray:
    """Return the heat conductance of each pixel to the next along `axis`; 0 at a line's end."""
    diameter = np.moveaxis(np.abs(coc_px), axis, -1)
    result = np.zeros(diameter.shape, np.float32)
    narrower = np.minimum(diameter[..., :-1], diameter[..., 1:])
    result[..., :-1] = named_kernel("heat").poles[0].real * narrower**2
    return np.ascontiguousarray(np.moveaxis(result, -1, axis))


def _check_scratch_fits(ctx: Device, size: tuple[int, int]) -> None:
    """Raise GpuError if the scratch memory of the sweeps exceeds a storage block."""
    need = 16 * size[0] * size[1]
    limit = ctx.limits.storage_block_bytes
    if need > limit:
        raise GpuError(
            f"The bare sweeps of {size[0]}x{size[1]} need a storage block of {need / 2**20:.0f} "
            f"MiB; this GPU takes {limit / 2**20:.0f}. Give --bare a smaller --size."
        )
