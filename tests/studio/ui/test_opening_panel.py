"""The opening of the lens as the Lens panel draws it, and its controls."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from imgui_bundle import imgui

from heatlens.core.model.lens.aperture import Aperture
from heatlens.core.model.lens.disc_shape import DiscShape, PictureField
from heatlens.render.gpu.device import Device
from heatlens.studio.settings.file_purposes import PURPOSES
from heatlens.studio.ui.panels.opening_panel import disc_outline, image_cells
from support.apertures import apertures
from support.gui import Gui, gui_of
from support.opening_images import heart_path, letter
from support.session_files import QUICK, room_file

POSITIONS = st.sampled_from([(800.0, 450.0), (1600.0, 0.0)])


@given(apertures(), POSITIONS)
def test_disc_outline_is_the_edge_of_the_coverage(
    aperture: Aperture, position: tuple[float, float]
) -> None:
    """The disc covers points at 0.98 of the outline, and none at 1.02 of it."""
    disc = DiscShape(aperture, pixel_aspect_ratio=1.0, in_picture=PictureField.of((1600, 900)))
    x, y = disc_outline(aperture, position).T
    inside = disc.coverage(0.98 * x, 0.98 * y, 1.0, 1e-3, position)
    outside = disc.coverage(1.02 * x, 1.02 * y, 1.0, 1e-3, position)
    is_checked = np.hypot(x, y) > 0.3
    assert np.all(inside[is_checked] > 0.0)
    assert not outside[is_checked].any()


@pytest.fixture
def gui(ctx: Device, tmp_path: Path) -> Iterator[Gui]:
    plate = room_file(tmp_path / "room.exr", 96, 64)
    lens = {"blades": 5, "cat_eye": 0.5}
    with gui_of(ctx, plate, lens=lens, defocus=QUICK, size=(1280, 1600)) as new_gui:
        yield new_gui


def test_rim_slider_of_the_opening_is_one_undo_step(gui: Gui) -> None:
    gui.settled()
    left, top, right, bottom = gui.rect("rim")
    y = (top + bottom) / 2
    gui.drag(((left + right) / 2, y), (0.1 * left + 0.9 * right, y))
    gui.rest()
    assert gui.session.facts.lens.rim > 0.5
    gui.session.editing.undo()
    assert gui.session.facts.lens.rim == 0.0 and gui.session.facts.lens.blades == 5


def test_aperture_image_is_chosen_turned_and_removed(gui: Gui, tmp_path: Path) -> None:
    """Each change is one undo step; without the image the blades are as before."""
    gui.settled()
    gui.click(gui.middle("aperture image"))
    assert gui.ui.dialogs.walk.purpose is PURPOSES["opening"]
    gui.key(imgui.Key.escape)
    files = gui.session.files.commands
    files.openings.begin(tmp_path / "none.png")
    gui.until(lambda: "none.png is not there" in gui.session.messages.text, "what is wrong")
    assert gui.session.facts.lens.aperture_image is None
    files.openings.begin(heart_path())
    gui.until(lambda: gui.session.facts.lens.aperture_image is not None, "the heart")
    assert "aperture_heart.png" in gui.session.messages.text
    gui.frame(3)
    left, top, right, bottom = gui.rect("rotation")
    gui.drag(((left + right) / 2, (top + bottom) / 2), (right - 2, (top + bottom) / 2))
    gui.rest()
    assert gui.session.facts.lens.blade_rotation_deg > 0
    gui.click(gui.middle("no aperture image"))
    gui.rest()
    assert gui.session.facts.lens.aperture_image is None and gui.session.facts.lens.blades == 5
    for rotation in (None, 0.0):
        gui.session.editing.undo()
        assert gui.session.facts.lens.aperture_image is not None
        assert rotation is None or gui.session.facts.lens.blade_rotation_deg == rotation
    gui.session.editing.undo()
    assert gui.session.facts.lens.aperture_image is None


def test_image_cells_of_an_aperture_equal_its_coverage() -> None:
    aperture = Aperture(aperture_image=letter(), cat_eye=0.6)
    for position in ((800.0, 450.0), (1600.0, 0.0)):
        rows = image_cells(aperture, position)
        drawn_values = np.zeros((len(rows), len(rows)))
        for row, runs in enumerate(rows):
            for first, last, grey in runs:
                drawn_values[row, first:last] = grey
        y, x = np.mgrid[0 : len(rows), 0 : len(rows)] + 0.5 - len(rows) / 2
        disc = DiscShape(aperture, pixel_aspect_ratio=1.0, in_picture=PictureField.of((1600, 900)))
        coverage = disc.coverage(x, y, len(rows) / 2, 0.5, position)
        np.testing.assert_allclose(drawn_values**2.2, coverage / coverage.max(), atol=0.04)
