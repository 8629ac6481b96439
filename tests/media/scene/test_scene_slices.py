"""A scene is drawn in small slices, between which the window reads its input.

Work is counted in bands of a picture. Each band advances a clock of the test by a fixed time.
"""

from collections.abc import Iterator
from dataclasses import replace
from functools import partial

import pytest

from heatlens.core.model.boxes import Box
from heatlens.core.model.shot.settings import Method
from heatlens.render.gpu.device import Device
from heatlens.render.scene_gpu import bands
from heatlens.render.scene_gpu.raster import SceneRaster
from heatlens.studio.settings.preferences import Preferences, PreferenceValues
from support.gui import Gui, gui_of
from support.scene_window import picture_center, reset_scene, wait_for_whole_picture
from support.session_files import QUICK, write_scene

RIGHT = 1
SIZE = 320, 180
BAND_S = 0.01  # as long as a band may take where a view takes 30 ms
MOST_BANDS = 4  # between two reads of input: a slice of work and its last step
# The quickest picture through the lens of so small a scene: 16 views of half the size.
MOST_VIEWS_BANDS = 13


class Work:
    """Counts the bands of 64 rows that are drawn, and has a clock that advances with them."""

    def __init__(self) -> None:
        self.drawn = 0.0
        self.asked = 0

    def clock(self) -> float:
        self.asked += 1
        return BAND_S * self.drawn + 2e-3 * self.asked


@pytest.fixture(scope="module")
def window(session_context: Device, tmp_path_factory) -> Iterator[Gui]:
    scene = write_scene(tmp_path_factory.mktemp("scene") / "scene.glb")
    alone = Preferences(PreferenceValues(keep_frames=False))  # no frames are rendered ahead
    with gui_of(session_context, scene, alone, defocus=QUICK) as gui:
        yield gui


@pytest.fixture
def scene_gui(ctx: Device, window: Gui, monkeypatch) -> Gui:
    """Open a scene at rest whose picture is drawn in three bands."""
    monkeypatch.setattr(bands, "_LEAST_PX", SIZE[0] * 64)
    monkeypatch.setattr(bands, "is_software", lambda _: True)  # a GPU draws a small picture at once
    gui = reset_scene(window)
    raster = gui.session.pictures.renderer._source._raster
    raster.bands = bands.Bands(gui.ctx, raster.buffers.triangles_drawn)
    large = replace(gui.session.scenes.framing, width_px=SIZE[0], height_px=SIZE[1])
    gui.session.editing.do(replace(gui.session.facts.shot, framing=large))
    wait_for_whole_picture(gui)
    return gui


@pytest.fixture
def work(scene_gui: Gui, monkeypatch) -> Work:
    """Record everything that is drawn from now on."""
    found = Work()

    def counted(draw):
        def drawing(self, view, *rest, **options):
            band = next((it for it in rest if isinstance(it, Box)), Box(0, 0, *view.size))
            found.drawn += band.width * band.height / (SIZE[0] * 64)
            return draw(self, view, *rest, **options)

        return drawing

    for name in ("draw", "depth"):
        monkeypatch.setattr(SceneRaster, name, counted(getattr(SceneRaster, name)))
    session = scene_gui.session
    for part in (session.source.feed._preview, session.pictures.sides.a, session.pictures.sides.b):
        monkeypatch.setattr(part, "_clock", found.clock)
    session.pictures.sides.a.cost.seconds_per_px.clear()
    session.source.feed._preview._seconds_per_px = 2 * BAND_S / (SIZE[0] * 64)  # colour and depth
    return found


def max_bands_between_inputs(gui: Gui, work: Work, do) -> float:
    """Call `do`; return the most bands drawn between reads of input, until the picture is whole."""
    most = 0.0
    do()
    for _ in range(1000):
        before = work.drawn
        gui.frame()
        most = max(most, work.drawn - before)
        for _ in range(8):  # the window works on without a frame while nothing is new
            before = work.drawn
            gui.session.work()
            most = max(most, work.drawn - before)
        if not gui.session.time.scheduler.is_rendering:
            return most
    raise AssertionError("never whole")


def orbit_camera(gui: Gui) -> None:
    x, y = picture_center(gui)
    gui.drag((x, y), (x + 30, y + 10), RIGHT)
    gui.rest()


def test_undo_of_orbit_draws_few_bands_between_inputs(scene_gui, work):
    gui = scene_gui
    before = gui.session.scenes.pose
    orbit_camera(gui)
    assert gui.session.scenes.pose != before
    wait_for_whole_picture(gui)
    assert max_bands_between_inputs(gui, work, gui.session.editing.undo) <= MOST_BANDS
    assert gui.session.scenes.pose == before


def test_undo_during_a_frame_draws_few_bands_between_inputs(scene_gui, work, monkeypatch):
    """Undo within a frame, as a key does: after the camera moved, before a picture is requested."""
    gui, screen = scene_gui, scene_gui.screen
    orbit_camera(gui)
    wait_for_whole_picture(gui)
    actions = screen._do_commands
    undo_results = []

    def undoing() -> None:
        actions()
        if not undo_results:
            undo_results.append(gui.session.editing.undo())

    monkeypatch.setattr(screen, "_do_commands", undoing)
    assert max_bands_between_inputs(gui, work, lambda: None) <= MOST_BANDS
    assert undo_results


@pytest.mark.parametrize(
    ("method", "most"), [(Method.DIFFUSION, MOST_BANDS), (Method.ACCUMULATION, MOST_VIEWS_BANDS)]
)
def test_whole_image_is_drawn_in_small_steps(scene_gui, work, method, most):
    gui = scene_gui
    true = replace(gui.session.facts.shot.defocus, method=method, views=20)
    gui.session.editing.edit(replace(gui.session.facts.shot, defocus=true))
    wait_for_whole_picture(gui)
    look_through_side = partial(gui.session.scenes.look_through, "side")
    assert max_bands_between_inputs(gui, work, look_through_side) <= most
    assert work.drawn > 30


def test_unfinished_image_is_dropped_for_new_request(scene_gui, work):
    gui = scene_gui
    gui.session.scenes.look_through("side")
    for _ in range(6):
        gui.frame()
        gui.session.work()
    assert gui.session.time.scheduler.is_rendering
    before = work.drawn
    gui.session.scenes.look_through("main")
    gui.frame()
    assert work.drawn - before <= MOST_BANDS
    assert gui.session.pictures.live.output.shot.framing.camera == "main"


def test_nothing_is_drawn_while_nothing_changes(scene_gui, work):
    for _ in range(10):
        scene_gui.frame()
        scene_gui.session.work()
    assert work.drawn == 0
