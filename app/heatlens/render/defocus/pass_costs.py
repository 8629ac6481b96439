"""Compute how many bytes each pass of the pipeline moves, and the least possible.

moved   memory traffic of the shaders as they are written: every texel that a sweep over the
        picture reads counts once in that sweep (its neighbours find it in a cache), scratch counts
        each time it is written or read
least   inputs read once, outputs written once, at their storage sizes

All numbers are bytes per pixel. Work on listed pixels only (rims, hidden pixels, lamps) depends on
the plate and is left out: such a pass is marked `at_least`. Work on layers is counted as if each
layer covered the whole picture at full size: a pass that tile masks and smaller layers make cheaper
is marked `at_most`. Drawing a scene is not included, because it depends on the triangles.
Storage: picture rgba32f 16, coc r32f 4, kind r16f 2, layer rgba32f 16, its state rg32f 8, poles
rgba32ui 16 each.
"""

from dataclasses import dataclass
from typing import assert_never

from heatlens.render.defocus.blur_pass import pole_layers
from heatlens.render.defocus.highlight_pass import block_count
from heatlens.render.defocus.kernels import Kernel, named_kernel
from heatlens.render.defocus.line_solver import LineSystem, SolverName, SweepSolver
from heatlens.render.defocus.tile_mask import visibility_bytes
from heatlens.render.gpu.shader_constants import HIGHLIGHT_LEVELS

_COLOR, _COC, _STATE, _KIND, _PLACE, _POLE_LAYER = 16, 4, 8, 2, 8, 16
_AROUND = 2
_TALLY = 4 * HIGHLIGHT_LEVELS  # a block of 8 x 8 pixels
_LIT = 1 / 8  # a bit for each pixel that holds a highlight
_HALF_SIZE = 1 / 4  # pixels of a picture of half the size, for each pixel


@dataclass(frozen=True, slots=True)
class Work:
    """Everything besides the pixels of the plate on which the cost of a frame depends."""

    size: tuple[int, int]  # size of the working picture
    kernel: Kernel
    solver: SolverName
    proxy: float = 1.0


@dataclass(frozen=True, slots=True)
class Traffic:
    """Bytes per pixel of all runs in a frame; None if they depend only on the plate."""

    moved: float | None
    least: float | None
    at_least: bool = False
    at_most: bool = False


@dataclass(frozen=True, slots=True)
class AxisReads:
    """Bytes per pixel that a line system reads and writes along one axis.

    node     read for the conductances of a pixel in the network
    source   read for the right-hand side
    finish   read when the answer is stored, unless the pixel is still in registers
    written  size of the answer
    """

    node: int
    source: int
    finish: int
    written: int


def solve_bytes(solver: SolverName, system: LineSystem, reads: AxisReads) -> float:
    """Return the bytes per pixel to solve `system` along one axis."""
    poles, value, link = system.poles, system.value_bytes, 3 * system.scalar_bytes
    inputs = reads.node + reads.source
    match solver:
        case SolverName.PARTITION:  # everything in between stays on the chip
            return inputs + reads.written
        case SolverName.SWEEP:  # s and t of each block, written and read back; pixels twice
            blocks = poles * (value + system.scalar_bytes) / SweepSolver.BLOCK
            return 2 * inputs + 2 * blocks + reads.written
        case SolverName.CYCLIC:
            # Over a long line: LOAD writes a pixel and its links. For each pixel that is
            # eliminated, REDUCE reads it and one that stays, which it writes, and SUBSTITUTE reads
            # it and one answer beside it, and writes its own. STORE reads the answers.
            end = reads.finish + reads.written
            load = inputs + poles * (value + link)
            reduce = 3 * poles * (value + link)
            substitute = poles * (value + link + 2 * value)
            return load + reduce + substitute + poles * value + end
        case _:
            assert_never(solver)


def blur_bytes(solver: SolverName, kernel: Kernel) -> float:
    """Return the bytes per pixel of a blur: rows and columns for each step."""
    system = LineSystem("lib/blur_system.lib.glsl", len(kernel.poles), kernel.is_complex)
    poles = _POLE_LAYER * pole_layers(kernel)
    rows = AxisReads(_COC, _COLOR, 0, poles)
    columns = AxisReads(_COC, poles, _COC, _COLOR)  # the coc at the end: in focus?
    step = solve_bytes(solver, system, rows) + solve_bytes(solver, system, columns)
    return kernel.steps * step


def proxy_bytes(work: Work, runs: int) -> Traffic:
    """Count the whole plate read, and a smaller plate and the positions of highlights written.

    The depth is read again to find silhouettes.
    """
    depth_again = 2 * _COC / work.proxy**2
    least = _COLOR / work.proxy**2 + _COC + _COLOR + _COC + _PLACE
    return Traffic(runs * (least + depth_again), runs * least)


