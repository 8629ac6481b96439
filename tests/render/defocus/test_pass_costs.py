"""Memory traffic of passes as `heatlens bench` reports it, compared with counts by hand."""

from dataclasses import replace

import pytest

from heatlens.lab.measure.bench.measure import pass_row
from heatlens.lab.measure.bench.timing import PassSeconds
from heatlens.render.defocus.kernels import gaussian_kernel, named_kernel
from heatlens.render.defocus.line_solver import SOLVERS, LineSystem, SolverName, SweepSolver
from heatlens.render.defocus.pass_costs import AxisReads, Traffic, Work, solve_bytes
from heatlens.render.defocus.pass_list import PASSES, pass_named

SIZE = (64, 48)
HEAT, DISC_4 = named_kernel("heat"), named_kernel("disc_4")


def frame_traffic(name: str, work: Work, runs: int) -> Traffic:
    """Return the memory traffic of pass `name` per pixel for `runs` runs."""
    return pass_named(name).traffic(work, runs)


def test_solve_bytes_equals_count_by_hand():
    heat = LineSystem("lib/blur_system.lib.glsl", 1)
    disc = LineSystem("lib/blur_system.lib.glsl", 4, is_complex=True)
    heat_rows, disc_rows = (
        AxisReads(conductance=4, source=16, solution=16),
        AxisReads(conductance=4, source=16, solution=64),
    )
    # Read coc and colour twice; once in four pixels write s (rgba32f) and t, and read both.
    assert SweepSolver.BLOCK == 4
    assert solve_bytes(SolverName.SWEEP, heat, heat_rows) == 2 * (4 + 16) + 2 * (16 + 4) / 4 + 16
    assert (
        solve_bytes(SolverName.SWEEP, disc, disc_rows)
        == 2 * (4 + 16) + 2 * 4 * (32 + 8) / 4 + 4 * 16
    )
    assert solve_bytes(SolverName.PARTITION, heat, heat_rows) == 4 + 16 + 16
    assert solve_bytes(SolverName.PARTITION, disc, disc_rows) == 4 + 16 + 4 * 16


def test_pass_traffic_equals_count_by_hand():
    work = Work((640, 480), HEAT, SolverName.SWEEP)
    assert frame_traffic("coc", work, 1).moved == 4 + 4
    # Rows as above; columns: coc and half poles twice, kept there and back; the picture
    # is read and written.
    assert frame_traffic("blur", work, 1).moved == 66 + (2 * (4 + 16) + 10) + 16 + 16
    assert frame_traffic("blur", work, 1).least == 16 + 4 + 16 + 16
    # Rows: state twice, kept, rows; columns: state and rows twice, kept, coc.
    assert frame_traffic("coc fill", work, 2).moved == 2 * ((16 + 10 + 8) + (32 + 10 + 4))
    # Colour, coc and kind read; the layer and its state written.
    assert frame_traffic("layer split", work, 2).moved == 2 * ((16 + 4 + 2) + (16 + 8))
    assert frame_traffic("composite", work, 3).moved == 3 * (16 + 16 + 16)
    proxy = frame_traffic("proxy", replace(work, proxy=0.5), 1)
    assert proxy.least == 4 * 16 + 4 + 16 + 4 + 8
    assert proxy.moved == proxy.least + 2 * 4 * 4  # the depth again, for silhouettes
    # The bits of highlights once; of each 64 pixels five counts are written.
    assert frame_traffic("highlights listed", work, 1).moved == 1 / 8 + 5 * 4 / 64
    # Colour and coc twice, the rest and the bits written; at half size luminance and coc, the blur
    # without a picture below it, and the surroundings read and stored.
    blurred = 66 + (2 * (4 + 16) + 10) + 16
    half_size = (16 + 4 + blurred + 16 + 2) / 4
    found_traffic = frame_traffic("highlights found", work, 1)
    assert found_traffic.moved == 2 * (16 + 4) + half_size + 16 + 2 / 8
    assert found_traffic.least == 16 + 4 + 16 + 1 / 8
    assert frame_traffic("limits", work, 1).moved == 16 + 16
    assert frame_traffic("highlights drawn", work, 1).moved is None


@pytest.mark.parametrize("poles", [2, 3, 4, 5])
def test_blur_with_partition_moves_at_most_six_times_least(poles: int):
    """Count rows (coc, color in; poles out) and columns (coc, poles, picture in; picture out)."""
    traffic = frame_traffic(
        "blur", Work(SIZE, named_kernel(f"disc_{poles}"), SolverName.PARTITION), 1
    )
    assert traffic.moved == 4 + 16 + 16 * poles + 4 + 16 * poles + 16 + 16
    assert traffic.moved <= 6 * traffic.least


def test_blur_traffic_is_proportional_to_gaussian_steps():
    work = Work(SIZE, HEAT, SolverName.PARTITION)
    steps = replace(work, kernel=gaussian_kernel(5))
    many, one = (frame_traffic("blur", each, 1).moved - 16 for each in (steps, work))
    assert many == 5 * one  # but for the picture that the layer is composited over


@pytest.mark.parametrize("solver", SOLVERS)
@pytest.mark.parametrize("name", sorted({one.name for one in PASSES} - {"highlights drawn"}))
def test_moved_bytes_are_at_least_least_bytes(name, solver):
    for kernel in (HEAT, gaussian_kernel(3), named_kernel("disc_2"), DISC_4):
        traffic = frame_traffic(name, Work(SIZE, kernel, solver), 3)
        assert traffic.moved >= (traffic.least or 0.0) >= 0.0


def test_pass_row_rate_is_bytes_over_time():
    row = pass_row("coc", PassSeconds(1e-6, 1), Work((10, 10), HEAT, SolverName.SWEEP), 1.6e9)
    assert (row.bytes_moved, row.bytes_least, row.ms) == (800, 800, pytest.approx(1e-3))
    assert row.moved_gb_per_s == pytest.approx(0.8)
    assert row.copy_share == pytest.approx(0.5)


def test_pass_row_without_time_or_cost_has_no_rate():
    work = Work((10, 10), HEAT, SolverName.SWEEP)
    assert pass_row("coc", PassSeconds(0.0, 1), work, 1e9).moved_gb_per_s is None
    unknown = pass_row("a pass of tomorrow", PassSeconds(1.0, 1), work, 1e9)
    assert (unknown.bytes_moved, unknown.copy_share) == (None, None)
