"""A 3D scene as a source: every frame exists, and its picture is drawn on request."""

from dataclasses import replace

import numpy as np
import pytest

from heatlens.core.base.errors import InputError
from heatlens.core.model.curves.frames import FrameRange
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.framing import Framing, SceneTiming
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.core.model.shot.settings import DefocusSettings, Method
from heatlens.core.model.shot.shot import Shot
from heatlens.media.scene.scene_read import read_scene
from heatlens.render.defocus.steps import Steps
from heatlens.render.frame_renderer import drained
from heatlens.render.source.kinds import plates_word
from heatlens.render.source.named import camera_of_shot, single_source, source_named, source_of
from heatlens.render.source.opened import Opening
from heatlens.render.source.plate_on_gpu import PlateOnGpu
from heatlens.render.source.scene_on_gpu import SceneOnGpu
from heatlens.render.source.scene_source import opened_scene
from support.fragment_lists import packed_lists
from support.plates import plate_of, room
from support.session_files import write_scene

LENS = Lens(50.0, 2.0, 3.0, 36.0)


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    return write_scene(tmp_path_factory.mktemp("scene") / "scene.glb")


class Drawing:
    """The part of the renderer that draws scenes, which writes down what it was asked."""

    def __init__(self):
        self.scenes, self.looks = [], []

    def load_scene(self, scene):
        self.scenes.append(scene)

    def look(self, shot, frame=0, views=None, is_for_file=False):
        self.looks.append((frame, is_for_file))


def test_the_frames_are_those_of_the_shot_else_those_in_which_something_moves(path):
    source = source_named(str(path), timing=SceneTiming(frames_per_second=24.0))
    assert source.frames == FrameRange(1, 25)
    played = Shot(LENS, frames=FrameRange(3, 5))
    assert source.frames_of(Shot(LENS)) == tuple(source.frames)
    assert source.frames_of(played) == (3, 4, 5)
    assert source.span(played) == FrameRange(3, 5) and source.span(Shot(LENS)) == source.frames
    assert source.first_file is None and source.has_many_views and source.files == path


def test_a_scene_in_which_nothing_moves_has_one_frame(path, monkeypatch):
    source = source_named(str(path))
    monkeypatch.setitem(vars(source), "scene", replace(source.scene, frames=None))
    assert source.frames_of(Shot(LENS)) == (1,)


def test_its_timing_comes_from_the_shot(path):
    shot = Shot(LENS, source=str(path), framing=Framing(timing=SceneTiming(frames_per_second=48.0)))
    assert source_of(shot).frames.count == 49


def test_a_scene_is_uploaded_once_and_drawn_at_each_frame(path):
    source, drawing = source_named(str(path)), Drawing()
    origins = tuple(source.origin(Shot(LENS), frame, "stop") for frame in (2, 5))
    loader = source.loader(Shot(LENS), origins, drawing, is_for_file=True)
    for origin in origins:
        loader.load(origin)
    loader.close()
    assert len(drawing.scenes) == 1 and drawing.looks == [(2, True), (5, True)]
    source.loader(Shot(LENS), origins, drawing).load(origins[0])
    assert drawing.looks[-1] == (2, False)


def test_a_scene_that_is_gone_is_named_before_a_render(tmp_path):
    path = write_scene(tmp_path / "gone.glb")
    source = single_source(path, PlateOptions())
    source.check(Shot(LENS), (1, 2), "stop")
    path.unlink()
    with pytest.raises(InputError, match=r"gone\.glb"):
        source.check(Shot(LENS), (1, 2), "stop")


def test_what_is_opened_tells_what_the_file_holds(path):
    timing, options = SceneTiming(frames_per_second=12.0), PlateOptions(scene_unit_m=0.5)
    opened = opened_scene(Opening(str(path), options, timing=timing))
    assert (opened.options, opened.timing, opened.frames) == (options, timing, opened.scene.frames)
    assert opened.frames.count == 13 and opened.settled == options
    assert opened.notes == read_scene(path).notes and len(opened.stamps) == 1
    assert opened.stamps[0][1] == path.stat().st_size
    start = opened.lens({"f_stop": 8.0})
    assert start.lens.f_stop == 8.0 and start.sources == {"f_stop": "given"}
    assert opened.shot(start.lens, DefocusSettings()).lens.f_stop == 8.0


