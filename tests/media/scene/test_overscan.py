"""Test that a scene is drawn beyond the frame, and blurs into it as far as the lens reaches."""

from dataclasses import replace

import numpy as np
import pytest

from heatlens.core.model.focus.coc import CocLine, coc_line, coc_px
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.camera_track import CameraTrack, PoseKey, pose_looking_at
from heatlens.core.model.shot.framing import Framing
from heatlens.core.model.shot.settings import DefocusSettings, Method, Quality
from heatlens.core.model.shot.shot import Shot
from heatlens.core.model.value_bins import bin_values
from heatlens.media.scene.scene import Scene, SceneCamera
from heatlens.render.defocus.optics import Optics
from heatlens.render.frame_renderer import FrameRenderer
from heatlens.render.gpu.textures import download
from heatlens.render.scene_gpu.overscan import Overscan, RingSurvey, texels_per_pixel
from heatlens.render.scene_gpu.pinhole_draw import FIRST_VIEWS, PINHOLE_VIEWS
from support.scenes import NIGHT, lamp, placement, plane, scene_of

SIZE = (96, 64)
WALL_M = 4.0
AHEAD = SceneCamera("ahead", CameraTrack((PoseKey(1, pose_looking_at((0, 0, 0), (0, 0, -1))),)))


def lamp_beside_the_frame() -> Scene:
    """Return a dim wall with a bright square whose edge is 2 % of the width outside."""
    half_width_m = WALL_M * 36 / 50 / 2
    aside_m = half_width_m * 1.04 + 0.1
    places = [(0, placement(z=-WALL_M)), (1, placement(aside_m, 0, -WALL_M + 0.01))]
    materials = (lamp((0.1, 0.1, 0.1)), lamp((2.0, 1.0, 0.5)))
    meshes = (plane(5.0), plane(0.1, material=1))
    return scene_of(meshes, places, materials, daylight=NIGHT, cameras=(AHEAD,))


def shot_at(f_stop: float, focus_m: float, method: Method = Method.DIFFUSION) -> Shot:
    settings = DefocusSettings(quality=Quality.FILM, method=method, views=256)
    framing = Framing(*SIZE, camera="ahead")
    return Shot(Lens(50.0, f_stop, focus_m, 36.0), settings, framing=framing)


@pytest.fixture(scope="module")
def looking(renderer: FrameRenderer) -> FrameRenderer:
    renderer.load_scene(lamp_beside_the_frame())
    return renderer


def test_light_beside_frame_blurs_in_as_through_the_lens(looking):
    blurred = looking.pixels(shot_at(1.0, 0.6))
    truth = looking.pixels(shot_at(1.0, 0.6, Method.ACCUMULATION))
    assert blurred.shape == truth.shape
    assert truth[:, -1, 0].max() > 0.3  # three times the wall
    assert np.abs(blurred - truth)[..., :3].max() < 0.15 * truth[..., :3].max()


def test_first_samples_of_the_whole_picture_are_not_drawn_again(looking):
    shot = shot_at(2.0, WALL_M)

    def step_count_and_light(*stages: int) -> tuple[int, np.ndarray]:
        looking.load_scene(lamp_beside_the_frame())  # forget what is drawn
        for views in stages:
            count = sum(1 for _ in looking.load_pinhole_steps(shot, 1, views))
        return count, download(looking.loaded.color)

    after_first, light = step_count_and_light(FIRST_VIEWS, PINHOLE_VIEWS)
    alone, light_alone = step_count_and_light(PINHOLE_VIEWS)
    assert after_first < alone
    np.testing.assert_array_equal(light, light_alone)


def test_overscan_is_left_out_of_hurried_image_and_of_sharp_one(looking):
    sharp = shot_at(2.0, WALL_M)
    looking.load_pinhole(replace(sharp, lens=replace(sharp.lens, focal_length_mm=51.0)), views=1)
    assert looking.loaded.overscan is None
    looking.load_pinhole(sharp)
    overscan = looking.loaded.overscan
    assert overscan is not None
    assert overscan.needed_px(looking.optics(sharp)) <= 1


