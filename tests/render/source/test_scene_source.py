"""3D scenes as sources: frames, timing, drawing on request; SceneOnGpu and PlateOnGpu."""

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
from heatlens.render.frame_renderer import run_all_steps
from heatlens.render.source.kinds import plates_word
from heatlens.render.source.named import camera_of_shot, single_source, source_named, source_of
from heatlens.render.source.opened import Opening
from heatlens.render.source.plate_on_gpu import PlateOnGpu
from heatlens.render.source.scene_on_gpu import SceneOnGpu
from heatlens.render.source.scene_source import open_scene_source
from support.fragment_lists import packed_lists
from support.plates import plate_of, room
from support.session_files import write_scene

LENS = Lens(50.0, 2.0, 3.0, 36.0)


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    return write_scene(tmp_path_factory.mktemp("scene") / "scene.glb")


class FakeRenderer:
    """A fake renderer that records the scenes loaded and the frames drawn."""

    def __init__(self):
        self.scenes, self.looks = [], []

    def load_scene(self, scene):
        self.scenes.append(scene)

    def load_pinhole(self, shot, frame=0, views=None, is_for_file=False):
        self.looks.append((frame, is_for_file))


def test_scene_source_has_frames_of_shot_or_of_its_animation(path):
    source = source_named(str(path), timing=SceneTiming(frames_per_second=24.0))
    assert source.frames == FrameRange(1, 25)  # the animation lasts a second
    shot_with_frames = Shot(LENS, frames=FrameRange(3, 5))
    assert source.frames_of(Shot(LENS)) == tuple(source.frames)
    assert source.frames_of(shot_with_frames) == (3, 4, 5)
    assert source.span(shot_with_frames) == FrameRange(3, 5)
    assert source.span(Shot(LENS)) == source.frames


def test_scene_source_is_one_file_with_many_views(path):
    source = source_named(str(path))
    assert source.first_file is None  # of a sequence
    assert source.has_many_views and source.files == path


def test_scene_source_without_animation_has_one_frame(path, monkeypatch):
    source = source_named(str(path))
    monkeypatch.setitem(vars(source), "scene", replace(source.scene, frames=None))
    assert source.frames_of(Shot(LENS)) == (1,)


def test_scene_source_uses_timing_of_shot(path):
    shot = Shot(LENS, source=str(path), framing=Framing(timing=SceneTiming(frames_per_second=48.0)))
    assert source_of(shot).frames.count == 49


def test_scene_loader_uploads_once_and_draws_each_frame(path):
    source, drawing = source_named(str(path)), FakeRenderer()
    origins = tuple(source.origin(Shot(LENS), frame, "stop") for frame in (2, 5))
    loader = source.loader(Shot(LENS), origins, drawing, is_for_file=True)
    for origin in origins:
        loader.load(origin)
    loader.close()
    assert len(drawing.scenes) == 1 and drawing.looks == [(2, True), (5, True)]
    source.loader(Shot(LENS), origins, drawing).load(origins[0])
    assert drawing.looks[-1] == (2, False)


def test_check_error_names_missing_scene_file(tmp_path):
    path = write_scene(tmp_path / "gone.glb")
    source = single_source(path, PlateOptions())
    source.check(Shot(LENS), (1, 2), "stop")
    path.unlink()
    with pytest.raises(InputError, match=r"gone\.glb"):
        source.check(Shot(LENS), (1, 2), "stop")


def test_opened_scene_has_options_frames_and_notes_of_file(path):
    timing, options = SceneTiming(frames_per_second=12.0), PlateOptions(scene_unit_m=0.5)
    opened = open_scene_source(Opening(str(path), options, timing=timing))
    assert (opened.options, opened.timing, opened.frames) == (options, timing, opened.scene.frames)
    assert opened.frames.count == 13 and opened.settled_options == options
    assert opened.notes == read_scene(path).notes and len(opened.stamps) == 1
    assert opened.stamps[0][1] == path.stat().st_size
    start = opened.lens({"f_stop": 8.0})
    assert start.lens.f_stop == 8.0 and start.sources == {"f_stop": "given"}
    assert opened.shot(start.lens, DefocusSettings()).lens.f_stop == 8.0


