"""Windows with a sequence or a scene, each shared by the tests of a file."""

from collections.abc import Iterator

import pytest

from heatlens.render.frame_renderer import FrameRenderer
from heatlens.render.gpu.device import Device
from support.gui import Gui, gui_of
from support.session_files import QUICK, write_scene
from support.timeline_window import film_window


@pytest.fixture(scope="module")
def film(session_context, tmp_path_factory) -> Iterator[Gui]:
    with film_window(session_context, tmp_path_factory.mktemp("film")) as gui:
        yield gui


@pytest.fixture(scope="module")
def window(session_context: Device, tmp_path_factory) -> Iterator[Gui]:
    scene = write_scene(tmp_path_factory.mktemp("scene") / "scene.glb")
    with gui_of(session_context, scene, defocus=QUICK) as gui:
        yield gui


@pytest.fixture(scope="module")
def other_renderer(session_context) -> FrameRenderer:
    """Return a renderer that is not the window's."""
    return FrameRenderer(session_context)
