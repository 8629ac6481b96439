"""Marks of a scene behind the focus curve: measured while nothing moves, and once."""

from collections.abc import Iterator
from dataclasses import replace

import pytest
from imgui_bundle import imgui

from heatlens.core.model.marks.marks import DistanceMark, ObjectMark, PointMark
from heatlens.core.model.shot.lens_parameter import LensParameter
from heatlens.render.frame_renderer import FrameRenderer
from heatlens.render.gpu.device import Device
from heatlens.studio.session.marks import mark_measuring
from support.gui import Gui, gui_of
from support.scene_window import as_opened, whole
from support.session_files import QUICK, write_scene
from support.timeline_window import reset_timeline

MIDDLE = PointMark("A", 48.0, 27.0)
NEAR = ObjectMark("B", "near")
K = imgui.Key


@pytest.fixture(scope="module")
def window(session_context: Device, tmp_path_factory) -> Iterator[Gui]:
    scene = write_scene(tmp_path_factory.mktemp("scene") / "scene.glb")
    with gui_of(session_context, scene, defocus=QUICK) as gui:
        yield gui


@pytest.fixture
def gui(ctx: Device, window: Gui) -> Gui:
    """Open a scene and show the curve of its focus; there are no marks."""
    reset_timeline(window)
    gui = as_opened(window)
    gui.session.editing.begin(gui.session.facts.shot.with_key(1, LensParameter.FOCUS_DISTANCE, 3.0))
    gui.key(K.c, shift=True)
    gui.frame(2)
    assert gui.session.time.keys.rows.shows_curve
    return gui


@pytest.fixture
def drawn(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """Return the frames that distances were asked at."""
    frames: list[int] = []
    measure = FrameRenderer.scene_depth_m

    def asked(renderer: FrameRenderer, shot, frame: int, x: int, y: int) -> float:
        frames.append(frame)
        return measure(renderer, shot, frame, x, y)

    monkeypatch.setattr(FrameRenderer, "scene_depth_m", asked)
    return frames


def marked(gui: Gui, *marks) -> None:
    gui.session.editing.begin(replace(gui.session.facts.shot, marks=marks))


def measured(gui: Gui) -> list[dict[int, float]]:
    """Return dioptres by frame of each mark, once all are known."""
    tracks = gui.session.time.scene_tracks
    gui.until(lambda: tracks._next() is None, "all marks")
    return [dict(at for line in track.lines for at in line) for track in tracks.tracks()]


def test_marks_of_a_scene_have_a_line_over_its_frames(gui):
    marked(gui, MIDDLE, DistanceMark("C", 2.0), NEAR)
    frames = gui.session.time.timeline.frames
    for found in measured(gui):  # a square goes from 3 m to 5 m
        assert list(found) == list(range(frames.first, frames.last + 1))
        for frame, dioptres in found.items():
            share = (frame - frames.first) / (frames.count - 1)
            assert 1 / dioptres == pytest.approx(3.0 + 2.0 * share, rel=1e-3)
    assert [track.name for track in gui.session.time.mark_tracks()] == ["A", "B"]


def test_a_moment_measures_a_part_and_the_window_goes_on(gui, drawn, monkeypatch):
    monkeypatch.setattr(mark_measuring, "_SLICE_S", 1e-9)
    marked(gui, MIDDLE)
    tracks = gui.session.time.scene_tracks
    gui.until(lambda: tracks.is_due, "a still picture")
    drawn.clear()
    monkeypatch.setattr(mark_measuring, "_SLICE_S", 1e-3)
    gui.frame(2)
    assert 0 < len(drawn) < gui.session.time.timeline.frames.count
    assert 0 < gui.session.seconds_until_needed() < 0.05  # or the rest would never come


def test_what_is_known_is_not_measured_again(gui, drawn):
    marked(gui, MIDDLE)
    measured(gui)
    count = len(drawn)
    assert count == gui.session.time.timeline.frames.count
    assert not gui.session.time.scene_tracks.is_due
    gui.session.time.timeline.go(5)  # another frame, focus and name are no other distance
    whole(gui)
    marked(gui, replace(MIDDLE, name="Z"))
    gui.session.editing.edit_lens(replace(gui.session.facts.lens, focus_distance_m=2.0))
    whole(gui)
    gui.frame(3)
    assert len(drawn) == count


def test_another_camera_is_measured_anew(gui):
    marked(gui, MIDDLE)
    (ahead,) = measured(gui)
    aside = replace(gui.session.facts.shot.framing, camera="side")
    gui.session.editing.begin(replace(gui.session.facts.shot, framing=aside))
    whole(gui)
    (found,) = measured(gui)  # past the near square, at the far one
    assert [1 / dioptres for dioptres in found.values()] == pytest.approx([7.0] * len(found))
    assert len(found) == len(ahead)


@pytest.mark.parametrize("kind", ["plays", "drags", "hidden"])
def test_nothing_is_measured_while_it_moves_or_is_not_seen(gui, drawn, kind):
    session = gui.session
    if kind == "hidden":
        session.time.keys.rows.shows_curve = False
        gui.frame()
    elif kind == "plays":
        session.time.timeline.play(1)
        start_s = session.time.timeline.playback._clock()
        session.time.timeline.playback._clock = lambda: start_s  # it never comes to its end
    marked(gui, MIDDLE)
    for step in range(6):
        if kind == "drags":
            session.editing.edit_lens(replace(session.facts.lens, f_stop=3.0 + step))
        gui.frame()
    assert drawn == []
    session.time.timeline.playback.stop()


def test_beside_the_picture_and_without_an_object_there_is_no_line(gui):
    marked(gui, PointMark("A", 500.0, 500.0), ObjectMark("B", "nothing of this name"))
    assert measured(gui) == [{}, {}]
    assert all(track.lines == () for track in gui.session.time.mark_tracks())


def test_of_very_many_frames_few_are_measured(gui, monkeypatch):
    monkeypatch.setattr(mark_measuring, "_FRAMES_MOST", 4)
    marked(gui, MIDDLE)
    (found,) = measured(gui)
    frames = gui.session.time.timeline.frames
    assert len(found) <= 5 and {frames.first, frames.last} <= set(found)
