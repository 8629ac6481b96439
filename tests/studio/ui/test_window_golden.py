"""The picture in the window against a golden picture: overlay, wipe with its handle, legend."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from heatlens.core.model.shot.settings import Bokeh, DefocusSettings, Quality
from heatlens.core.model.view.view import Compare
from support.golden import compare_with_golden
from support.gui import gui_of
from support.session_files import room_file

GOLDEN = Path(__file__).with_name("golden") / "overlay_and_wipe.exr"
SIZE = (1280, 800)
PICTURE = (240, 160)


@pytest.fixture
def gui(ctx, tmp_path):
    plate = room_file(tmp_path / "room.exr", *PICTURE)
    settings = DefocusSettings(Bokeh.DISC, Quality.DRAFT)
    with gui_of(ctx, plate, defocus=settings, size=SIZE) as gui:
        yield gui


def viewport_pixels(gui) -> np.ndarray:
    """Return (H, W, 3) in 0..1: the viewport without the panels around it."""
    viewport = gui.session.pictures.view.viewport
    x, y = (round(value) for value in viewport.corner)
    width, height = (round(side) for side in viewport.size)
    return gui.screenshot()[y : y + height, x : x + width].astype(np.float32) / 255


def test_window_with_overlay_and_wipe_equals_the_golden_picture(ctx, gui, request, tmp_path):
    gui.session.pictures.view.state = replace(
        gui.session.facts.view, overlay="zones", compare=Compare.WIPE, wipe=0.4, zoom=2.0
    )
    gui.settled()
    is_updating = request.config.getoption("--update-golden")
    compare_with_golden(viewport_pixels(gui), GOLDEN, ctx, is_updating, tmp_path)
