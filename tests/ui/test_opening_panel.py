"""The opening as the Lens panel draws it, and as the hand changes it there."""

from collections.abc import Iterator
from pathlib import Path

import moderngl
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from heatlens.model.aperture import Aperture
from heatlens.model.disc_shape import DiscShape
from heatlens.model.picture_field import PictureField
from heatlens.ui.panels.opening_panel import disc_outline
from support.apertures import apertures
from support.gui import Gui, gui_of
from support.window_plates import QUICK, room_file

PLACES = st.sampled_from([(800.0, 450.0), (1600.0, 0.0)])


@given(apertures(), PLACES)
def test_the_outline_is_that_of_the_disc(aperture: Aperture, place: tuple[float, float]) -> None:
    """Just inside it a lamp is lit, just outside it is dark."""
    disc = DiscShape(aperture, 1.0, PictureField.of((1600, 900)))
    x, y = disc_outline(aperture, place).T
    lit = disc.coverage(0.98 * x, 0.98 * y, 1.0, 1e-3, place)
    dark = disc.coverage(1.02 * x, 1.02 * y, 1.0, 1e-3, place)
    reached = np.hypot(x, y) > 0.3
    assert np.all(lit[reached] > 0.0)
    assert not dark[reached].any()


@pytest.fixture
def gui(ctx: moderngl.Context, tmp_path: Path) -> Iterator[Gui]:
    plate = room_file(tmp_path / "room.exr", 96, 64)
    lens = {"blades": 5, "cat_eye": 0.5}
    with gui_of(ctx, plate, lens=lens, defocus=QUICK, size=(1280, 1600)) as made:
        yield made


def test_a_control_of_the_opening_is_one_step_of_undo(gui: Gui) -> None:
    gui.settled()
    left, top, right, bottom = gui.rect("rim")
    y = (top + bottom) / 2
    gui.drag(((left + right) / 2, y), (0.1 * left + 0.9 * right, y))
    gui.rest()
    assert gui.session.lens.rim > 0.5
    gui.session.editing.undo()
    assert gui.session.lens.rim == 0.0 and gui.session.lens.blades == 5
