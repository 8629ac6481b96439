"""Compute how many bytes each pass of the pipeline moves, and the least possible.

moved   memory traffic of the shaders as they are written: every texel that a sweep over the
        picture reads counts once in that sweep (its neighbors find it in a cache), scratch counts
        each time it is written or read
least   inputs read once, outputs written once, at their storage sizes

A function counts the bytes of a pass for the work of a frame and the number of runs in that frame.

All numbers are bytes per pixel. Work on listed pixels only (edges, hidden pixels, lamps) depends on
the plate and is left out: such a pass is marked `at_least`. Work on layers is counted as if each
layer covered the whole picture at full size: a pass that tile masks and smaller layers make cheaper
is marked `at_most`. Drawing a scene is not included, because it depends on the triangles.
Storage: picture rgba32f 16, coc r32f 4, kind r16f 2, layer rgba32f 16, its state rg32f 8, poles
rgba32ui 16 each.
"""

from dataclasses import dataclass
from typing import assert_never

from heatlens.render.defocus.blur_pass import pole_layers
from heatlens.render.defocus.highlights.highlight_split import block_count
from heatlens.render.defocus.kernels import Kernel, named_kernel
from heatlens.render.defocus.line_solver import LineSystem, SolverName, SweepSolver
from heatlens.render.defocus.tile_mask import VisiblePixels
from heatlens.render.gpu.shader_constants import HIGHLIGHT_LEVELS

# Bytes of a pixel; a position of a highlight is a _POSITION, and the luminance around it _AROUND.
_COLOR, _COC, _STATE, _KIND, _POSITION, _POLE_LAYER = 16, 4, 8, 2, 8, 16
_AROUND = 2
_TALLY = 4 * HIGHLIGHT_LEVELS  # bytes of a block of 8 x 8 pixels
_LIT = 1 / 8  # a bit for each pixel that holds a highlight
_HALF_SIZE = 1 / 4  # pixels of a picture of half the size, for each pixel


@dataclass(frozen=True, slots=True)
class Work:
    """Everything besides the pixels of the plate on which the cost of a frame depends."""

    size: tuple[int, int]  # size of the working picture
    kernel: Kernel
    solver: SolverName
    proxy: float = 1.0  # scale of the working picture, relative to the plate


@dataclass(frozen=True, slots=True)
class Traffic:
    """Bytes per pixel of all runs of a pass in a frame.

    moved     memory traffic of the shaders; None if it depends only on the plate
    least     the least possible; None likewise
    at_least  work on listed pixels comes on top
    at_most   tile masks and smaller layers make the pass cheaper
    """

    moved: float | None
    least: float | None
    at_least: bool = False
    at_most: bool = False


@dataclass(frozen=True, slots=True)
class AxisReads:
    """Bytes per pixel that a line system reads and writes along one axis.

    conductance  read for the conductances of a pixel
    source       read for the right-hand side
    solution     written
    """

    conductance: int
    source: int
    solution: int


def solve_bytes(solver: SolverName, system: LineSystem, reads: AxisReads) -> float:
    """Return the bytes per pixel that a solver moves to solve `system` along one axis."""
    inputs = reads.conductance + reads.source
    match solver:
        case SolverName.PARTITION:  # everything in between stays on the chip
            return inputs + reads.solution
        case SolverName.SWEEP:  # the state of each block, written and read back; pixels twice
            state = system.poles * (system.value_bytes + system.scalar_bytes)
            blocks = state / SweepSolver.BLOCK
            return 2 * inputs + 2 * blocks + reads.solution
        case _:
            assert_never(solver)


def blur_bytes(solver: SolverName, kernel: Kernel) -> float:
    """Return the bytes per pixel of a blur: rows and columns for each step."""
    system = LineSystem("lib/blur_system.lib.glsl", len(kernel.poles), kernel.is_complex)
    poles = _POLE_LAYER * pole_layers(kernel)
    rows = AxisReads(conductance=_COC, source=_COLOR, solution=poles)
    columns = AxisReads(conductance=_COC, source=poles, solution=_COLOR)
    step = solve_bytes(solver, system, rows) + solve_bytes(solver, system, columns)
    return kernel.steps * step


def proxy_bytes(work: Work, runs: int) -> Traffic:
    """Count the bytes to reduce a plate and to find the positions of its highlights.

    The whole plate is read, and the reduced plate and the positions are written. The depth is read
    again to find silhouettes.
    """
    depth_again = 2 * _COC / work.proxy**2
    least = _COLOR / work.proxy**2 + _COC + _COLOR + _COC + _POSITION
    return Traffic(runs * (least + depth_again), runs * least)


def coc_bytes(work: Work, runs: int) -> Traffic:
    """Count the bytes of the depth read and the coc written."""
    return Traffic(2 * _COC * runs, 2 * _COC * runs)


