"""Sizes of the interface: scaled layouts, scales of each screen, windows that fit."""

from hypothesis import given
from hypothesis import strategies as st

from heatlens.core.model.view.ui_sizes import (
    SCALES,
    fitted_size,
    next_scale,
    scaled_layout,
    with_scale,
)

LAYOUT = """[Window][Lens]
Pos=924,24
Size=356,435
Collapsed=0
DockId=0x00000005,0

[Docking][Data]
DockSpace     ID=0x0D0BFA0C Window=0x00000002 Pos=0,24 Size=1280,752 Split=X
  DockNode    ID=0x00000001 Parent=0x0D0BFA0C SizeRef=924,752 Split=Y
"""


def test_scaled_layout_scales_pixels_only():
    doubled = scaled_layout(LAYOUT, 2.0)
    assert "Pos=1848,48\nSize=712,870\n" in doubled
    assert "ID=0x0D0BFA0C Window=0x00000002 Pos=0,48 Size=2560,1504" in doubled
    assert "SizeRef=1848,1504" in doubled and "Collapsed=0" in doubled
    assert "DockId=0x00000005,0" in doubled
    assert scaled_layout(LAYOUT, 1.0) == LAYOUT == scaled_layout(doubled, 0.5)


@given(st.sampled_from(SCALES))
def test_next_scale_steps_through_scales_and_stops_at_the_ends(scale):
    assert next_scale(next_scale(scale, 1), -1) in (scale, SCALES[-2])
    assert SCALES[0] <= next_scale(scale, -3) <= scale <= next_scale(scale, 3) <= SCALES[-1]


def test_with_scale_keeps_one_scale_per_screen_except_one():
    scales = with_scale(with_scale({}, "A", 1.5), "B", 2.0)
    assert scales == {"A": 1.5, "B": 2.0}
    assert with_scale(scales, "A", 1.0) == {"B": 2.0}


@given(*[st.tuples(st.integers(1, 9000), st.integers(1, 9000))] * 2)
def test_fitted_size_fits_into_the_screen(size, screen_size):
    fitted = fitted_size(size, screen_size)
    assert all(side <= limit for side, limit in zip(fitted, screen_size, strict=True))
    assert fitted == size or size[0] > screen_size[0] or size[1] > screen_size[1]
