"""Clips, rates and first frames of glTF scenes, and the sensor of a camera that has none."""

import argparse

import numpy as np
import pytest

from heatlens.core.base.errors import InputError
from heatlens.core.model.curves.frames import FrameRange
from heatlens.core.model.shot.framing import SceneTiming
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.fronts.commands.options.scene_options import add_timing_options, timing_of
from heatlens.media.documents.shot_file import read_shot, write_shot
from heatlens.media.scene.first_shot import first_shot, lens_with
from heatlens.render.source.named import camera_of_shot, source_of
from heatlens.render.source.opened import Opening
from heatlens.render.source.scene_source import opened_scene
from support.gltf_files import GltfWriter

BLENDER = SceneTiming("2", 25.0, 101)


@pytest.fixture
def path(tmp_path):
    """Return two clips from second 4.04 to 5.04, and a camera that moves in both."""
    writer = GltfWriter()
    writer.node(mesh=writer.mesh())
    lens = {"yfov": 0.5, "aspectRatio": 1.5, "znear": 0.1}
    camera = writer.add("cameras", type="perspective", perspective=lens)
    node = writer.node(camera=camera, name="hero", translation=[0, 0, 5])
    for far in (1, 25):
        writer.animate(node, "translation", [101 / 25, 126 / 25], [[0, 0, 5], [far, 0, 5]])
    return str(writer.write(tmp_path / "clips.glb"))


def options(*words, has_rate=False):
    parser = argparse.ArgumentParser()
    add_timing_options(parser.add_argument_group("scene"), has_rate)
    if has_rate:
        parser.add_argument("--fps", type=float)
    return parser.parse_args(words)


def test_options_are_a_timing_or_none():
    assert timing_of(options(), "a.glb") is None
    given = options("--clip=2", "--fps=25", "--first-frame=101")
    assert timing_of(given, "a.glb") == BLENDER
    assert timing_of(options("--first-frame=5"), "a.gltf") == SceneTiming(None, 24.0, 5)
    with pytest.raises(InputError, match="0"):
        timing_of(options("--fps=0"), "a.glb")


def test_the_rate_of_a_movie_is_no_timing_of_a_scene_that_tells_its_frames():
    given = options("--fps=25", has_rate=True)
    assert timing_of(given, "a.usdc") is None
    assert timing_of(given, "a.glb") == SceneTiming(None, 25.0)


def test_shot_source_and_camera_have_the_same_frames(path, tmp_path):
    shot = first_shot(path, timing=BLENDER).shot
    assert (shot.frames, shot.frames_per_second) == (FrameRange(101, 126), 25.0)
    write_shot(tmp_path / "s.heatlens.json", shot)
    kept = read_shot(tmp_path / "s.heatlens.json")
    assert kept.framing == shot.framing and kept.framing.timing == BLENDER
    assert source_of(kept).frames_of(kept) == tuple(range(101, 127))
    camera = camera_of_shot(kept, "hero")
    assert (camera.frames, camera.frames_per_second) == (tuple(range(101, 127)), 25.0)
    across = [np.linalg.inv(place)[0, 3] for place in camera.world_to_camera]
    assert across == pytest.approx(list(range(26)), abs=1e-5)


def test_the_window_opens_a_scene_with_its_timing(path):
    opened = opened_scene(Opening(path, PlateOptions(), timing=BLENDER))
    assert opened.frames == FrameRange(101, 126)
    assert opened.first.shot.framing.timing == BLENDER


def test_another_sensor_keeps_what_is_seen(path):
    begun = first_shot(path)
    assert "assumed" in begun.sources["sensor_width_mm"]
    small = first_shot(path, given={"sensor_width_mm": 18.0}).shot.lens
    assert small.focal_length_mm == pytest.approx(begun.shot.lens.focal_length_mm / 2)
    assert lens_with(begun, {"sensor_width_mm": 18.0}) == small
    both = {"sensor_width_mm": 18.0, "focal_length_mm": 50.0}
    assert first_shot(path, given=both).shot.lens.focal_length_mm == 50.0
