"""Solve tridiagonal systems along every row or column of a picture: two solvers, one interface.

The system of a line is a network of heat: a chain of pixels with conductances between them. A
`LineSystem` names the shader library with the network, which the solver's shader includes.
    SweepSolver      one invocation per line; least arithmetic, for software rasterizers
    PartitionSolver  a run of pixels per invocation, run ends in shared memory; for GPUs
"""

from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from enum import StrEnum
from typing import Literal, assert_never

from heatlens.render.defocus.tile_mask import RUN_LEAST, TileMask, WholePictures, run_length
from heatlens.render.gpu.context import is_software
from heatlens.render.gpu.device import Device
from heatlens.render.gpu.program import ComputeProgram, groups_for
from heatlens.render.gpu.resources import Buffer, Image, StorageBuffer
from heatlens.render.gpu.shader_constants import STRIP_COLUMNS, STRIP_TEXELS, TILE
from heatlens.render.gpu.textures import enlarge, new_buffer

SCRATCH_BYTES_MAX = 4 << 20  # a few lines per core; more would exceed the processor's caches
_PIXELS_A_BAND = 1 << 18  # pixels per step: some ten milliseconds without a GPU
Axis = Literal["rows", "columns"]


class SolverName(StrEnum):
    """The solvers, by their names on the command line and in reports."""

    SWEEP = "sweep"
    PARTITION = "partition"


@dataclass(frozen=True)
class LineSystem:
    """The network to solve along each line.

    file        the shader library that defines the network
    poles       how many systems are solved at once
    is_complex  the coefficients are complex, else real
    defines     additional defines of the shader, as pairs of name and value
    """

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
    bindings: Bindings
    tiles: TileMask


