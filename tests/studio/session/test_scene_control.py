"""A session with a 3D scene: its camera, its objects, its clips, and what is measured in it."""

import math
from dataclasses import replace
from itertools import count
from types import SimpleNamespace

import numpy as np
import pytest

from heatlens.core.model.curves.frames import FrameRange
from heatlens.core.model.focus.coc import sharp_dioptres
from heatlens.core.model.marks.marks import DistanceMark, ObjectMark, PointMark
from heatlens.core.model.shot.framing import ALL_CLIPS, Framing, SceneTiming, WorldAxis
from heatlens.core.model.shot.lens_parameter import LensParameter
from heatlens.core.model.view.orbit import CameraDrag
from heatlens.render.frame_renderer import FrameRenderer
from heatlens.studio.board.session import Session
from heatlens.studio.session.marks import mark_measuring
from heatlens.studio.session.scenes import following
from heatlens.studio.session.scenes.following import PointMeasurement
from heatlens.studio.settings.preferences import Preferences
from heatlens.studio.settings.start import Start
from support.evening import run_loop_once, run_until, run_until_settled
from support.gltf_files import GltfWriter
from support.session_files import QUICK, room_file, write_scene


def open_small_session(renderer, folder, path):
    session = Session(
        renderer,
        Start(str(path), defocus=QUICK),
        preferences=Preferences.load(folder / "preferences"),
    )
    session.begin()
    run_until(session, lambda: session.source.opened is not None, "the scene")
    small = replace(session.editing.shot.framing, width_px=48, height_px=32)
    session.editing.begin(replace(session.editing.shot, framing=small))
    run_until_settled(session)
    return session


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    return write_scene(tmp_path_factory.mktemp("scene") / "scene.glb")


@pytest.fixture
def session(ctx, renderer: FrameRenderer, tmp_path, path):
    session = open_small_session(renderer, tmp_path, path)
    yield session
    session.close()


@pytest.fixture
def scenes(session):
    return session.scenes


def position(scenes):
    return np.array(scenes.pose.position_m)


def assert_focused_at(shot, distances_m):
    """Assert that the focus is within a quarter of the sharp range of distances by frame."""
    for frame, distance_m in distances_m.items():
        lens = shot.lens_at(frame)
        off = abs(1 / lens.focus_distance_m - 1 / distance_m)
        assert off <= 0.51 * sharp_dioptres(lens), frame


def test_orbit_drag_turns_about_the_focus_at_a_constant_distance(session, scenes):
    session.lens.commands.focus(3.0)
    start = position(scenes)
    pivot = start - (0.0, 0.0, 3.0)  # it looks along the axis
    scenes.move(CameraDrag("orbit", 0.25, 0.0))  # a quarter of the height: 45 degrees
    end = position(scenes)
    assert np.linalg.norm(end - pivot) == pytest.approx(3.0)
    angle_deg = math.degrees(math.acos((start - pivot) @ (end - pivot) / 9.0))
    assert angle_deg == pytest.approx(45.0) and end[1] == pytest.approx(start[1])
    assert end[0] < start[0]
    scenes.move(CameraDrag(kind="orbit", right=0.0, down=0.1))
    assert position(scenes)[1] > start[1]  # down takes the camera up
    session.editing.undo()
    assert position(scenes) == pytest.approx(start)


def test_truck_drag_moves_the_focus_plane_with_the_pointer(session, scenes):
    session.lens.commands.focus(3.0)
    start, lens = position(scenes), session.editing.lens
    height_m = 3.0 * lens.sensor_width_mm / lens.focal_length_mm / (48 / 32)
    scenes.move(CameraDrag(kind="truck", right=0.5, down=0.25))
    expected = start + np.array([-0.5 * height_m, 0.25 * height_m, 0.0])
    assert position(scenes) == pytest.approx(expected)


def test_dolly_notch_moves_by_twelve_percent_of_the_focus_distance(session, scenes):
    session.lens.commands.focus(2.0)
    start = position(scenes)
    scenes.move(CameraDrag("dolly", down=1.0))
    first = start[2] - position(scenes)[2]
    assert abs(first) == pytest.approx(2.0 * 0.12, rel=0.1)
    before = session.editing.shot
    scenes.move(CameraDrag("dolly"))
    scenes.move(CameraDrag("orbit"))
    assert session.editing.shot == before


