"""The size of a thing while lens or camera change: f / z is the same, and the picture shows it."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from heatlens.core.base.errors import InputError
from heatlens.core.model.curves.curve import Key
from heatlens.core.model.curves.frames import FrameRange
from heatlens.core.model.focus.coc import sharp_dioptres
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.marks.marks import DistanceMark, MatteMark, ObjectMark, PointMark
from heatlens.core.model.shot.framing import CameraTrack, Framing, Pose, PoseKey, looking_at
from heatlens.core.model.shot.lens_parameter import LensParameter
from heatlens.core.model.shot.shot import Shot
from heatlens.media.scene.same_size import KeptSize, crop_words
from heatlens.render.gpu.textures import download
from support.scenes import NIGHT, lamp, moved, plane, scene_of, sphere

A = DistanceMark("A", 3.0)
MARKS = (A, DistanceMark("B", 5.0))
LENS = Lens(35.0, 2.0, 3.2, 36.0)
AWAY = scene_of([sphere()], [(0, moved(0, 0, -3.0, 0.2))], [lamp((1.0, 1.0, 1.0))])


def no_depth(x: int, y: int) -> float:
    raise AssertionError("no mark is on a point")


def kept(shot: Shot, mark=A, frame: float = 1, scene=AWAY, depth_at=no_depth) -> KeptSize:
    return KeptSize(scene, shot, frame, mark, depth_at)


def still(lens: Lens = LENS, marks=MARKS, pose: Pose | None = None) -> Shot:
    track = CameraTrack((PoseKey(1, pose or Pose()),))
    return Shot(lens, marks=marks, framing=Framing(320, 180, track=track))


def moving() -> Shot:
    """Return a camera that goes forward and to the side over 24 frames, and a focus with keys."""
    ends = PoseKey(1, Pose()), PoseKey(24, Pose((0.3, 0.0, -1.2)))
    shot = replace(still(), frames=FrameRange(1, 24))
    shot = replace(shot, framing=replace(shot.framing, track=CameraTrack(ends)))
    return shot.with_key(1, LensParameter.FOCUS_DISTANCE, 3.0).with_key(
        24, LensParameter.FOCUS_DISTANCE, 1.9
    )


def size_of(shot: Shot, depth_m: float, frame: float = 1) -> float:
    return shot.lens_at(frame).focal_length_mm / depth_m


def depth_of(shot: Shot, frame: float) -> float:
    """Return the depth of the world's (0, 0, -3), on which A is at frame 1 of every shot here."""
    pose = shot.framing.track.pose_at(frame)
    return float(np.subtract(pose.position_m, (0, 0, -3.0)) @ pose.turn[:, 2])


def check_focus(shot: Shot, frame: float, wanted_m: float) -> None:
    """Check that the focus is off by no more than a quarter of the sharp range."""
    lens = shot.lens_at(frame)
    assert abs(1 / lens.focus_distance_m - 1 / wanted_m) <= 0.5 * sharp_dioptres(lens)


@given(st.floats(20, 200), st.floats(20, 200), st.floats(2.5, 50))
def test_the_camera_goes_back_as_the_lens_becomes_longer(before_mm, after_mm, focus_m):
    lens = replace(LENS, focal_length_mm=before_mm, focus_distance_m=focus_m)
    pose, factor = looking_at((1.0, 2.0, 3.0), (0.0, 0.5, -1.0)), after_mm / before_mm
    shot = still(lens, (A, DistanceMark("B", 500.0)), pose)
    if focus_m <= 3.0 * (1 - factor):
        with pytest.raises(InputError, match="past what is in focus"):
            kept(shot).at_length(after_mm)
        return
    if focus_m - 3.0 * (1 - factor) < 1.1e-3 * after_mm:
        return  # nearer than any lens can be focused
    after = kept(shot).at_length(after_mm)
    back_m = 3.0 * (factor - 1)
    np.testing.assert_allclose(
        after.framing.track.pose_at(1).position_m,
        np.add(pose.position_m, pose.turn[:, 2] * back_m),
        atol=1e-9,
    )
    assert after.framing.track.pose_at(1).orientation == pytest.approx(pose.orientation)
    assert [mark.distance_m for mark in after.marks] == pytest.approx([3 + back_m, 500 + back_m])
    assert after.lens.focus_distance_m == pytest.approx(focus_m + back_m)
    assert size_of(after, after.marks[0].distance_m) == pytest.approx(before_mm / 3.0)
    again = replace(kept(after), mark=after.marks[0]).at_length(before_mm)
    assert again.lens.focus_distance_m == pytest.approx(focus_m)
    assert again.framing.track.pose_at(1).position_m == pytest.approx(pose.position_m)


def test_keys_of_the_focus_follow_and_their_paths_stay():
    shot = still().with_curve(
        LensParameter.FOCUS_DISTANCE,
        replace(still().curves.focus_distance_m, keys=(Key(1, 3.0), Key(9, 5.0))),
    )
    after = kept(shot).at_length(70.0)
    assert [key.value for key in after.curves.focus_distance_m.keys] == pytest.approx([6.0, 8.0])