# The system is solved as a network of conductances and heats to ground, in which nothing is
# subtracted: the error stays below 3e-6. In a matrix, the 1 of a diagonal 1 + k (b + b') is lost in
# float32 beside a wide blur: an error of 7e-3 at a coc of 2000 px. Complex poles need no pivoting:
# turned by half their argument, the real part is positive definite.
class LineSolver(ABC):
    """Solves every line of a picture; programs are built once for each system."""

    name: SolverName
    _STRIPS = False  # the intermediate image is stored in strips, see lib/strips.lib.glsl

    def __init__(self, ctx: Device) -> None:
        self._ctx = ctx
        self._solve = ComputeProgram(ctx, f"defocus/solve_{self.name}.comp.glsl")
        self._scratch: dict[str, Buffer] = {}
        self._whole = WholePictures(ctx)

    def steps(
        self,
        system: LineSystem,
        axis: Axis,
        size: tuple[int, int],
        bindings: Bindings,
        mask: TileMask | None = None,
    ) -> Iterator[None]:
        """Solve `system` along `axis` of a picture of `size` (width, height).

        With a `mask` only its tiles are solved, as if there were nothing around them. The steps are
        short, so that a window can answer in between.
        """
        length, lines = size if axis == "rows" else size[::-1]
        tiles = mask or self._whole.mask(size)
        for first_line, count in self._bands(system, length, lines):
            line_uniforms = {
                "axis": (1, 0) if axis == "rows" else (0, 1),
                "first_line": first_line,
                "line_count": count,
                "line_length": length,
            }
            uniforms = {**bindings.uniforms, **line_uniforms, "picture_height": size[1]}
            band_bindings = replace(bindings, uniforms=uniforms)
            self._solve_band(Band(system, axis, length, count, band_bindings, tiles))
            yield

    def size_between_axes(self, size: tuple[int, int]) -> tuple[int, int]:
        """Return the size of the intermediate texture between rows and columns."""
        if not self._STRIPS:
            return size
        texels = STRIP_COLUMNS * groups_for(size[0], STRIP_COLUMNS) * size[1]
        return STRIP_TEXELS, groups_for(texels, STRIP_TEXELS)

    def release(self) -> None:
        """Release programs and buffers."""
        self._solve.release()
        for buffer in self._scratch.values():
            buffer.release()
        self._scratch.clear()
        self._whole.release()

    def _dispatch(self, program: ComputeProgram, groups: int, band: Band) -> None:
        """Run a program that solves whole lines and evaluates the mask itself."""
        program.dispatch(
            (groups, 1),
            textures=band.bindings.textures,
            images=band.bindings.images,
            buffers={"tile_mask_block": band.tiles.words, **self._buffers(band)},
            uniforms={**band.bindings.uniforms, **band.tiles.uniforms},
        )

    @abstractmethod
    def _solve_band(self, band: Band) -> None:
        """Issue the programs that solve the lines of a band, with the results in its images."""

    @abstractmethod
    def _bytes_per_line(self, system: LineSystem, length: int) -> dict[str, int]:
        """Return the bytes that a line of `length` pixels needs in each scratch block."""

    def _bands(self, system: LineSystem, length: int, lines: int) -> Iterator[tuple[int, int]]:
        """Yield the first line and the number of lines of each band, as scratch memory allows."""
        per_line = max(1, sum(self._bytes_per_line(system, length).values()))
        most_lines = min(SCRATCH_BYTES_MAX // per_line, _PIXELS_A_BAND // length)
        step = max(TILE, most_lines // TILE * TILE)
        for first_line in range(0, lines, step):
            yield first_line, min(step, lines - first_line)

    def _buffers(self, band: Band) -> dict[str, StorageBuffer]:
        """Return all buffers by the names of their blocks; enlarge scratch for longer lines."""
        for block, per_line in self._bytes_per_line(band.system, band.length).items():
            needed_bytes = per_line * band.count
            if block not in self._scratch:
                self._scratch[block] = new_buffer(self._ctx, needed_bytes)
            elif self._scratch[block].size < needed_bytes:
                enlarge(self._ctx, self._scratch[block], needed_bytes)
        return {**band.bindings.buffers, **self._scratch}

    def _program(self, band: Band, **defines: object) -> ComputeProgram:
        """Return the version of the shader for the system and axis of a band."""
        system = band.system.shader_defines(band.axis)
        return self._solve.version(**system, STRIPS=self._STRIPS, **defines)


# On a software rasterizer, which has no fast shared memory, the least arithmetic is fastest: 1,080
# lines of 1,920 pixels took 51 ms on llvmpipe, against 125 ms by runs in a workgroup and 262 ms by
# passes of cyclic reduction. One pixel of each block is stored, and the others are computed again,
# which costs less.
class SweepSolver(LineSolver):
    """Thomas elimination in network form, one invocation a line."""

    name = SolverName.SWEEP
    _STRIPS = True
    LINES_PER_GROUP = 8  # the vector width of a software rasterizer
    BLOCK = 4  # pixels in a block; with 8, programs compile twice as long and gain little

    def _bytes_per_line(self, system: LineSystem, length: int) -> dict[str, int]:
        """Return the scratch memory for each block of pixels, by storage block."""
        blocks = groups_for(length, self.BLOCK) * system.poles
        return {
            "sweep_value_block": system.value_bytes * blocks,
            "sweep_heat_block": system.scalar_bytes * blocks,
        }

    def _solve_band(self, band: Band) -> None:
        """Solve each line in one invocation, forth and back."""
        program = self._program(band, LINES_PER_GROUP=self.LINES_PER_GROUP, BLOCK=self.BLOCK)
        self._dispatch(program, groups_for(band.count, self.LINES_PER_GROUP), band)


# After Zhang, Cohen and Owens, "Fast tridiagonal solvers on the GPU" (2010), and Laszlo, Giles and
# Appleyard, "Manycore algorithms for batch scalar and block tridiagonal solvers" (2016). A whole
# line does not fit the 32 KiB of shared memory that OpenGL promises: it has 28 bytes a pixel.
class PartitionSolver(LineSolver):
    """Eliminates a run of pixels per invocation, then solves the ends of all runs.

    Runs stay in registers; their ends are solved by cyclic reduction in shared memory.
    """

    name = SolverName.PARTITION

    def _bytes_per_line(self, system: LineSystem, length: int) -> dict[str, int]:
        return {}

    def _bands(self, system: LineSystem, length: int, lines: int) -> Iterator[tuple[int, int]]:
        yield 0, lines

    @staticmethod
    def run_defines(system: LineSystem, length: int, count: int) -> dict[str, int]:
        """Return the shader's defines for how `count` lines of `length` pixels are divided.

        Four complex channels of more than RUN_LEAST pixels do not fit the registers of a GPU; they
        are solved in two parts then, in rows and columns alike.
        """
        fits = run_length(max(length, count)) == RUN_LEAST
        parts = 2 if system.is_complex and not fits else 1
        return {"RUN": run_length(length), "PARTS": parts, "IN_PARTS": 1}

    def _solve_band(self, band: Band) -> None:
        """Solve the listed segments of active tiles, several pixels in each invocation."""
        defines = self.run_defines(band.system, band.length, band.count)
        segments = band.tiles.rows if band.axis == "rows" else band.tiles.columns
        self._program(band, **defines).dispatch(
            segments,
            textures=band.bindings.textures,
            images=band.bindings.images,
            buffers={"segment_block": segments, **band.bindings.buffers},
            uniforms=band.bindings.uniforms,
        )


def _solver_class(name: SolverName) -> type[LineSolver]:
    """Return the class of the solver with this name."""
    match name:
        case SolverName.SWEEP:
            return SweepSolver
        case SolverName.PARTITION:
            return PartitionSolver
        case _:
            assert_never(name)


SOLVERS = {name: _solver_class(name) for name in SolverName}


def usual_solver(ctx: Device) -> LineSolver:
    """Return the faster solver for a GPU or a software rasterizer.

    The choice does not depend on a measurement, because solvers differ in the last digits, and
    several processes must render the frames of a shot alike.
    """
    # A measurement took 0.9 s of processor at each start, and digits depended on the load.
    return SweepSolver(ctx) if is_software(ctx) else PartitionSolver(ctx)