def highlights_found_bytes(work: Work, runs: int) -> Traffic:
    """Count the bytes to find highlights; the work on the highlights themselves is extra.

    The luminance is blurred as heat at half size, and the picture is split by it. The least
    possible is to read color and coc and to write the picture without highlights.
    """
    inputs, outputs = _COLOR + _COC, _COLOR + _LIT
    surroundings = inputs + blur_bytes(work.solver, named_kernel("heat")) + _COLOR + _AROUND
    moved = inputs + _LIT + _HALF_SIZE * surroundings + inputs + outputs
    return Traffic(runs * moved, runs * (inputs + outputs), at_least=True)


def highlights_listed_bytes(work: Work, runs: int) -> Traffic:
    """Count the bytes of one search for pixels with highlights, and of the counts of blocks."""
    width, height = work.size
    blocks = block_count(work.size) / (width * height)
    moved = _LIT + blocks * _TALLY
    return Traffic(runs * moved, runs * _LIT, at_least=True)


def unmix_bytes(work: Work, runs: int) -> Traffic:
    """Count the bytes of the coc read and the kind of each pixel written; edges are extra."""
    return Traffic(runs * (_COC + _KIND), runs * (_COC + _KIND), at_least=True)


def tiles_bytes(work: Work, runs: int) -> Traffic:
    """Count the bytes of one read of the picture for all layers; words per tile are ignored."""
    return Traffic(_COC + _KIND, _COC + _KIND, at_least=True)


def layer_split_bytes(work: Work, runs: int) -> Traffic:
    """Count the bytes of the picture read and the layer written; edge pixels are extra."""
    picture = _COLOR + _COC + _KIND
    moved = runs * (picture + _COLOR + _STATE)
    return Traffic(moved, moved, at_least=True)


def hidden_fill_bytes(work: Work, runs: int) -> Traffic:
    """Count the bytes to write and read the masks of visible pixels and of their words.

    Hidden pixels and the pixels of active tiles are extra.
    """
    width, height = work.size
    masks = 4 * VisiblePixels.bytes_for(work.size) / (width * height)
    return Traffic(runs * masks, None, at_least=True)


def coc_fill_bytes(work: Work, runs: int) -> Traffic:
    """Count the bytes to fill in the coc that nearer layers hide, along rows, then columns."""
    system = LineSystem("lib/fill_system.lib.glsl")
    # At the end the state is read again, for the share of content. For rows it is all that is
    # read; columns also read the solution of the rows.
    rows = AxisReads(conductance=_STATE, source=0, solution=_STATE)
    columns = AxisReads(conductance=_STATE, source=_STATE, solution=_COC)
    moved = sum(solve_bytes(work.solver, system, reads) for reads in (rows, columns))
    return Traffic(runs * moved, runs * (_STATE + _COC), at_most=True)


def blur_pass_bytes(work: Work, runs: int) -> Traffic:
    """Count the bytes of all steps of the kernel, and of the picture composited over."""
    moved = blur_bytes(work.solver, work.kernel) + _COLOR
    return Traffic(runs * moved, runs * (_COLOR + _COC + 2 * _COLOR), at_most=True)


def composite_bytes(work: Work, runs: int) -> Traffic:
    """Count the bytes of a layer read, and of the picture read and written."""
    moved = runs * 3 * _COLOR
    return Traffic(moved, moved, at_most=True)


def far_parts_bytes(work: Work, runs: int) -> Traffic:
    """Count the bytes to blur the view of one part of the lens in each run.

    How many surfaces are moved depends on the plate, and is left out.
    """
    moved = blur_bytes(work.solver, work.kernel)
    return Traffic(runs * moved, None, at_least=True)


def near_zones_bytes(work: Work, runs: int) -> Traffic:
    """Count the bytes of the coc that is searched for edges; the lists depend on the plate."""
    return Traffic(runs * 4, None, at_least=True)


def limits_bytes(work: Work, runs: int) -> Traffic:
    """Count the bytes of one picture, read and written in place."""
    return Traffic(runs * 2 * _COLOR, runs * 2 * _COLOR)


def alpha_bytes(work: Work, runs: int) -> Traffic:
    """Count the bytes to copy alpha to a picture of its own, and back; half the runs do each."""
    taken_out, joined = _COLOR + _COLOR, _COLOR + _COLOR + _COLOR
    moved = runs / 2 * (taken_out + joined)
    return Traffic(moved, moved)


def colours_bytes(work: Work, runs: int) -> Traffic:
    """Count the bytes of a picture read, and of another one that takes its channels."""
    return Traffic(runs * 3 * _COLOR, runs * 3 * _COLOR)


def highlights_drawn_bytes(work: Work, runs: int) -> Traffic:
    """Return unknown traffic: only the area of the highlights' discs decides the cost."""
    return Traffic(None, None)


def method_bytes(work: Work, runs: int) -> Traffic:
    """Count the bytes of color and coc read, and the picture written; reads of discs are extra."""
    moved = runs * (_COLOR + _COC + _COLOR)
    return Traffic(moved, moved, at_least=True)