def test_sharp_image_does_not_depend_on_overscan(looking):
    sharp = shot_at(16.0, WALL_M)
    picture = looking.pixels(sharp)
    plate = looking.loaded.plate
    alone = looking.make_sibling()
    alone.load(plate.in_memory())
    np.testing.assert_allclose(picture, alone.pixels(sharp), rtol=2e-3, atol=2e-4)


@pytest.mark.parametrize("is_for_file", [True, False])
def test_frame_is_middle_of_overscan_image(looking, is_for_file):
    looking.load_pinhole(shot_at(1.0, 0.6), views=64, is_for_file=is_for_file)
    loaded = looking.loaded
    overscan = loaded.overscan
    assert overscan is not None
    part, fine = overscan.box_with_margin(0), overscan.fine
    assert fine == (1 if is_for_file else 2)  # so small a picture is blurred at twice its size
    whole = download(overscan.color)
    assert whole.shape[1] == fine * (SIZE[0] + 2 * overscan.margin_px)
    inside = whole[part.y0 : part.y1, part.x0 : part.x1].reshape(SIZE[1], fine, SIZE[0], fine, 4)
    np.testing.assert_allclose(inside.mean(axis=(1, 3)), loaded.plate.color, rtol=1e-3)
    deep = download(overscan.depth)[part.y0 : part.y1, part.x0 : part.x1]
    assert np.isin(np.round(loaded.plate.depth_m, 3), np.round(deep, 3)).all()


def test_texels_per_pixel_of_large_image_is_one(ctx):
    assert [texels_per_pixel(ctx, size) for size in ((320, 180), (640, 360), (1280, 720))] == [
        2,
        2,
        1,
    ]


def test_ring_survey_has_nearest_and_farthest_depth_of_each_ring(ctx):
    margin, depth_m = 5, np.random.default_rng(3).uniform(1, 9, (23, 31)).astype(np.float32)
    depth_m[0, 4] = np.inf
    texture = ctx.texture((31, 23), 1, depth_m.tobytes(), dtype="f4")
    found = RingSurvey(ctx).of(texture, margin)
    for away in range(1, margin + 1):
        outer = depth_m[margin - away : 23 - margin + away, margin - away : 31 - margin + away]
        ring = np.concatenate([outer[0], outer[-1], outer[:, 0], outer[:, -1]])
        assert tuple(found[away - 1]) == (ring.min(), ring.max())


@pytest.mark.parametrize("f_stop", [1.4, 4.0, 22.0])
def test_overscan_needed_px_is_reach_of_discs(ctx, f_stop):
    lens, width, margin = Lens(50.0, f_stop, 1.5, 36.0), 640, 64
    ring_m = np.stack([np.full(margin, 1.0), np.full(margin, np.inf)], axis=1).astype(np.float32)
    texture = ctx.texture((1, 1), 1, dtype="f4")
    overscan = Overscan(texture, texture, margin, ring_m, bin_values(1 / ring_m))
    line = coc_line(lens, width)
    radius_px = np.abs(coc_px(np.array([1.0, np.inf]), line)).max() / 2
    needed = overscan.needed_px(Optics(line, np.array([0.0])))
    assert needed == min(margin, int(radius_px + 1))
    assert overscan.used_px(Optics(line, np.array([0.0]))) in (0, 16, 32, 64)
    half = Overscan(texture, texture, margin // 2, ring_m, bin_values(1 / ring_m), fine=2)
    assert half.needed_px(Optics(line, np.array([0.0]))) == min(margin // 2, int(radius_px + 1.5))
    own = replace(half, picture_textures=(texture, texture)).in_picture_pixels
    assert own.needed_px(Optics(line, np.array([0.0]))) == min(margin // 2, int(radius_px + 1))
    assert overscan.needed_px(Optics(CocLine(0.0, 0.0), np.array([0.0]))) == 1