def coc_bytes(work: Work, runs: int) -> Traffic:
    """Count depth read and coc written."""
    return Traffic(2 * _COC * runs, 2 * _COC * runs)


def highlights_found_bytes(work: Work, runs: int) -> Traffic:
    """Count luminance and its heat blur at half size, and the split by it; highlights are extra.

    The least possible is to read color and coc and to write the picture without highlights.
    """
    inputs, outputs = _COLOR + _COC, _COLOR + _LIT
    surroundings = inputs + blur_bytes(work.solver, named_kernel("heat")) + _COLOR + _AROUND
    moved = inputs + _LIT + _HALF_SIZE * surroundings + inputs + outputs
    return Traffic(runs * moved, runs * (inputs + outputs), at_least=True)


def highlights_listed_bytes(work: Work, runs: int) -> Traffic:
    """Count one search for highlights; the counts of blocks are written."""
    width, height = work.size
    blocks = block_count(work.size) / (width * height)
    moved = _LIT + blocks * _TALLY
    return Traffic(runs * moved, runs * _LIT, at_least=True)


def fragments_bytes(work: Work, runs: int) -> Traffic:
    """Count coc read and the kind of each pixel written; rims are extra."""
    return Traffic(runs * (_COC + _KIND), runs * (_COC + _KIND), at_least=True)


def tiles_bytes(work: Work, runs: int) -> Traffic:
    """Count one read of the picture for any number of layers; words per tile are ignored."""
    return Traffic(_COC + _KIND, _COC + _KIND, at_least=True)


def layer_split_bytes(work: Work, runs: int) -> Traffic:
    """Count the picture read, the layer and its state written; fragments of rims are extra."""
    picture = _COLOR + _COC + _KIND
    moved = runs * (picture + _COLOR + _STATE)
    return Traffic(moved, moved, at_least=True)


def hidden_fill_bytes(work: Work, runs: int) -> Traffic:
    """Count whole copies of the masks; all other work is per hidden pixel."""
    width, height = work.size
    masks = 2 * visibility_bytes(work.size) / (width * height)
    return Traffic(runs * masks, None, at_least=True)


def coc_fill_bytes(work: Work, runs: int) -> Traffic:
    """Count rows and columns of the lines that carry the coc under nearer layers."""
    system = LineSystem("lib/fill_system.lib.glsl")
    rows = AxisReads(_STATE, 0, _STATE, _STATE)  # the state at the end: how much is content?
    columns = AxisReads(_STATE, _STATE, _STATE, _COC)
    moved = sum(solve_bytes(work.solver, system, reads) for reads in (rows, columns))
    return Traffic(runs * moved, runs * (_STATE + _COC), at_most=True)


def blur_pass_bytes(work: Work, runs: int) -> Traffic:
    """Count all steps of the kernel, and the picture that the layer is composited over."""
    moved = blur_bytes(work.solver, work.kernel) + _COLOR
    return Traffic(runs * moved, runs * (_COLOR + _COC + 2 * _COLOR), at_most=True)


def composite_bytes(work: Work, runs: int) -> Traffic:
    """Count a layer smaller than the picture, and the picture read and written."""
    moved = runs * 3 * _COLOR
    return Traffic(moved, moved, at_most=True)


def far_parts_bytes(work: Work, runs: int) -> Traffic:
    """Count a run as the blur of one view; how many surfaces are moved depends on the plate."""
    moved = blur_bytes(work.solver, work.kernel)
    return Traffic(runs * moved, None, at_least=True)


def limits_bytes(work: Work, runs: int) -> Traffic:
    """Count one picture, changed in place."""
    return Traffic(runs * 2 * _COLOR, runs * 2 * _COLOR)


def alpha_bytes(work: Work, runs: int) -> Traffic:
    """Count alpha read from the plate, and the picture read and written to take it."""
    taken_out, joined = _COLOR + _COLOR, _COLOR + _COLOR + _COLOR
    moved = runs / 2 * (taken_out + joined)
    return Traffic(moved, moved)


def colours_bytes(work: Work, runs: int) -> Traffic:
    """Count a picture read, and another one read and written to take its channels."""
    return Traffic(runs * 3 * _COLOR, runs * 3 * _COLOR)


def highlights_drawn_bytes(work: Work, runs: int) -> Traffic:
    """Count the area of the highlights' discs, which decides the cost."""
    return Traffic(None, None)


def method_bytes(work: Work, runs: int) -> Traffic:
    """Count colour and coc read, the picture written, and reads of neighbours by the coc."""
    moved = runs * (_COLOR + _COC + _COLOR)
    return Traffic(moved, moved, at_least=True)
