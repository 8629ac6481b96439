"""Between two looks for input little of a scene is drawn, whatever was asked for in between.

Work is counted in bands of a picture, each of which takes its time on a clock of the test's own.
"""

from collections.abc import Iterator
from dataclasses import replace

import pytest

from heatlens.core.model.boxes import Box
from heatlens.core.model.shot.settings import Method
from heatlens.render.gpu.device import Device
from heatlens.render.scene_gpu import bands
from heatlens.render.scene_gpu.raster import SceneRaster
from heatlens.studio.session.settings.preferences import Preferences, Remembered
from support.gui import Gui, gui_of
from support.scene_window import as_opened, middle, whole
from support.session_files import QUICK, write_scene

RIGHT = 1
SIZE = 320, 180
BAND_S = 0.01  # as long as a band may take where a view takes 30 ms
MOST_BANDS = 4  # between two looks for input: a slice of work and the step that it ends with
# The quickest picture through the lens of so small a scene: 16 views of half the size.
MOST_VIEWS_BANDS = 13


class Work:
    """Counts what is drawn, in bands of 64 rows; its clock runs with it."""

    def __init__(self) -> None:
        self.drawn = 0.0
        self.asked = 0

    def clock(self) -> float:
        self.asked += 1
        return BAND_S * self.drawn + 2e-3 * self.asked


@pytest.fixture(scope="module")
def window(session_context: Device, tmp_path_factory) -> Iterator[Gui]:
    scene = write_scene(tmp_path_factory.mktemp("scene") / "scene.glb")
    alone = Preferences(Remembered(keep_frames=False))  # no frames are rendered ahead
    with gui_of(session_context, scene, alone, defocus=QUICK) as gui:
        yield gui


@pytest.fixture
def scene_gui(ctx: Device, window: Gui, monkeypatch) -> Gui:
    """Open a scene at rest whose picture is drawn in three bands."""
    monkeypatch.setattr(bands, "_LEAST_PX", SIZE[0] * 64)
    monkeypatch.setattr(bands, "is_software", lambda _: True)  # a GPU draws a small picture at once
    gui = as_opened(window)
    raster = gui.session.pictures.renderer._source._raster
    raster.bands = bands.Bands(gui.ctx, raster.buffers.triangles_drawn)
    large = replace(gui.session.scenes.framing, width_px=SIZE[0], height_px=SIZE[1])
    gui.session.editing.do(replace(gui.session.facts.shot, framing=large))
    whole(gui)
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


def most_between_looks(gui: Gui, work: Work, do) -> float:
    """Bands drawn at most from one look for input to the next, until the picture is whole."""
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


def orbit(gui: Gui) -> None:
    x, y = middle(gui)
    gui.drag((x, y), (x + 30, y + 10), RIGHT)
    gui.rest()


def test_undo_of_an_orbit_is_answered_at_once(scene_gui, work):
    gui = scene_gui
    before = gui.session.scenes.pose
    orbit(gui)
    assert gui.session.scenes.pose != before
    whole(gui)
    assert most_between_looks(gui, work, gui.session.editing.undo) <= MOST_BANDS
    assert gui.session.scenes.pose == before


def test_undo_in_the_middle_of_a_frame_is_answered_at_once(scene_gui, work, monkeypatch):
    """As a key does it: after the scene was looked at, before its picture is wished for."""
    gui, screen = scene_gui, scene_gui.screen
    orbit(gui)
    whole(gui)
    actions = screen._do_actions
    undone = []

    def undoing() -> None:
        actions()
        if not undone:
            undone.append(gui.session.editing.undo())

    monkeypatch.setattr(screen, "_do_actions", undoing)
    assert most_between_looks(gui, work, lambda: None) <= MOST_BANDS
    assert undone


@pytest.mark.parametrize(
    ("method", "most"),
    [(Method.DIFFUSION, MOST_BANDS), (Method.ACCUMULATION, MOST_VIEWS_BANDS)],
)
def test_the_whole_picture_comes_in_small_steps(scene_gui, work, method, most):
    gui = scene_gui
    true = replace(gui.session.facts.shot.defocus, method=method, views=20)
    gui.session.editing.edit(replace(gui.session.facts.shot, defocus=true))
    whole(gui)
    look_through = lambda: gui.session.scenes.look_through("side")  # noqa: E731
    assert most_between_looks(gui, work, look_through) <= most
    assert work.drawn > 30


def test_what_is_half_done_is_given_up_for_another_wish(scene_gui, work):
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
    assert gui.session.pictures.live.shown.shot.framing.camera == "main"


def test_nothing_is_drawn_while_nothing_changes(scene_gui, work):
    for _ in range(10):
        scene_gui.frame()
        scene_gui.session.work()
    assert work.drawn == 0
