"""Solve tridiagonal systems along every row or column of a picture: three solvers, one interface.

A `LineSystem` names the network, a shader library that the solver's shader includes.
    SweepSolver      one invocation per line; least arithmetic, for software rasterisers
    PartitionSolver  a run of pixels per invocation, run ends in shared memory; for GPUs
    CyclicSolver     cyclic reduction, one pass per level; that of the 2006 memo, for comparison
"""

from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from enum import StrEnum
from typing import Literal, assert_never

from heatlens.render.defocus.tile_mask import RUN_LEAST, TileMask, WholePictures, run_length
from heatlens.render.gpu.context import is_software
from heatlens.render.gpu.device import Buffer, Device, Image, StorageBuffer
from heatlens.render.gpu.program import ComputeProgram, groups_for
from heatlens.render.gpu.shader_constants import CYCLIC_GROUP, STRIP_COLUMNS, STRIP_TEXELS, TILE
from heatlens.render.gpu.textures import enlarge, new_buffer

SCRATCH_BYTES_MAX = 4 << 20  # a few lines per core; more would exceed the processor's caches
_PIXELS_A_BAND = 1 << 18  # pixels per step: some ten milliseconds without a GPU
Axis = Literal["rows", "columns"]


class SolverName(StrEnum):
    """The solvers, by their names on the command line and in reports."""

    SWEEP = "sweep"
    PARTITION = "partition"
    CYCLIC = "cyclic"


@dataclass(frozen=True)
class LineSystem:
    """The network to solve: shader library, number of poles, complex or real, extra defines."""

    file: str
    poles: int = 1
    is_complex: bool = False
    defines: tuple[tuple[str, object], ...] = ()

    def shader_defines(self, axis: Axis) -> dict[str, object]:
        """Return the defines of the shader for this axis."""
        defines = dict(self.defines) | {
            "SYSTEM": self.file,
            "POLES": self.poles,
            "COMPLEX": int(self.is_complex),
        }
        return defines | {"ROWS": 1} if axis == "rows" else defines

    @property
    def value_bytes(self) -> int:
        """Bytes of the shader's `Value` of one pixel and pole."""
        return 32 if self.is_complex else 16

    @property
    def scalar_bytes(self) -> int:
        """Bytes of the shader's `Num`, a coefficient."""
        return 8 if self.is_complex else 4


@dataclass(frozen=True)
class Bindings:
    """The textures, images, uniforms and buffers of a system, by name."""

    textures: Mapping[str, Image] = field(default_factory=dict)
    images: Mapping[str, Image] = field(default_factory=dict)
    uniforms: Mapping[str, object] = field(default_factory=dict)
    buffers: Mapping[str, StorageBuffer] = field(default_factory=dict)


@dataclass(frozen=True)
class Band:
    """`count` lines of `length` pixels that are solved in one step, in the tiles of a mask."""

    system: LineSystem
    axis: Axis
    length: int
    count: int
    given: Bindings
    tiles: TileMask


