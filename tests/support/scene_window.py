"""The window with a small scene in it, for tests of what is done there."""

from dataclasses import replace
from pathlib import Path

from heatlens.model.view import Compare
from support.gltf_files import GltfWriter
from support.gui import Gui
from support.window_plates import QUICK


def write_scene(path: Path) -> Path:
    """Write two squares, one of them moving away, and two cameras of different angle."""
    writer = GltfWriter()
    mesh = writer.mesh()
    near = writer.node(name="near", mesh=mesh, translation=[-0.5, -0.5, 0.0])
    writer.node(name="far", mesh=mesh, translation=[-2.0, -2.0, -4.0], scale=[4, 4, 1])
    writer.animate(near, "translation", [0.0, 1.0], [[-0.5, -0.5, 0.0], [-0.5, -0.5, -2.0]])
    for name, x, angle in (("main", 0.0, 0.7), ("side", 1.5, 0.4)):
        perspective = {"yfov": angle, "znear": 0.1, "aspectRatio": 1.5}
        camera = writer.add("cameras", type="perspective", perspective=perspective, name=name)
        writer.node(name=name, camera=camera, translation=[x, 0.0, 3.0])
    return writer.write(path)


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
