"""Sizes of the interface: layouts in letters, scales by the screen, windows that fit."""

from hypothesis import given
from hypothesis import strategies as st

from heatlens.studio.session.settings.ui_sizes import (
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


def test_pixels_are_scaled_and_nothing_else():
    doubled = scaled_layout(LAYOUT, 2.0)
    assert "Pos=1848,48\nSize=712,870\n" in doubled
    assert "ID=0x0D0BFA0C Window=0x00000002 Pos=0,48 Size=2560,1504" in doubled
    assert "SizeRef=1848,1504" in doubled and "Collapsed=0" in doubled
    assert "DockId=0x00000005,0" in doubled
    assert scaled_layout(LAYOUT, 1.0) == LAYOUT == scaled_layout(doubled, 0.5)


@given(st.sampled_from(SCALES))
def test_steps_go_through_all_scales_and_stop_at_the_ends(scale):
    assert next_scale(next_scale(scale, 1), -1) in (scale, SCALES[-2])
    assert SCALES[0] <= next_scale(scale, -3) <= scale <= next_scale(scale, 3) <= SCALES[-1]


def test_each_screen_has_its_own_scale_and_the_usual_one_is_not_kept():
    scales = with_scale(with_scale({}, "A", 1.5), "B", 2.0)
    assert scales == {"A": 1.5, "B": 2.0}
    assert with_scale(scales, "A", 1.0) == {"B": 2.0}


@given(*[st.tuples(st.integers(1, 9000), st.integers(1, 9000))] * 2)
def test_a_window_fits_into_its_screen(size, room):
    fitted = fitted_size(size, room)
    assert all(side <= most for side, most in zip(fitted, room, strict=True))
    assert fitted == size or size[0] > room[0] or size[1] > room[1]
