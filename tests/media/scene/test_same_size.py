"""Test keeping an object's size while lens or camera change: f / z stays the same."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from heatlens.core.base.errors import InputError
from heatlens.core.model.curves.curve import Key
from heatlens.core.model.curves.frames import FrameRange
from heatlens.core.model.focus.coc import sharp_dioptres
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.marks.marks import DistanceMark, MatteMark, ObjectMark, PointMark
from heatlens.core.model.shot.camera_track import CameraTrack, Pose, PoseKey, pose_looking_at
from heatlens.core.model.shot.framing import Framing
from heatlens.core.model.shot.lens_parameter import LensParameter
from heatlens.core.model.shot.shot import Shot
from heatlens.media.scene.same_size import KeptSize, crop_words
from heatlens.render.gpu.textures import download
from support.scenes import NIGHT, lamp, placement, plane, scene_of, sphere

A = DistanceMark("A", 3.0)
MARKS = (A, DistanceMark("B", 5.0))
LENS = Lens(35.0, 2.0, 3.2, 36.0)
AWAY = scene_of([sphere()], [(0, placement(0, 0, -3.0, 0.2))], [lamp((1.0, 1.0, 1.0))])


def no_depth(x: int, y: int) -> float:
    raise AssertionError("no mark is on a point")


def kept_size(shot: Shot, mark=A, frame: float = 1, scene=AWAY, depth_at=no_depth) -> KeptSize:
    return KeptSize(scene, shot, frame, mark, depth_at)


def still_shot(lens: Lens = LENS, marks=MARKS, pose: Pose | None = None) -> Shot:
    track = CameraTrack((PoseKey(1, pose or Pose()),))
    return Shot(lens, marks=marks, framing=Framing(320, 180, track=track))


def moving_shot() -> Shot:
    """Return a shot whose camera moves forward and sideways over 24 frames, with focus keys."""
    ends = PoseKey(1, Pose()), PoseKey(24, Pose((0.3, 0.0, -1.2)))
    shot = replace(still_shot(), frames=FrameRange(1, 24))
    shot = replace(shot, framing=replace(shot.framing, track=CameraTrack(ends)))
    return shot.with_key(1, LensParameter.FOCUS_DISTANCE, 3.0).with_key(
        24, LensParameter.FOCUS_DISTANCE, 1.9
    )


def size_of(shot: Shot, depth_m: float, frame: float = 1) -> float:
    return shot.lens_at(frame).focal_length_mm / depth_m


def depth_of(shot: Shot, frame: float) -> float:
    """Return the depth of world point (0, 0, -3), where mark A is at frame 1 of every shot here."""
    pose = shot.framing.track.pose_at(frame)
    return float(np.subtract(pose.position_m, (0, 0, -3.0)) @ pose.turn[:, 2])


def check_focus(shot: Shot, frame: float, wanted_m: float) -> None:
    """Check that the focus is off by no more than a quarter of the sharp range."""
    lens = shot.lens_at(frame)
    assert abs(1 / lens.focus_distance_m - 1 / wanted_m) <= 0.5 * sharp_dioptres(lens)


@example(101.0, 20.0, 2.5)  # back at 101 mm, a focus at 0.094 m would be impossible
@given(st.floats(20, 200), st.floats(20, 200), st.floats(2.5, 50))
def test_kept_size_moves_camera_back_for_longer_lens(before_mm, after_mm, focus_m):
    lens = replace(LENS, focal_length_mm=before_mm, focus_distance_m=focus_m)
    pose, factor = pose_looking_at((1.0, 2.0, 3.0), (0.0, 0.5, -1.0)), after_mm / before_mm
    shot = still_shot(lens, (A, DistanceMark("B", 500.0)), pose)
    if focus_m <= 3.0 * (1 - factor):
        with pytest.raises(InputError, match="past what is in focus"):
            kept_size(shot).with_focal_length(after_mm)
        return
    if focus_m - 3.0 * (1 - factor) < 1.1e-3 * after_mm:
        return  # nearer than any lens can be focused
    new_shot = kept_size(shot).with_focal_length(after_mm)
    back_m = 3.0 * (factor - 1)
    np.testing.assert_allclose(
        new_shot.framing.track.pose_at(1).position_m,
        np.add(pose.position_m, pose.turn[:, 2] * back_m),
        atol=1e-9,
    )
    assert new_shot.framing.track.pose_at(1).orientation == pytest.approx(pose.orientation)
    assert [mark.distance_m for mark in new_shot.marks] == pytest.approx([3 + back_m, 500 + back_m])
    assert new_shot.lens.focus_distance_m == pytest.approx(focus_m + back_m)
    assert size_of(new_shot, new_shot.marks[0].distance_m) == pytest.approx(before_mm / 3.0)
    restored = replace(kept_size(new_shot), mark=new_shot.marks[0]).with_focal_length(before_mm)
    assert restored.lens.focus_distance_m == pytest.approx(focus_m)
    assert restored.framing.track.pose_at(1).position_m == pytest.approx(pose.position_m)


def test_kept_size_moves_focus_keys_too():
    shot = still_shot().with_curve(
        LensParameter.FOCUS_DISTANCE,
        replace(still_shot().curves.focus_distance_m, keys=(Key(1, 3.0), Key(9, 5.0))),
    )
    new_shot = kept_size(shot).with_focal_length(70.0)
    assert [key.value for key in new_shot.curves.focus_distance_m.keys] == pytest.approx([6.0, 8.0])


def test_kept_size_holds_at_every_frame_of_moving_camera():
    shot = moving_shot()
    new_shot = kept_size(shot).with_focal_length(85.0)
    for frame in range(1, 25):
        size_before = size_of(shot, depth_of(shot, frame), frame)
        assert size_of(new_shot, depth_of(new_shot, frame), frame) == pytest.approx(
            size_before, rel=0.003
        )
        behind_m = shot.lens_at(frame).focus_distance_m - depth_of(shot, frame)
        check_focus(new_shot, frame, depth_of(new_shot, frame) + behind_m)
    assert 2 <= len(new_shot.framing.track.keys) < 24


def test_kept_size_sets_no_keys_for_constant_focus():
    """The camera moves only sideways, so the way back is the same at every frame."""
    ends = PoseKey(1, Pose()), PoseKey(24, Pose((0.5, 0.0, 0.0)))
    shot = replace(still_shot(), frames=FrameRange(1, 24))
    shot = replace(shot, framing=replace(shot.framing, track=CameraTrack(ends)))
    new_shot = kept_size(shot).with_focal_length(70.0)
    assert not new_shot.curves.focus_distance_m.keys
    assert new_shot.lens.focus_distance_m == pytest.approx(6.2, abs=0.05)


def test_kept_size_by_camera_gives_dolly_zoom():
    shot = replace(still_shot(), frames=FrameRange(1, 24))
    for frame, length_mm in ((1, 35.0), (24, 85.0)):
        shot = shot.with_key(frame, LensParameter.FOCAL_LENGTH, length_mm)
    new_shot = kept_size(shot).follow_with_camera()
    for frame in range(1, 25):
        assert size_of(new_shot, depth_of(new_shot, frame), frame) == pytest.approx(
            35 / 3, rel=0.003
        )
        check_focus(new_shot, frame, depth_of(new_shot, frame) + 0.2)
    assert depth_of(new_shot, 24) == pytest.approx(3.0 * 85 / 35, rel=1e-3)
    assert len(new_shot.framing.track.keys) < 24


def test_kept_size_by_length_gives_dolly_zoom():
    shot = moving_shot()
    new_shot = kept_size(shot).follow_with_focal_length()
    assert new_shot.framing == shot.framing and new_shot.marks == shot.marks
    for frame in range(1, 25):
        assert size_of(new_shot, depth_of(new_shot, frame), frame) == pytest.approx(
            35 / 3, rel=0.005
        )
    assert new_shot.lens_at(24).focal_length_mm < 22


def test_kept_size_follows_object_mark():
    mark = ObjectMark("A", AWAY.instances[0].name)
    shot = replace(moving_shot(), marks=(mark,))
    new_shot = kept_size(shot, mark).follow_with_focal_length()
    assert new_shot.lens_at(24).focal_length_mm == pytest.approx(35 * 1.8 / 3, rel=0.01)


def test_kept_size_moves_point_marks_with_their_objects():
    """Mark A stays in place; one behind it moves to the middle; one leaves the image."""
    points = (
        PointMark("A", 200.0, 60.0),
        PointMark("far", 300.0, 20.0),
        PointMark("near", 300.0, 9.0),
    )
    depths = {(200, 60): 3.0, (300, 20): 30.0, (300, 9): 2.0}
    shot = still_shot(marks=points)
    after = kept_size(shot, points[0], depth_at=lambda x, y: depths[x, y]).with_focal_length(20.0)
    by_m, factor = 3.0 * (1 - 20 / 35), 20 / 35
    a, far, near = after.marks
    assert (a.x_px, a.y_px) == pytest.approx((200.0, 60.0))
    assert far.x_px + 0.5 - 160 == pytest.approx((300.5 - 160) * factor * 30 / (30 - by_m))
    assert isinstance(near, DistanceMark) and near.distance_m == pytest.approx(2 - by_m)


def test_kept_size_explains_impossible_requests():
    shot_with_near_mark = still_shot(marks=(A, DistanceMark("B", 1.0)))
    with pytest.raises(InputError, match=r"1\.714 m forward, past mark B at 1 m"):
        kept_size(shot_with_near_mark).with_focal_length(15.0)
    with pytest.raises(InputError, match="infinitely far away"):
        kept_size(still_shot(), DistanceMark("A", math.inf)).with_focal_length(15.0)
    with pytest.raises(InputError, match="something in a plate"):
        kept_size(still_shot(), MatteMark("A", "id:7")).with_focal_length(15.0)
    words = crop_words(still_shot(), 1, 70.0)
    assert "middle 50 % of its width" in words and "2 times as large" in words
    assert "1.75 times its width, which it does not have" in crop_words(still_shot(), 1, 20.0)


def test_kept_size_keeps_rendered_size_of_object_only(ctx, renderer):
    """A lit square at A keeps its pixels; the wall behind it changes in size."""
    lit, wall = lamp((1.0, 0.0, 0.0)), lamp((0.0, 1.0, 0.0))
    places = [(0, placement(0.2, 0.1, -3.0, 0.15)), (1, placement(0.2, 0.1, -9.0, 1.0))]
    scene = scene_of([plane(material=0), plane(material=1)], places, [lit, wall], daylight=NIGHT)
    shot = still_shot()
    new_shot = kept_size(shot, scene=scene).with_focal_length(85.0)
    renderer.load_scene(scene)
    light_before, light_after = (
        download(renderer.load_pinhole(it, 1, views=16).color)[..., :2].sum(axis=(0, 1))
        for it in (shot, new_shot)
    )
    assert light_after[0] == pytest.approx(light_before[0], rel=0.01) and light_before[0] > 900
    behind = (35 / 9) ** 2 * 4 - (35 / 3) ** 2 * 0.09
    looms = (85 / (6 + 3 * 85 / 35)) ** 2 * 4 - (35 / 3) ** 2 * 0.09
    assert light_after[1] / light_before[1] == pytest.approx(looms / behind, rel=0.03)