def test_frame_of_object_or_scene_is_one_undo_step(session, scenes):
    start = position(scenes)
    scenes.frame_objects("near")
    near = position(scenes)
    assert not session.editing.is_unsettled and near != pytest.approx(start)
    assert scenes.object_m("near") is not None
    scenes.frame_objects(None)
    assert position(scenes)[2] > near[2]  # farther away
    session.editing.undo()
    assert position(scenes) == pytest.approx(near)
    scenes.selected = "near"
    scenes.frame_selected()
    assert position(scenes) == pytest.approx(near)
    before = session.editing.shot
    scenes.frame_objects("nothing")
    assert session.editing.shot == before and "nothing" in session.messages.text


def test_scene_object_can_be_focused_on_marked_and_followed(session, scenes):
    scenes.focus_on("near")
    assert session.editing.lens.focus_distance_m == pytest.approx(3.0)
    assert scenes.object_m("near", 25) == pytest.approx(5.0)
    assert scenes.object_m("nothing") is None
    scenes.set_mark("near")
    (mark,) = session.editing.shot.marks
    assert mark == ObjectMark("A", "near")
    assert session.time.marks.distances.distance_m(mark, 25) == pytest.approx(5.0)
    session.time.marks.follow(mark)
    assert "follows near from 1" in session.messages.text
    assert_focused_at(session.editing.shot, {1: 3.0, 13: 4.0, 25: 5.0})
    scenes.follow(ObjectMark("B", "nothing"), FrameRange(1, 3))
    assert "nothing" in session.messages.text and session.editing.shot.key_frames


def test_look_through_camera_takes_its_focal_length_and_reports(session, scenes):
    before = session.editing.lens
    scenes.set_key()
    assert scenes.key_frames == (1,)
    scenes.look_through("side")
    assert scenes.framing.camera == "side" and scenes.key_frames == ()
    assert position(scenes)[0] == pytest.approx(1.5)
    lens = session.editing.lens
    assert lens.focal_length_mm != before.focal_length_mm and lens.f_stop == before.f_stop
    message = session.messages.text
    assert message.startswith("Through side:") and f"{lens.focal_length_mm:.4g} mm" in message
    assert f"f/{lens.f_stop:.3g} and focus at" in message and "stay" in message
    session.editing.undo()
    assert scenes.key_frames == (1,)


def test_place_changes_unit_and_up_axis_and_scales_the_focus(session, scenes):
    session.lens.commands.focus(3.0)
    session.editing.settle()
    before = session.editing.shot
    scenes.set_axis_and_unit(before.framing.up_axis, before.framing.meters_per_unit)
    assert session.editing.shot is before
    scenes.set_axis_and_unit(WorldAxis.Z, 0.5)
    framing = scenes.framing
    assert (framing.up_axis, framing.meters_per_unit) == (WorldAxis.Z, 0.5)
    assert framing.camera is None is framing.track
    assert session.editing.lens.focus_distance_m == pytest.approx(1.5)
    scenes.set_axis_and_unit(WorldAxis.Z, 0.5e-3)  # no lens focuses within two of its lengths
    focal_mm = session.editing.lens.focal_length_mm
    assert session.editing.lens.focus_distance_m == pytest.approx(2e-3 * focal_mm)
    session.editing.undo()
    session.editing.undo()
    assert session.editing.shot == before


def test_camera_keys_are_set_toggled_and_deleted_at_the_playhead(session, scenes):
    assert scenes.key_frames == ()
    scenes.toggle_key()
    session.time.timeline.go_to(9)
    scenes.move(CameraDrag("dolly", down=2.0))
    session.editing.settle()
    scenes.toggle_key()
    assert 9 in scenes.key_frames or scenes.key_frames == (1,)
    session.time.timeline.go_to(12)
    scenes.set_key()
    assert 12 in scenes.key_frames
    scenes.toggle_key()
    assert 12 not in scenes.key_frames
    before = session.editing.shot
    scenes.delete_key()
    assert session.editing.shot.framing.track == before.framing.track


