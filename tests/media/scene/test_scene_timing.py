"""Clips, rates and first frames of glTF scenes, and the sensor of a camera that has none."""

import argparse

import numpy as np
import pytest

from heatlens.core.base.errors import InputError
from heatlens.core.model.curves.frames import FrameRange
from heatlens.core.model.shot.framing import SceneTiming
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.fronts.commands.options.scene_options import add_timing_options, given_timing
from heatlens.media.documents.shot_file import read_shot, write_shot
from heatlens.media.scene.first_shot import first_shot, lens_with_fields
from heatlens.render.source.named import camera_of_shot, source_of
from heatlens.render.source.opened import Opening
from heatlens.render.source.scene_source import open_scene_source
from support.gltf_files import GltfWriter

BLENDER = SceneTiming(clip="2", frames_per_second=25.0, first_frame=101)


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


def parse_options(*words, has_rate=False):
    parser = argparse.ArgumentParser()
    add_timing_options(parser.add_argument_group("scene"), has_rate)
    if has_rate:
        parser.add_argument("--fps", type=float)
    return parser.parse_args(words)


def test_timing_of_options_gives_timing_or_none():
    assert given_timing(parse_options(), "a.glb") is None
    options = parse_options("--clip=2", "--fps=25", "--first-frame=101")
    assert given_timing(options, "a.glb") == BLENDER
    assert given_timing(parse_options("--first-frame=5"), "a.gltf") == SceneTiming(None, 24.0, 5)
    with pytest.raises(InputError, match="0"):
        given_timing(parse_options("--fps=0"), "a.glb")


def test_given_timing_ignores_movie_rate_for_usd_scene():
    options = parse_options("--fps=25", has_rate=True)
    assert given_timing(options, "a.usdc") is None
    assert given_timing(options, "a.glb") == SceneTiming(None, 25.0)


def test_shot_source_and_camera_use_same_scene_timing(path, tmp_path):
    shot = first_shot(path, timing=BLENDER).shot
    assert (shot.frames, shot.frames_per_second) == (FrameRange(101, 126), 25.0)
    write_shot(tmp_path / "s.heatlens.json", shot)
    saved_shot = read_shot(tmp_path / "s.heatlens.json")
    assert saved_shot.framing == shot.framing and saved_shot.framing.timing == BLENDER
    assert source_of(saved_shot).frames_of(saved_shot) == tuple(range(101, 127))
    camera = camera_of_shot(saved_shot, "hero")
    assert (camera.frames, camera.frames_per_second) == (tuple(range(101, 127)), 25.0)
    across = [np.linalg.inv(place)[0, 3] for place in camera.world_to_camera]
    assert across == pytest.approx(list(range(26)), abs=1e-5)


def test_opened_scene_keeps_its_timing(path):
    opened = open_scene_source(Opening(path, PlateOptions(), timing=BLENDER))
    assert opened.frames == FrameRange(101, 126)
    assert opened.first.shot.framing.timing == BLENDER


def test_another_sensor_width_keeps_field_of_view(path):
    first = first_shot(path)
    assert "assumed" in first.sources["sensor_width_mm"]
    small = first_shot(path, given_fields={"sensor_width_mm": 18.0}).shot.lens
    assert small.focal_length_mm == pytest.approx(first.shot.lens.focal_length_mm / 2)
    assert lens_with_fields(first, {"sensor_width_mm": 18.0}) == small
    both = {"sensor_width_mm": 18.0, "focal_length_mm": 50.0}
    assert first_shot(path, given_fields=both).shot.lens.focal_length_mm == 50.0
