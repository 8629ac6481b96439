"""Large pictures: the textures of a blur fit into the limits of OpenGL, or are rejected."""

import pytest

from heatlens.core.base.errors import GpuError
from heatlens.render.defocus.line_solver import SOLVERS, SolverName
from heatlens.render.gpu.context import check_texture_fits
from heatlens.render.gpu.shader_constants import STRIP_COLUMNS, STRIP_TEXELS

LEAST_TEXTURE_PX = 16384  # a side, that any driver of today takes


@pytest.mark.parametrize("size", [(4096, 2160), (7680, 4320), (8192, 4320)])
def test_pictures_up_to_8k_fit_texture_limit(session_context, size):
    for solver in SOLVERS.values():
        assert max(solver(session_context).size_between_axes(size)) <= LEAST_TEXTURE_PX


@pytest.mark.parametrize("size", [(1, 1), (640, 360), (1921, 1081), (3840, 513)])
def test_strips_of_sweep_solver_waste_less_than_one_texture_row(session_context, size):
    columns = -(-size[0] // STRIP_COLUMNS) * STRIP_COLUMNS
    across, down = SOLVERS[SolverName.SWEEP](session_context).size_between_axes(size)
    assert 0 <= across * down - columns * size[1] < STRIP_TEXELS


def test_too_large_texture_is_rejected_with_a_remedy(session_context):
    with pytest.raises(GpuError, match=r"picture of 16000x16000 needs .*A smaller --proxy"):
        check_texture_fits(session_context, (16000, 16000), (4096, 1 << 20))
    check_texture_fits(session_context, (640, 360), (4096, 80))