def test_follow_of_point_mark_measures_every_frame_of_the_scene(session, scenes, monkeypatch):
    monkeypatch.setattr(following, "_SLICE_S", 0.0)  # one frame a turn
    mark = PointMark("A", 20.0, 16.0)
    marks = session.time.marks
    marks.follow(mark)
    assert marks.is_reading and "0 of 25" in session.messages.text
    run_loop_once(session)
    assert "1 of 25" in session.messages.text
    run_until(session, lambda: not marks.is_reading, "all frames")
    assert_focused_at(session.editing.shot, {1: 3.0, 13: 4.0, 25: 5.0})
    assert "follows A from 1" in session.messages.text


def test_following_ends_when_another_scene_is_open(session, scenes):
    following = scenes.measure_point(PointMark("A", 20.0, 16.0), FrameRange(1, 3))
    assert not following.is_done
    stale_following = replace(following, scene=replace(following.scene, notes=("another",)))
    assert isinstance(stale_following, PointMeasurement)
    session.time.marks._scene_measurement = stale_following
    run_loop_once(session)
    assert "scene" in session.messages.text
    assert not session.time.marks.is_reading


def test_scene_tracks_are_measured_on_request_while_playback_rests(session, scenes):
    tracks = session.time.scene_tracks
    scenes.set_mark("near")
    session.editing.do(
        replace(
            session.editing.shot,
            marks=(
                *session.editing.shot.marks,
                PointMark("B", 20.0, 16.0),
                PointMark("C", 5000.0, 5000.0),
                DistanceMark("D", 3.0),
            ),
        )
    )
    run_until_settled(session)
    assert not tracks.is_due and tracks.seconds_until_needed() is None  # nobody asked
    for track in tracks.tracks():
        assert track.lines == ()
    assert tracks.is_due and tracks.seconds_until_needed() == 0.005
    session.time.timeline.play(1)
    assert not tracks.is_due
    session.time.timeline.play(1)
    session.time.timeline.go_to(1)
    run_until_settled(session)

    def is_complete():
        tracks.tracks()
        return len(tracks._measured) == 3 and all(len(k) == 25 for k in tracks._measured.values())

    run_until(session, is_complete, "all distances")
    a, b, c = session.time.mark_tracks()
    for track in (a, b):
        (line,) = track.lines
        assert [frame for frame, _ in line] == list(range(1, 26))
        distances_m = [1 / dioptres for frame, dioptres in line if frame in (1, 13, 25)]
        assert distances_m == pytest.approx([3.0, 4.0, 5.0], rel=1e-3)
    assert c.lines == () and not tracks.is_due
    session.lens.commands.focus(7.0)  # which moves nothing
    assert session.time.mark_tracks() == (a, b, c)
    scenes.move(CameraDrag("dolly", down=1.0))
    assert all(track.lines == () for track in session.time.mark_tracks())


def test_scene_tracks_of_a_long_scene_skip_frames(session):
    tracks = session.time.scene_tracks
    assert tracks._frames == tuple(range(1, 26))
    session.editing.do(replace(session.editing.shot, frames=FrameRange(1, 25)))

    class Long:
        frames = FrameRange(1, 1000)

    tracks._timeline = Long()
    assert tracks._frames == (*range(1, 1000, 5), 1000)
    Long.frames = FrameRange(1, 240)
    assert tracks._frames == tuple(range(1, 241))


def set_middle_mark(session):
    """Set a mark in the middle of the picture, as the only one, and ask for its track."""
    mark = PointMark("A", 20.0, 16.0)
    session.editing.do(replace(session.editing.shot, marks=(mark,)))
    run_until_settled(session)
    session.time.scene_tracks.tracks()


def test_scene_tracks_are_measured_in_short_slices(session, monkeypatch):
    clock = SimpleNamespace(perf_counter=count(0.0, 0.45 * mark_measuring._SLICE_S).__next__)
    set_middle_mark(session)
    tracks = session.time.scene_tracks
    monkeypatch.setattr(mark_measuring, "time", clock)
    tracks.poll()
    ((_, dioptres_by_frame),) = tracks._measured.items()
    assert len(dioptres_by_frame) == 2  # what begins within the slice
    tracks.tracks()
    assert 0 < session.seconds_until_needed() < 0.05  # or the rest would never come


def test_scene_tracks_of_many_frames_measure_few(session, monkeypatch):
    monkeypatch.setattr(mark_measuring, "_FRAMES_MOST", 4)
    set_middle_mark(session)

    def is_complete():
        session.time.scene_tracks.tracks()
        return session.time.scene_tracks._next_to_measure() is None

    run_until(session, is_complete, "all distances")
    (track,) = session.time.mark_tracks()
    frames = {frame for line in track.lines for frame, _ in line}
    assert len(frames) <= 5 and {1, 25} <= frames