def test_a_camera_that_moves_keeps_the_size_at_every_frame():
    shot = moving()
    after = kept(shot).at_length(85.0)
    for frame in range(1, 25):
        before = size_of(shot, depth_of(shot, frame), frame)
        assert size_of(after, depth_of(after, frame), frame) == pytest.approx(before, rel=0.003)
        behind_m = shot.lens_at(frame).focus_distance_m - depth_of(shot, frame)
        check_focus(after, frame, depth_of(after, frame) + behind_m)
    assert 2 <= len(after.framing.track.keys) < 24


def test_a_focus_that_stands_gets_no_keys():
    """The camera only goes to the side: the way back is the same at every frame."""
    ends = PoseKey(1, Pose()), PoseKey(24, Pose((0.5, 0.0, 0.0)))
    shot = replace(still(), frames=FrameRange(1, 24))
    shot = replace(shot, framing=replace(shot.framing, track=CameraTrack(ends)))
    after = kept(shot).at_length(70.0)
    assert not after.curves.focus_distance_m.keys
    assert after.lens.focus_distance_m == pytest.approx(6.2, abs=0.05)


def test_a_dolly_zoom_by_the_camera():
    shot = replace(still(), frames=FrameRange(1, 24))
    for frame, length_mm in ((1, 35.0), (24, 85.0)):
        shot = shot.with_key(frame, LensParameter.FOCAL_LENGTH, length_mm)
    after = kept(shot).by_camera()
    for frame in range(1, 25):
        assert size_of(after, depth_of(after, frame), frame) == pytest.approx(35 / 3, rel=0.003)
        check_focus(after, frame, depth_of(after, frame) + 0.2)
    assert depth_of(after, 24) == pytest.approx(3.0 * 85 / 35, rel=1e-3)
    assert len(after.framing.track.keys) < 24


def test_a_dolly_zoom_by_the_length():
    shot = moving()
    after = kept(shot).by_length()
    assert after.framing == shot.framing and after.marks == shot.marks
    for frame in range(1, 25):
        assert size_of(after, depth_of(after, frame), frame) == pytest.approx(35 / 3, rel=0.005)
    assert after.lens_at(24).focal_length_mm < 22


def test_an_object_that_walks_keeps_its_size():
    mark = ObjectMark("A", AWAY.instances[0].name)
    shot = replace(moving(), marks=(mark,))
    after = kept(shot, mark).by_length()
    assert after.lens_at(24).focal_length_mm == pytest.approx(35 * 1.8 / 3, rel=0.01)


def test_marks_on_points_stay_on_their_things():
    """The point of A stays; one behind it moves to the middle; one leaves the picture."""
    points = (
        PointMark("A", 200.0, 60.0),
        PointMark("far", 300.0, 20.0),
        PointMark("near", 300.0, 9.0),
    )
    depths = {(200, 60): 3.0, (300, 20): 30.0, (300, 9): 2.0}
    shot = still(marks=points)
    after = kept(shot, points[0], depth_at=lambda x, y: depths[x, y]).at_length(20.0)
    by_m, factor = 3.0 * (1 - 20 / 35), 20 / 35
    a, far, near = after.marks
    assert (a.x_px, a.y_px) == pytest.approx((200.0, 60.0))
    assert far.x_px + 0.5 - 160 == pytest.approx((300.5 - 160) * factor * 30 / (30 - by_m))
    assert isinstance(near, DistanceMark) and near.distance_m == pytest.approx(2 - by_m)


def test_what_cannot_be_is_refused_in_words():
    near = still(marks=(A, DistanceMark("B", 1.0)))
    with pytest.raises(InputError, match=r"1\.714 m forward, past mark B at 1 m"):
        kept(near).at_length(15.0)
    with pytest.raises(InputError, match="infinitely far away"):
        kept(still(), DistanceMark("A", math.inf)).at_length(15.0)
    with pytest.raises(InputError, match="a mark of plates"):
        kept(still(), MatteMark("A", "id:7")).at_length(15.0)
    words = crop_words(still(), 1, 70.0)
    assert "middle 50 % of its width" in words and "2 times as large" in words
    assert "1.75 times its width, which it does not have" in crop_words(still(), 1, 20.0)


def test_the_picture_shows_the_thing_as_large_and_the_rest_not(ctx, renderer):
    """A lit square at A keeps its pixels; the wall behind it, half as large, looms."""
    lit, wall = lamp((1.0, 0.0, 0.0)), lamp((0.0, 1.0, 0.0))
    places = [(0, moved(0.2, 0.1, -3.0, 0.15)), (1, moved(0.2, 0.1, -9.0, 1.0))]
    scene = scene_of([plane(material=0), plane(material=1)], places, [lit, wall], daylight=NIGHT)
    shot = still()
    after = kept(shot, scene=scene).at_length(85.0)
    renderer.load_scene(scene)
    before, now = (
        download(renderer.look(it, 1, views=16).color)[..., :2].sum(axis=(0, 1))
        for it in (shot, after)
    )
    assert now[0] == pytest.approx(before[0], rel=0.01) and before[0] > 900
    behind = (35 / 9) ** 2 * 4 - (35 / 3) ** 2 * 0.09
    looms = (85 / (6 + 3 * 85 / 35)) ** 2 * 4 - (35 / 3) ** 2 * 0.09
    assert now[1] / before[1] == pytest.approx(looms / behind, rel=0.03)
