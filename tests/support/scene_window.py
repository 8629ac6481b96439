"""The window with a small scene in it, for tests of what is done there."""

from dataclasses import replace

from heatlens.core.model.view.view import Compare
from support.gui import Gui
from support.session_files import QUICK


def as_opened(gui: Gui) -> Gui:
    """Return the scene as it was opened, in a small picture."""
    session, opened = gui.session, gui.session.source.opened.first
    small = replace(opened.shot.framing, width_px=96, height_px=54)
    session.editing.frame = opened.frame
    session.editing.begin(replace(opened.shot, defocus=QUICK, framing=small))
    session.pictures.view.state = replace(session.facts.view, compare=Compare.OFF, zoom=None)
    session.scenes.selected, session.messages.text = None, ""
    gui.io.add_mouse_pos_event(-1e4, -1e4)
    whole(gui)
    return gui


def whole(gui: Gui) -> None:
    """Go on until the whole picture is there."""
    gui.frame()  # what was asked for just now is begun
    session = gui.session
    gui.until(
        lambda: session.pictures.live.shown is not None and not session.time.scheduler.is_rendering,
        "the whole picture",
        120.0,
    )
    gui.frame(2)


def middle(gui: Gui) -> tuple[float, float]:
    """Return the window position of the picture's middle."""
    shape = gui.session.facts.picture_shape
    return gui.at_picture(shape.width_px / 2, shape.height_px / 2)