def test_its_picture_is_drawn_once_for_each_frame(ctx, path):
    held = SceneOnGpu(ctx, read_scene(path))
    shot = Shot(LENS, framing=Framing(48, 32, "main"))
    try:
        assert held.size(shot) == (48, 32) and held.size(Shot(LENS)) == Framing().size
        assert held.scene.frames == FrameRange(1, 25)
        first = drained(held.look(shot, 1, None))
        assert drained(held.look(shot, 1, None)) is first and first.color.size == (48, 32)
        later = drained(held.look(shot, 20, None))
        assert later is not first and np.nanmin(later.plate.depth_m) > 0.0
        for method in Method:
            held.check_method(method)
        # `near` moves 2 m from the camera at z = 3 in the first second.
        depths = [held.depth_m_at(shot, frame, 20, 16) for frame in (1, 25)]
        assert depths[1] - depths[0] == pytest.approx(2.0, abs=1e-3)
        assert held.pose_at(shot, 1.0).position_m[2] == pytest.approx(3.0)
        held.pace(0.5)
        beside = held.beside()
        assert drained(beside.look(shot, 1, None)) is not first
        beside.release()
    finally:
        held.release()


def test_a_plate_on_the_gpu_refuses_what_only_a_scene_can_do(ctx):
    held = PlateOnGpu(ctx)
    with pytest.raises(InputError, match="No plate"):
        held.held  # noqa: B018
    color, depth = room(24, 16)
    first = drained(held.loading(plate_of(color, depth)))
    try:
        assert held.size(Shot(LENS)) == (24, 16) and held.scene is None and not held.has_many_views
        assert drained(held.look(Shot(LENS), 9, None)) is first is held.held
        assert held.pose_at(Shot(LENS), 1.0) is None
        for asked in (held.beside, lambda: held.depth_m_at(Shot(LENS), 1, 0, 0)):
            with pytest.raises(InputError, match="No scene"):
                asked()
        for method in Method:
            shot = Shot(LENS, DefocusSettings(method=method))
            through = held.through_lens(shot, 1, (24, 16), first.color)
            if method.needs_scene:
                with pytest.raises(InputError, match=f"{method}.*{first.plate.path.name}"):
                    drained(through)
            else:
                drained(through)
    finally:
        held.release()


def test_the_next_plate_of_the_same_size_takes_the_same_textures(ctx):
    held = PlateOnGpu(ctx)
    color, depth = room(24, 16)
    try:
        first = drained(held.loading(plate_of(color, depth)))
        again = drained(held.loading(plate_of(color * 0.5, depth)))
        assert again.color is first.color and again.depth is first.depth and again is not first
        other = drained(held.loading(plate_of(*room(26, 16))))
        assert other.color is not first.color
        coming: Steps = held.loading(plate_of(*room(26, 16)))
        next(coming)
        coming.close()  # what is not completed is not loaded
        with pytest.raises(InputError, match="No plate"):
            held.size(Shot(LENS))
    finally:
        held.release()


def test_the_camera_of_a_scene_is_that_of_its_file_and_that_of_plates_stands_still(path):
    shot = Shot(LENS, source=str(path), framing=Framing(48, 32, "main"))
    frames = FrameRange(1, 3)
    of_scene = camera_of_shot(shot, "cam", frames)
    of_plates = camera_of_shot(Shot(LENS, source="a.exr", frames=frames), "cam", frames, 24.0)
    for camera in (of_scene, of_plates):
        assert camera.name == "cam" and tuple(camera.frames) == (1, 2, 3)
    assert of_plates != of_scene


@pytest.mark.parametrize(
    ("name", "word"),
    [
        ("a.exr", "Plate"),
        ("A.EXR", "Plate"),
        ("a/b.png", "Plate"),
        ("a.####.exr", "Sequence"),
        ("a.%04d.exr", "Sequence"),
        ("a.@@.png", "Sequence"),
        ("a.$F4.exr", "Sequence"),
        ("folder", "Sequence"),
        ("f#lder/a.exr", "Plate"),
    ],
)
def test_a_name_alone_tells_a_plate_from_a_sequence(name, word):
    assert plates_word(name) == word


def test_lists_of_fragments_go_to_the_gpu_as_they_are_and_with_their_plate(ctx):
    color, depth = room(24, 16)
    held, plain = PlateOnGpu(ctx), plate_of(color, depth)
    rgba, ones = np.ones((24 * 16, 4), np.float32), np.ones(24 * 16, np.uint32)
    try:
        for is_measured in (True, False):
            lists = packed_lists(ones, ones > 0, rgba, depth.ravel(), is_measured)
            sent = drained(held.loading(replace(plain, fragments=lists))).fragments
            assert sent.words.read() == lists.words.tobytes()
            assert sent.starts.read() == lists.starts.tobytes()
            assert (sent.size, sent.is_measured, sent.is_exact) == ((24, 16), *[is_measured] * 2)
        assert drained(held.loading(plain)).fragments is None
    finally:
        held.release()