def test_scene_on_gpu_draws_each_frame_once(ctx, path):
    scene_on_gpu = SceneOnGpu(ctx, read_scene(path))
    shot = Shot(LENS, framing=Framing(width_px=48, height_px=32, camera="main"))
    try:
        assert (
            scene_on_gpu.size(shot) == (48, 32) and scene_on_gpu.size(Shot(LENS)) == Framing().size
        )
        assert scene_on_gpu.scene.frames == FrameRange(1, 25)
        first = run_all_steps(scene_on_gpu.pinhole_steps(shot, 1, None))
        assert run_all_steps(
            scene_on_gpu.pinhole_steps(shot, 1, None)
        ) is first and first.color.size == (48, 32)
        later_pinhole = run_all_steps(scene_on_gpu.pinhole_steps(shot, 20, None))
        assert later_pinhole is not first and np.nanmin(later_pinhole.plate.depth_m) > 0.0
        for method in Method:
            scene_on_gpu.check_method(method)
        # `near` moves 2 m from the camera at z = 3 in the first second.
        depths = [scene_on_gpu.depth_m_at(shot, frame, 20, 16) for frame in (1, 25)]
        assert depths[1] - depths[0] == pytest.approx(2.0, abs=1e-3)
        assert scene_on_gpu.pose_at(shot, 1.0).position_m[2] == pytest.approx(3.0)
        scene_on_gpu.set_step_size(0.5)
        shared_scene = scene_on_gpu.share()
        assert run_all_steps(shared_scene.pinhole_steps(shot, 1, None)) is not first
        shared_scene.release()
    finally:
        scene_on_gpu.release()


def test_plate_on_gpu_refuses_scene_methods(ctx):
    plate_on_gpu = PlateOnGpu(ctx)
    with pytest.raises(InputError, match="No plate"):
        plate_on_gpu.loaded  # noqa: B018
    color, depth = room(24, 16)
    first = run_all_steps(plate_on_gpu.load_steps(plate_of(color, depth)))
    try:
        assert (
            plate_on_gpu.size(Shot(LENS)) == (24, 16)
            and plate_on_gpu.scene is None
            and not plate_on_gpu.has_many_views
        )
        assert (
            run_all_steps(plate_on_gpu.pinhole_steps(Shot(LENS), 9, None))
            is first
            is plate_on_gpu.loaded
        )
        assert plate_on_gpu.pose_at(Shot(LENS), 1.0) is None
        for scene_call in (
            plate_on_gpu.share,
            lambda: plate_on_gpu.depth_m_at(Shot(LENS), 1, 0, 0),
        ):
            with pytest.raises(InputError, match="No scene"):
                scene_call()
        for method in Method:
            shot = Shot(LENS, DefocusSettings(method=method))
            through = plate_on_gpu.through_lens(shot, 1, (24, 16), first.color)
            if method.needs_scene:
                with pytest.raises(InputError, match=f"{method}.*{first.plate.path.name}"):
                    run_all_steps(through)
            else:
                run_all_steps(through)
    finally:
        plate_on_gpu.release()


def test_plate_on_gpu_reuses_textures_for_same_size(ctx):
    plate_on_gpu = PlateOnGpu(ctx)
    color, depth = room(24, 16)
    try:
        first = run_all_steps(plate_on_gpu.load_steps(plate_of(color, depth)))
        second = run_all_steps(plate_on_gpu.load_steps(plate_of(color * 0.5, depth)))
        assert second.color is first.color and second.depth is first.depth and second is not first
        larger = run_all_steps(plate_on_gpu.load_steps(plate_of(*room(26, 16))))
        assert larger.color is not first.color
        unfinished_steps: Steps = plate_on_gpu.load_steps(plate_of(*room(26, 16)))
        next(unfinished_steps)
        unfinished_steps.close()  # what is not completed is not loaded
        with pytest.raises(InputError, match="No plate"):
            plate_on_gpu.size(Shot(LENS))
    finally:
        plate_on_gpu.release()


def test_camera_of_shot_differs_for_scene_and_plates(path):
    shot = Shot(LENS, source=str(path), framing=Framing(width_px=48, height_px=32, camera="main"))
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
def test_plates_word_tells_plate_from_sequence_by_name(name, word):
    assert plates_word(name) == word


def test_plate_on_gpu_uploads_fragment_lists_unchanged(ctx):
    color, depth = room(24, 16)
    plate_on_gpu, plain = PlateOnGpu(ctx), plate_of(color, depth)
    rgba, ones = np.ones((24 * 16, 4), np.float32), np.ones(24 * 16, np.uint32)
    try:
        for is_measured in (True, False):
            lists = packed_lists(ones, ones > 0, rgba, depth.ravel(), is_measured)
            gpu_fragments = run_all_steps(
                plate_on_gpu.load_steps(replace(plain, fragments=lists))
            ).fragments
            assert gpu_fragments.words.read() == lists.words.tobytes()
            assert gpu_fragments.starts.read() == lists.starts.tobytes()
            assert (gpu_fragments.size, gpu_fragments.is_measured, gpu_fragments.is_exact) == (
                (24, 16),
                *[is_measured] * 2,
            )
        assert run_all_steps(plate_on_gpu.load_steps(plain)).fragments is None
    finally:
        plate_on_gpu.release()
