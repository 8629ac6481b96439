"""Helpers for tests of a window with a small scene."""

from dataclasses import replace

import pytest

from heatlens.core.model.view.view import Compare
from support.gui import Gui
from support.session_files import QUICK


def reset_scene(gui: Gui) -> Gui:
    """Reset the window to the scene as it was opened, in a small picture. Return the window."""
    session, opened = gui.session, gui.session.source.opened.first
    small = replace(opened.shot.framing, width_px=96, height_px=54)
    session.editing.frame = opened.frame
    session.editing.begin(replace(opened.shot, defocus=QUICK, framing=small))
    session.pictures.view.state = replace(session.facts.view, compare=Compare.OFF, zoom=None)
    session.scenes.selected, session.messages.text = None, ""
    gui.io.add_mouse_pos_event(-1e4, -1e4)
    wait_for_whole_picture(gui)
    return gui


def draw_small(gui: Gui, monkeypatch: pytest.MonkeyPatch) -> None:
    """Leave no time for drawing the open scene while it moves, and let it not come to rest."""
    preview = gui.session.source.feed._preview
    monkeypatch.setattr(preview, "budget_s", 0.0)
    monkeypatch.setattr(preview, "rest_s", 60.0)


def wait_for_whole_picture(gui: Gui) -> None:
    """Draw frames until the whole picture is rendered."""
    gui.frame()  # what was asked for just now is begun
    session = gui.session
    gui.until(
        lambda: (
            session.pictures.live.output is not None and not session.time.scheduler.is_rendering
        ),
        "the whole picture",
        120.0,
    )
    gui.frame(2)


def picture_center(gui: Gui) -> tuple[float, float]:
    """Return the window position of the picture's middle."""
    shape = gui.session.facts.shape
    return gui.at_picture(shape.width_px / 2, shape.height_px / 2)
