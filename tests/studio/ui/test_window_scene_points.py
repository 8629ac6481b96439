"""Points of a scene in the window: measured while it is drawn small, followed, seldom read."""

from collections.abc import Iterator
from dataclasses import replace

import pytest

from heatlens.core.model.focus.coc import coc_line, coc_px
from heatlens.core.model.marks.marks import PointMark
from heatlens.render.gpu.device import Device
from heatlens.render.gpu.textures import download
from heatlens.render.scene_gpu import scene_plate
from support.gui import Gui, gui_of
from support.scene_window import as_opened, middle, whole
from support.session_files import QUICK, write_scene

RIGHT = 1
LARGE = (480, 270)
MIDDLE = (240, 135)


@pytest.fixture(scope="module")
def window(session_context: Device, tmp_path_factory) -> Iterator[Gui]:
    scene = write_scene(tmp_path_factory.mktemp("scene") / "scene.glb")
    with gui_of(session_context, scene, defocus=QUICK) as gui:
        yield gui


@pytest.fixture
def gui(ctx: Device, window: Gui) -> Gui:
    return as_opened(window)


@pytest.fixture
def moving(gui: Gui, monkeypatch: pytest.MonkeyPatch) -> Iterator[Gui]:
    """Open a large scene that is being moved, so that it is drawn at the smallest scale."""
    session = gui.session
    width, height = LARGE
    session.editing.do(
        replace(
            session.facts.shot,
            framing=replace(session.scenes.framing, width_px=width, height_px=height),
        )
    )
    whole(gui)
    monkeypatch.setattr("heatlens.studio.session.opened.scene_preview._BUDGET_S", 0.0)
    monkeypatch.setattr("heatlens.studio.session.opened.scene_preview._REST_S", 60.0)
    gui.press(middle(gui), RIGHT)
    dragged(gui, 4.0)
    assert session.source.plate.display_window.width < width
    yield gui
    gui.release(RIGHT)


def dragged(gui: Gui, by: float) -> None:
    x, y = middle(gui)
    gui.move((x + by, y))
    gui.frame()


def test_nothing_of_whole_size_is_read_back_while_it_moves(moving, monkeypatch):
    read: list[object] = []
    monkeypatch.setattr(scene_plate, "download", lambda tx: read.append(tx) or download(tx))
    session, plates = moving.session, set()
    session.time.marks.set_point(MIDDLE)
    for step in range(1, 5):
        dragged(moving, 4.0 + step)
        plates.add(session.source.plate)
    assert len(plates) == 4 and read == []
    assert session.facts.histogram.heights.max() == 1.0  # all that is shown of it was known without


def test_a_point_is_measured_where_it_is_seen_however_small_it_is_drawn(moving):
    session, marks = moving.session, moving.session.time.marks
    marks.set_point(MIDDLE)
    (mark,) = session.facts.shot.marks
    assert mark == PointMark("A", *map(float, MIDDLE))
    expected = session.pictures.renderer.scene_depth_m(
        session.facts.shot, session.editing.frame, *MIDDLE
    )
    assert marks.distances.of_m(mark) == pytest.approx(expected, rel=0.02)
    assert marks.distances.of_m(replace(mark, x_px=float(LARGE[0]))) is None
    marks.set_point((LARGE[0], 3))
    assert "outside the picture" in session.messages.text and len(session.facts.shot.marks) == 1


def test_the_status_bar_counts_pixels_of_the_whole_picture_however_small_it_is_drawn(moving):
    session, (x, y) = moving.session, MIDDLE
    drawn_px, (_, whole) = (
        session.source.plate.display_window.width,
        session.source.feed.windows(session.facts.shot),
    )
    assert drawn_px < whole.width
    words = moving.screen.status.words(MIDDLE)
    assert words.startswith(f"x {x}  y {y}   picture")
    depth_m = session.pictures.renderer.scene_depth_m(
        session.facts.shot, session.editing.frame, x, y
    )
    blur_px = coc_px(depth_m, coc_line(session.facts.lens, whole.width))
    told_px = float(words.rpartition("blur ")[2].partition(" px")[0])
    assert told_px == pytest.approx(blur_px, rel=0.03, abs=0.02)


def test_a_pull_to_a_point_arrives_where_it_is_by_then(gui):
    session, marks = gui.session, gui.session.time.marks
    marks.set_point((48, 27))
    marks.pulls.frames = session.facts.shot.played.last - session.facts.shot.played.first
    marks.pulls.make()
    assert session.facts.shot.curves.focus_distance_m.keys[-1].value == pytest.approx(5.0, rel=1e-3)
