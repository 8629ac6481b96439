"""Large pictures: what blurring them needs is within what OpenGL gives, or is refused."""

import pytest

from heatlens.base.errors import GpuError
from heatlens.defocus.line_solver import SOLVERS
from heatlens.gpu.context import check_texture_fits

LEAST_TEXTURE_PX = 16384  # a side, that any driver of today takes


@pytest.mark.parametrize("size", [(4096, 2160), (7680, 4320), (8192, 4320)])
def test_pictures_up_to_8k_can_be_blurred(session_context, size):
    for solver in SOLVERS.values():
        assert max(solver(session_context).between_size(size)) <= LEAST_TEXTURE_PX


def test_a_texture_beyond_the_largest_is_refused_with_a_remedy(session_context):
    with pytest.raises(GpuError, match=r"picture of 16000x16000 needs .*A smaller --proxy"):
        check_texture_fits(session_context, (16000, 16000), (4096, 1 << 20))
    check_texture_fits(session_context, (640, 360), (4096, 80))
