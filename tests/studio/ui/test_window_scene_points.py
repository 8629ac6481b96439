"""Points of a scene in the window: measured and read out while the scene is drawn small."""

from collections.abc import Iterator
from dataclasses import replace

import pytest

from heatlens.core.model.focus.coc import coc_line, coc_px
from heatlens.core.model.marks.marks import PointMark
from heatlens.render.gpu.device import Device
from heatlens.render.scene_gpu import scene_plate
from support.gui import Gui
from support.scene_window import draw_small, picture_center, reset_scene, wait_for_whole_picture
from support.watched_calls import watch_calls

RIGHT = 1
LARGE = (480, 270)
MIDDLE = (240, 135)


@pytest.fixture
def gui(ctx: Device, window: Gui) -> Gui:
    return reset_scene(window)


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
    wait_for_whole_picture(gui)
    draw_small(gui, monkeypatch)
    gui.press(picture_center(gui), RIGHT)
    drag_right(gui, 4.0)
    assert session.source.plate.display_window.width < width
    yield gui
    gui.release(RIGHT)


def drag_right(gui: Gui, by: float) -> None:
    x, y = picture_center(gui)
    gui.move((x + by, y))
    gui.frame()


def test_moving_scene_downloads_no_depth(moving, monkeypatch):
    downloads = watch_calls(monkeypatch, scene_plate, "download")
    session, plates = moving.session, set()
    session.time.marks.set_point(MIDDLE)
    for step in range(1, 5):
        drag_right(moving, 4.0 + step)
        plates.add(session.source.plate)
    assert len(plates) == 4 and downloads == []
    assert session.facts.histogram.heights.max() == 1.0  # all that is shown of it was known without


def test_point_mark_is_measured_while_the_scene_is_drawn_small(moving):
    session, marks = moving.session, moving.session.time.marks
    marks.set_point(MIDDLE)
    (mark,) = session.facts.shot.marks
    assert mark == PointMark("A", *map(float, MIDDLE))
    expected = session.pictures.renderer.scene_depth_m(
        session.facts.shot, session.editing.frame, *MIDDLE
    )
    assert marks.distances.distance_m(mark) == pytest.approx(expected, rel=0.02)
    assert marks.distances.distance_m(replace(mark, x_px=float(LARGE[0]))) is None
    marks.set_point((LARGE[0], 3))
    assert "outside the picture" in session.messages.text and len(session.facts.shot.marks) == 1


def test_status_bar_counts_pixels_of_the_whole_size_of_a_moving_scene(moving):
    session, (x, y) = moving.session, MIDDLE
    drawn_px = session.source.plate.display_window.width
    (_, whole) = session.source.feed.windows(session.facts.shot)
    assert drawn_px < whole.width
    words = moving.screen.status.words(MIDDLE)
    assert words.startswith(f"x {x}  y {y}   picture")
    depth_m = session.pictures.renderer.scene_depth_m(
        session.facts.shot, session.editing.frame, x, y
    )
    blur_px = coc_px(depth_m, coc_line(session.facts.lens, whole.width))
    told_px = float(words.rpartition("blur ")[2].partition(" px")[0])
    assert told_px == pytest.approx(blur_px, rel=0.03, abs=0.02)


def test_pull_to_a_scene_point_uses_its_distance_on_arrival(gui):
    session, marks = gui.session, gui.session.time.marks
    marks.set_point((48, 27))
    marks.pulls.frames = (
        session.facts.shot.played_frames.last - session.facts.shot.played_frames.first
    )
    marks.pulls.make()
    assert session.facts.shot.curves.focus_distance_m.keys[-1].value == pytest.approx(5.0, rel=1e-3)