def test_scene_commands_do_nothing_on_a_plate(ctx, renderer, tmp_path):
    path = room_file(tmp_path / "still.exr", 8, 6)
    session = Session(renderer, Start(str(path), defocus=QUICK))
    session.begin()
    run_until_settled(session)
    try:
        before = session.editing.shot
        scenes = session.scenes
        assert scenes.scene is None and scenes.framing == Framing() and scenes.key_frames == ()
        scenes.set_key()
        scenes.look_through("main")
        scenes.frame_objects("near")
        assert session.editing.shot == before and scenes.object_m("near") is None
        assert scenes.measure_point(PointMark("A", 1, 1), FrameRange(1, 2)) is None
        assert scenes.clips.names == {}
    finally:
        session.close()


# Clips


@pytest.fixture(scope="module")
def clips_path(tmp_path_factory):
    """Write a square with three clips, two of one name."""
    writer = GltfWriter()
    near = writer.node(name="near", mesh=writer.mesh(), translation=[-0.5, -0.5, 0.0])
    for name, end_s in (("walk", 1.0), ("run", 2.0), ("walk", 3.0)):
        ends = [[-0.5, -0.5, 0.0], [-0.5, -0.5, -2.0]]
        writer.animate(near, "translation", [0.0, end_s], ends)
        writer.json["animations"][-1]["name"] = name
    perspective = {"yfov": 0.7, "znear": 0.1, "aspectRatio": 1.5}
    camera = writer.add("cameras", type="perspective", perspective=perspective, name="main")
    writer.node(name="main", camera=camera, translation=[0.0, 0.0, 3.0])
    return writer.write(tmp_path_factory.mktemp("clips") / "clips.glb")


def test_clip_choice_reads_the_clip_and_can_be_undone(ctx, renderer, tmp_path, clips_path):
    session = open_small_session(renderer, tmp_path, clips_path)
    clips = session.scenes.clips
    try:
        assert clips.names == {
            ALL_CLIPS: None, "walk (1)": "1", "run": "run", "walk (3)": "3",
        }  # fmt: skip
        assert clips.current_name == ALL_CLIPS
        whole = session.time.timeline.frames
        clips.choose(ALL_CLIPS)
        assert session.source.opener.opening is None  # it is the one that plays
        clips.choose("run")
        run_until(session, lambda: clips.current_name == "run", "the clip")
        assert session.time.timeline.frames.count == 49 and session.editing.shot.frames.count == 49
        clips.choose("walk (1)")
        run_until(session, lambda: clips.current_name == "walk (1)", "the clip")
        assert session.time.timeline.frames.count == 25
        session.editing.undo()
        run_until(session, lambda: session.time.timeline.frames.count == 49, "the clip before")
        assert clips.current_name == "run"
        session.editing.undo()
        run_until(session, lambda: session.time.timeline.frames == whole, "all clips")
        assert clips.current_name == ALL_CLIPS
    finally:
        session.close()


def test_missing_clip_is_requested_once(ctx, renderer, tmp_path, clips_path):
    session = open_small_session(renderer, tmp_path, clips_path)
    try:
        framing = replace(session.editing.shot.framing, timing=SceneTiming("jump"))
        requested_timings = []
        real_read = session.scenes.clips._read_scene
        session.scenes.clips._read_scene = lambda timing: (
            requested_timings.append(timing) or real_read(timing)
        )
        session.editing.do(replace(session.editing.shot, framing=framing))
        assert session.scenes.clips.current_name == "jump"
        run_until(
            session,
            lambda: requested_timings and session.source.opener.opening is None,
            "the answer",
        )
        for _ in range(20):
            run_loop_once(session)
        assert len(requested_timings) == 1
        session.editing.undo()
        run_loop_once(session)
        assert (
            session.scenes.clips.current_name == ALL_CLIPS
            and session.scenes.clips._tried_timing is None
        )
    finally:
        session.close()


def test_truck_drag_sets_no_focal_length_key(session, scenes):
    scenes.move(CameraDrag(kind="truck", right=0.1, down=0.0))
    assert not session.editing.shot.curves.of(LensParameter.FOCAL_LENGTH).keys
