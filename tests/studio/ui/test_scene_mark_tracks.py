"""Tracks of marks of a scene behind the focus curve: measured at rest, and only once."""

from dataclasses import replace

import pytest
from imgui_bundle import imgui

from heatlens.core.model.marks.marks import DistanceMark, ObjectMark, PointMark
from heatlens.core.model.shot.lens_parameter import LensParameter
from heatlens.render.frame_renderer import FrameRenderer
from heatlens.render.gpu.device import Device
from support.gui import Gui
from support.scene_window import reset_scene, wait_for_whole_picture
from support.timeline_window import reset_timeline

MIDDLE = PointMark("A", 48.0, 27.0)
NEAR = ObjectMark("B", "near")
K = imgui.Key


@pytest.fixture
def gui(ctx: Device, window: Gui) -> Gui:
    """Open a scene and show the curve of its focus; there are no marks."""
    reset_timeline(window)
    gui = reset_scene(window)
    gui.session.editing.begin(gui.session.facts.shot.with_key(1, LensParameter.FOCUS_DISTANCE, 3.0))
    gui.key(K.c, shift=True)
    gui.frame(2)
    assert gui.session.time.keys.rows.shows_curve
    return gui


@pytest.fixture
def drawn(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """Return a list of the frames at which distances are measured."""
    frames: list[int] = []
    measure = FrameRenderer.scene_depth_m

    def asked(renderer: FrameRenderer, shot, frame: int, x: int, y: int) -> float:
        frames.append(frame)
        return measure(renderer, shot, frame, x, y)

    monkeypatch.setattr(FrameRenderer, "scene_depth_m", asked)
    return frames


def set_marks(gui: Gui, *marks) -> None:
    gui.session.editing.begin(replace(gui.session.facts.shot, marks=marks))


def wait_for_dioptres(gui: Gui) -> list[dict[int, float]]:
    """Return dioptres by frame of each mark, once all are known."""
    tracks = gui.session.time.scene_tracks
    gui.until(lambda: tracks._next_to_measure() is None, "all marks")
    return [dict(at for line in track.lines for at in line) for track in tracks.tracks()]


def test_scene_mark_tracks_have_a_distance_for_each_frame(gui):
    set_marks(gui, MIDDLE, DistanceMark("C", 2.0), NEAR)
    frames = gui.session.time.timeline.frames
    for dioptres_by_frame in wait_for_dioptres(gui):  # a square goes from 3 m to 5 m
        assert list(dioptres_by_frame) == list(range(frames.first, frames.last + 1))
        for frame, dioptres in dioptres_by_frame.items():
            fraction = (frame - frames.first) / (frames.count - 1)
            assert 1 / dioptres == pytest.approx(3.0 + 2.0 * fraction, rel=1e-3)
    assert [track.name for track in gui.session.time.mark_tracks()] == ["A", "B"]


def test_scene_mark_distances_are_measured_once(gui, drawn):
    set_marks(gui, MIDDLE)
    wait_for_dioptres(gui)
    count = len(drawn)
    assert count == gui.session.time.timeline.frames.count
    assert not gui.session.time.scene_tracks.is_due
    gui.session.time.timeline.go_to(5)  # another frame, focus and name are no other distance
    wait_for_whole_picture(gui)
    set_marks(gui, replace(MIDDLE, name="Z"))
    gui.session.editing.edit_lens(replace(gui.session.facts.lens, focus_distance_m=2.0))
    wait_for_whole_picture(gui)
    gui.frame(3)
    assert len(drawn) == count


def test_scene_marks_are_measured_again_for_another_camera(gui):
    set_marks(gui, MIDDLE)
    (first_track,) = wait_for_dioptres(gui)
    side_framing = replace(gui.session.facts.shot.framing, camera="side")
    gui.session.editing.begin(replace(gui.session.facts.shot, framing=side_framing))
    wait_for_whole_picture(gui)
    (dioptres_by_frame,) = wait_for_dioptres(gui)  # past the near square, at the far one
    assert [1 / dioptres for dioptres in dioptres_by_frame.values()] == pytest.approx(
        [7.0] * len(dioptres_by_frame)
    )
    assert len(dioptres_by_frame) == len(first_track)


@pytest.mark.parametrize("kind", ["plays", "drags", "hidden"])
def test_scene_marks_are_not_measured_while_moving_or_hidden(gui, drawn, kind):
    session = gui.session
    if kind == "hidden":
        session.time.keys.rows.shows_curve = False
        gui.frame()
    elif kind == "plays":
        session.time.timeline.play(1)
        start_s = session.time.timeline.playback._clock()
        session.time.timeline.playback._clock = lambda: start_s  # it never comes to its end
    set_marks(gui, MIDDLE)
    for step in range(6):
        if kind == "drags":
            session.editing.edit_lens(replace(session.facts.lens, f_stop=3.0 + step))
        gui.frame()
    assert drawn == []
    session.time.timeline.playback.stop()


def test_marks_off_the_picture_or_without_object_have_empty_tracks(gui):
    set_marks(gui, PointMark("A", 500.0, 500.0), ObjectMark("B", "nothing of this name"))
    assert wait_for_dioptres(gui) == [{}, {}]
    assert all(track.lines == () for track in gui.session.time.mark_tracks())