# The system is never written as a matrix. Beside a wide blur the 1 of a diagonal 1 + k (b + b') is
# lost in float32, and the picture with it: an error of 7e-3 at a coc of 2000 px. In a network of
# conductances and heats to ground nothing is subtracted, and the error stays below 3e-6. Complex
# poles need no pivoting: turned by half their argument, the real part is positive definite.
class LineSolver(ABC):
    """Solves every line of a picture; programs are built once for each system."""

    name: SolverName
    _STRIPS = False  # the intermediate image is stored in strips, see lib/strips.lib.glsl

    def __init__(self, ctx: Device) -> None:
        self._ctx = ctx
        self._programs: dict[tuple[object, ...], ComputeProgram] = {}
        self._scratch: dict[str, Buffer] = {}
        self._whole = WholePictures(ctx)

    def steps(
        self,
        system: LineSystem,
        axis: Axis,
        size: tuple[int, int],
        bound: Bindings,
        mask: TileMask | None = None,
    ) -> Iterator[None]:
        """Solve `system` along `axis` of a picture of `size` (width, height).

        With a `mask` only its tiles are solved, as if there were nothing around them. The steps are
        short, so that a window can answer in between.
        """
        length, lines = size if axis == "rows" else size[::-1]
        tiles = mask or self._whole.mask(size)
        for first, count in self._bands(system, length, lines):
            here = {
                "axis": (1, 0) if axis == "rows" else (0, 1),
                "first_line": first,
                "line_count": count,
                "line_length": length,
            }
            uniforms = {**bound.uniforms, **here, "picture_height": size[1]}
            given = replace(bound, uniforms=uniforms)
            self._solve_band(Band(system, axis, length, count, given, tiles))
            yield

    def between_size(self, size: tuple[int, int]) -> tuple[int, int]:
        """Return the size of the intermediate texture between rows and columns."""
        if not self._STRIPS:
            return size
        texels = STRIP_COLUMNS * groups_for(size[0], STRIP_COLUMNS) * size[1]
        return STRIP_TEXELS, groups_for(texels, STRIP_TEXELS)

    def release(self) -> None:
        """Release programs and buffers."""
        for program in self._programs.values():
            program.release()
        for buffer in self._scratch.values():
            buffer.release()
        self._programs.clear()
        self._scratch.clear()
        self._whole.release()

    def _dispatch(self, program: ComputeProgram, groups: int, band: Band) -> None:
        """Run a program that solves whole lines and evaluates the mask itself."""
        program.dispatch(
            (groups, 1),
            textures=band.given.textures,
            images=band.given.images,
            buffers={"tile_mask_block": band.tiles.words, **self._buffers(band)},
            uniforms={**band.given.uniforms, **band.tiles.uniforms},
        )

    @abstractmethod
    def _solve_band(self, band: Band) -> None: ...

    @abstractmethod
    def _bytes_per_line(self, system: LineSystem, length: int) -> dict[str, int]:
        """Return the bytes that a line needs in each scratch block of the shader."""

    def _bands(self, system: LineSystem, length: int, lines: int) -> Iterator[tuple[int, int]]:
        per_line = max(1, sum(self._bytes_per_line(system, length).values()))
        most = min(SCRATCH_BYTES_MAX // per_line, _PIXELS_A_BAND // length)
        step = max(TILE, most // TILE * TILE)
        for first in range(0, lines, step):
            yield first, min(step, lines - first)

    def _buffers(self, band: Band) -> dict[str, StorageBuffer]:
        """Return all buffers by their blocks, those of scratch enlarged for longer lines."""
        for block, per_line in self._bytes_per_line(band.system, band.length).items():
            need = per_line * band.count
            if block not in self._scratch:
                self._scratch[block] = new_buffer(self._ctx, need)
            elif self._scratch[block].size < need:
                enlarge(self._ctx, self._scratch[block], need)
        return {**band.given.buffers, **self._scratch}

    def _program(self, shader: str, band: Band, **defines: object) -> ComputeProgram:
        key = (shader, band.system, band.axis, *sorted(defines.items()))
        if key not in self._programs:
            strips = {"STRIPS": 1} if self._STRIPS else {}
            given = band.system.shader_defines(band.axis) | strips | defines
            self._programs[key] = ComputeProgram(self._ctx, shader, given)
        return self._programs[key]


# A software rasteriser has no fast shared memory, so that the least arithmetic wins: 1,080 lines of
# 1,920 pixels took 51 ms on llvmpipe, 125 ms by runs in a workgroup, 262 ms by passes of cyclic
# reduction. One pixel of each block is stored, and the others computed again, which costs less.
class SweepSolver(LineSolver):
    """Thomas elimination in network form, one invocation a line."""

    name = SolverName.SWEEP
    _STRIPS = True
    LINES_PER_GROUP = 8  # the vector width of a software rasteriser
    BLOCK = 4  # pixels; with 8, programs take twice as long to compile and gain little

    def _bytes_per_line(self, system: LineSystem, length: int) -> dict[str, int]:
        blocks = groups_for(length, self.BLOCK) * system.poles
        return {
            "sweep_value_block": system.value_bytes * blocks,
            "sweep_heat_block": system.scalar_bytes * blocks,
        }

    def _solve_band(self, band: Band) -> None:
        program = self._program(
            "defocus/solve_sweep.comp.glsl",
            band,
            LINES_PER_GROUP=self.LINES_PER_GROUP,
            BLOCK=self.BLOCK,
        )
        self._dispatch(program, groups_for(band.count, self.LINES_PER_GROUP), band)


# After Zhang, Cohen and Owens, "Fast tridiagonal solvers on the GPU" (2010), and Laszlo, Giles and
# Appleyard, "Manycore algorithms for batch scalar and block tridiagonal solvers" (2016). A whole
# line does not fit the 32 KiB of shared memory that OpenGL promises: it has 28 bytes a pixel.
class PartitionSolver(LineSolver):
    """Eliminates runs in registers, and solves run ends by cyclic reduction in shared memory."""

    name = SolverName.PARTITION

    def _bytes_per_line(self, system: LineSystem, length: int) -> dict[str, int]:
        return {}

    def _bands(self, system: LineSystem, length: int, lines: int) -> Iterator[tuple[int, int]]:
        yield 0, lines

    @staticmethod
    def shape(system: LineSystem, length: int, count: int) -> dict[str, int]:
        """Return how `count` lines of `length` pixels are divided, as defines of the shader.

        Four complex channels of more than RUN_LEAST pixels do not fit the registers of a GPU; they
        are solved in two parts then, in rows and columns alike.
        """
        fits = run_length(max(length, count)) == RUN_LEAST
        parts = 2 if system.is_complex and not fits else 1
        return {"RUN": run_length(length), "PARTS": parts, "IN_PARTS": 1}

    def _solve_band(self, band: Band) -> None:
        shape = self.shape(band.system, band.length, band.count)
        segments = band.tiles.rows if band.axis == "rows" else band.tiles.columns
        self._program("defocus/solve_partition.comp.glsl", band, **shape).dispatch(
            segments,
            textures=band.given.textures,
            images=band.given.images,
            buffers={"segment_block": segments, **band.given.buffers},
            uniforms=band.given.uniforms,
        )


class CyclicSolver(LineSolver):
    """Cyclic reduction over memory, log2(length) passes down and up."""

    name = SolverName.CYCLIC

    def _bytes_per_line(self, system: LineSystem, length: int) -> dict[str, int]:
        unknowns = length * system.poles
        return {
            "cyclic_value_block": system.value_bytes * unknowns,
            "cyclic_link_block": 3 * system.scalar_bytes * unknowns,
        }

    def _solve_band(self, band: Band) -> None:
        reaches = [1 << level for level in range(max(0, (band.length - 1).bit_length()))]
        stages = [("LOAD", 0), *(("REDUCE", reach) for reach in reaches), ("SUBSTITUTE", 0)]
        stages += [*(("SUBSTITUTE", reach) for reach in reversed(reaches)), ("STORE", 0)]
        buffers = self._buffers(band)
        for stage, reach in stages:
            self._program("defocus/solve_cyclic.comp.glsl", band, STAGE=stage).dispatch(
                (groups_for(band.length, CYCLIC_GROUP), band.count),
                textures=band.given.textures,
                images=band.given.images,
                buffers=buffers,
                uniforms={**band.given.uniforms, "reach": reach},
            )


def _solver_named(name: SolverName) -> type[LineSolver]:
    match name:
        case SolverName.SWEEP:
            return SweepSolver
        case SolverName.PARTITION:
            return PartitionSolver
        case SolverName.CYCLIC:
            return CyclicSolver
        case _:
            assert_never(name)


SOLVERS = {name: _solver_named(name) for name in SolverName}


def usual_solver(ctx: Device) -> LineSolver:
    """Return the solver that is faster on such an OpenGL.

    The solvers differ in the last digits, and frames of a shot that several processes render must
    not. The choice therefore does not depend on a measurement.
    """
    # It did once: 0.9 s of processor at each start, and digits that depended on the load.
    return SweepSolver(ctx) if is_software(ctx) else PartitionSolver(ctx)
