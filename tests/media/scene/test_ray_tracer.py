"""Test rays through the lens against brute force, the rasterizer, a disc formula, and noise."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from heatlens.core.model.lens.aperture import Aperture
from heatlens.core.model.lens.pupil import PINHOLE, Pupil
from heatlens.core.model.shot.camera_track import pose_looking_at
from heatlens.media.scene.material import Material
from heatlens.media.scene.scene import Scene
from heatlens.media.scene.scene_view import SceneView
from heatlens.render.gpu.device import Device
from heatlens.render.gpu.textures import download, new_texture
from heatlens.render.scene_gpu import ray_tracer
from heatlens.render.scene_gpu.accumulation import Accumulation
from heatlens.render.scene_gpu.raster import SceneRaster
from heatlens.render.scene_gpu.ray_tracer import RayTracer
from support.ray_oracle import hit_materials, random_triangles
from support.scenes import BLACK, NIGHT, lamp, placement, plane, scene_of, still_life

Picture = NDArray[np.float32]
WIDE = Pupil(Aperture(squeeze=1.5), 0.12)


class Stage:
    """A scene, both ways to see it, and a picture of either."""

    def __init__(self, ctx: Device, scene: Scene, view: SceneView) -> None:
        self.view = view
        self.raster = SceneRaster(ctx)
        self.raster.load(scene)
        self.raster.place(1)
        self.tracer = RayTracer(ctx, self.raster)
        self.out = new_texture(ctx, view.size, 4)

    def traced(self, rays: int, pupil: Pupil = WIDE, seed: int = 0, key: object = 0) -> Picture:
        """Return (H, W, 4), the mean of `rays` rays a pixel."""
        for _ in self.tracer.steps(self.view, pupil, rays, self.out, key, seed):
            pass
        return download(self.out)

    def points(self, view: SceneView) -> Picture:
        """Return (H, W, 4), one ray a pixel through the view's points of pixel and lens."""
        for _ in self.tracer.steps(view, PINHOLE, 1, self.out, object(), pixel_side_px=0.0):
            pass
        return download(self.out)

    def drawn(self, view: SceneView) -> Picture:
        """Return (H, W, 4) drawn by the rasteriser."""
        self.raster.draw(view, self.out)
        return download(self.out)

    def release(self) -> None:
        self.tracer.release()
        self.raster.release()


def still_view(size: tuple[int, int] = (96, 54), focus_m: float = 3.0) -> SceneView:
    pose = pose_looking_at((0.8, 1.2, 3.6), (0.0, 0.35, 0.0))
    return SceneView(pose.world_to_camera, size, 1.2 * size[0], focus_m, 0.5, 12.0)


@pytest.fixture(scope="module")
def life(session_context: Device) -> Iterator[Stage]:
    """Return the still life, seen by both."""
    stage = Stage(ctx=session_context, scene=still_life(), view=still_view())
    yield stage
    stage.release()


def test_rays_hit_what_brute_force_finds(ctx: Device, rng: np.random.Generator) -> None:
    """Meshes are rotated, stretched and mirrored, some nearer or farther than the clip planes."""
    lights = rng.uniform(0.1, 1, (12, 3))
    materials = [lamp((r, g, b)) for r, g, b in lights.tolist()]
    meshes = [random_triangles(rng, count, i) for i, count in enumerate([1, 2, 3, 5, 9, *7 * [40]])]
    places = np.tile(np.eye(4), (12, 1, 1))
    places[:, :3] += rng.normal(size=(12, 3, 4))
    placed = [(i, place) for i, place in enumerate(places)]
    scene = scene_of(meshes, placed, materials, daylight=NIGHT)
    turn = pose_looking_at((1, 2, 6), (0, 0, 0)).world_to_camera
    view = SceneView(turn, (64, 36), 60.0, 8.0, 4.5, 7.5, (0.3, -0.2), (0.25, -0.4))
    stage = Stage(ctx, scene, view)
    expected = hit_materials(scene, view)
    colors = np.concatenate([lights, np.zeros((1, 3))])[expected]
    wrong = np.abs(stage.points(view)[..., :3] - colors).max(axis=-1) > 1e-4
    assert len(np.unique(expected)) > 8
    assert wrong.sum() <= 2  # an edge in the very middle of a pixel
    stage.release()


@pytest.mark.parametrize("offset_m", [(0.0, 0.0), (0.15, -0.1)])
@pytest.mark.parametrize("focus_m", [2.5, np.inf])
def test_ray_through_lens_point_equals_rasterized_image(
    life: Stage, offset_m: tuple[float, float], focus_m: float
) -> None:
    """It lies within the rasterized images that are shifted by up to a fiftieth of a pixel."""
    view = replace(life.view, offset_m=offset_m, focus_m=focus_m, jitter_px=(0.2, -0.3))
    traced, bit = life.points(view), (-0.02, 0.0, 0.02)
    drawn = [life.drawn(replace(view, jitter_px=(0.2 + x, -0.3 + y))) for x in bit for y in bit]
    low, high = np.min(drawn, axis=0), np.max(drawn, axis=0)
    assert (high - low > 0.02).any(axis=-1).mean() < 0.1
    wrong = (traced < 0.998 * low - 2e-3) | (traced > 1.002 * high + 2e-3)
    assert not wrong.any()


def test_rays_pass_through_alpha_holes(ctx: Device) -> None:
    """A checkered screen in front of a lamp has the same holes as in the rasterizer."""
    alpha = np.full((4, 4, 4), 255, np.uint8)
    alpha[..., 3] = np.where(np.indices((4, 4)).sum(axis=0) % 2, 255, 0)
    screen = Material("screen", base_color=BLACK, alpha_cutoff=0.5, base_color_map=0)
    scene = scene_of(
        [plane(1.0), plane(1.0, material=1)],
        [(0, placement(z=-3)), (1, placement(z=-5, scale=3))],
        [screen, lamp((5.0, 5.0, 5.0))],
        images=(alpha,),
        daylight=NIGHT,
    )
    view = SceneView(np.eye(4), (64, 64), 80.0, 3.0, 0.1, 10.0)
    stage = Stage(ctx, scene, view)
    drawn, traced = stage.drawn(view), stage.points(view)
    assert 0.1 < (drawn[..., 0] == 0).mean() < 0.5
    assert (traced != drawn).any(axis=-1).mean() < 0.01
    stage.release()


def test_rays_and_raster_agree_on_coincident_surfaces(ctx: Device) -> None:
    """Squares lie on each other, one with each triangle twice; the last one drawn is visible."""
    colors = [(1.0, 0, 0), (0, 1.0, 0), (0, 0, 1.0)]
    tilted = placement(z=-3) @ pose_looking_at((0.1, 0.3, 0), (0, 0, -1)).camera_to_world
    meshes = [plane(1.0, material=i) for i in (0, 1, 2)]
    twice = replace(meshes[2], triangles=meshes[2].triangles.repeat(2, axis=0))
    places = [(2, tilted), (0, tilted), (1, tilted)]
    lamps = [lamp(color) for color in colors]
    scene = scene_of([*meshes[:2], twice], places, lamps, daylight=NIGHT)
    view = SceneView(np.eye(4), (64, 36), 60.0, 3.0, 0.1, 10.0)
    stage = Stage(ctx, scene, view)
    drawn, traced = stage.drawn(view), stage.points(view)
    assert (drawn[..., 2] > 0).mean() > 0.3
    assert (traced != drawn).any(axis=-1).mean() < 0.01
    stage.release()


SMALL_M, LIGHT = 0.02, 700.0


@pytest.mark.parametrize(
    ("depth_m", "focus_m"), [(2.0, 3.0), (3.0, 3.0), (5.0, 3.0), (4.0, np.inf)]
)
def test_traced_small_lamp_is_disc_of_thin_lens(
    ctx: Device, depth_m: float, focus_m: float
) -> None:
    """Its light, position and extent are those of the formula, within statistical limits."""
    place = 3.5 * depth_m / 100, -1.5 * depth_m / 100, -depth_m  # in the middle of a pixel
    meshes = [plane(SMALL_M)]
    scene = scene_of(meshes, [(0, placement(*place))], [lamp((LIGHT, 0, 0))], daylight=NIGHT)
    view = SceneView(np.eye(4), (64, 64), 100.0, focus_m, 0.1, 10.0)
    stage = Stage(ctx, scene, view)
    rays = 300
    share = stage.traced(rays)[..., 0].astype(np.float64) / LIGHT
    stage.release()
    side = 2 * SMALL_M * view.focal_px / depth_m
    radii = view.focal_px * np.array(WIDE.half_extents_m) * abs(1 / focus_m - 1 / depth_m)
    hits = rays * side**2
    assert share.sum() == pytest.approx(side**2, rel=4 / np.sqrt(hits))
    middle = 32 + view.focal_px * np.array([place[0], -place[1]]) / depth_m
    offsets = np.indices(share.shape)[::-1] + 0.5 - middle[:, None, None]
    spread = np.sqrt(radii**2 / 4 + side**2 / 12 + 1 / 12)
    mean = (offsets * share).sum(axis=(1, 2)) / share.sum()
    assert np.all(np.abs(mean) < 4 * spread / np.sqrt(hits))
    found = np.sqrt((offsets**2 * share).sum(axis=(1, 2)) / share.sum())
    np.testing.assert_allclose(found, spread, rtol=4 / np.sqrt(2 * hits))
    is_outside = np.abs(offsets) > (radii + side / 2 + 0.501)[:, None, None]
    assert share[is_outside.any(axis=0)].max() == 0


def test_ray_tracer_converges_to_accumulation(ctx: Device) -> None:
    """Independent pictures tell their own variance; their mean is as far off as that says.

    In blocks of 3 x 3 pixels, and with lamps that are not bright: in a pixel that one ray of a
    thousand finds a lamp in, chance is far from normal. The mean square of t is 1.04 then, give or
    take 0.12 for 144 blocks. A lens a twelfth too wide gives 1.8.
    """
    calm = still_life()
    calm = replace(calm, materials=(*calm.materials[:4], lamp((1.5, 1.0, 0.5))))
    stage = Stage(ctx, scene=calm, view=still_view((48, 27)))
    pictures = np.array([block_means(stage.traced(8, seed=seed)) for seed in range(48)])
    for _ in Accumulation(ctx, stage.raster).steps(stage.view, WIDE, 512, stage.out, 0):
        pass
    reference = block_means(download(stage.out))
    stage.release()
    variance = pictures.var(axis=0, ddof=1) / len(pictures)
    variance += (3e-4 * reference) ** 2  # 512 views have an error of their own
    square = (pictures.mean(axis=0) - reference) ** 2 / variance
    assert 0.6 < square.mean() < 1.5


def block_means(picture: Picture) -> NDArray[np.float64]:
    """Return the mean light of each 3 x 3 pixels."""
    height, width = picture.shape[:2]
    light = picture[..., :3].astype(np.float64)
    return light.reshape(height // 3, 3, width // 3, 3, 3).mean(axis=(1, 3))


def test_ray_tracer_noise_is_uncorrelated(ctx: Device) -> None:
    """Half of the lens sees a lamp, everywhere alike, so that only noise remains."""
    scene = scene_of(
        [plane(1.0)], [(0, placement(x=50, z=-1, scale=50))], [lamp((1, 1, 1))], daylight=NIGHT
    )
    view = SceneView(np.eye(4), (64, 64), 1e5, np.inf, 0.1, 10.0)
    stage = Stage(ctx, scene, view)
    noise = np.array([stage.traced(4, seed=seed)[..., 0] - 0.5 for seed in range(4)], np.float64)
    stage.release()
    pairs = [(noise[:, 1:], noise[:, :-1]), (noise[..., 1:], noise[..., :-1])]
    for a, b in [*pairs, (noise[1:], noise[:-1])]:
        assert abs((a * b).mean() / noise.var()) < 4 / np.sqrt(a.size)
    assert noise.var() == pytest.approx(0.25 / 4, rel=0.05)


def test_ray_tracer_continues_from_earlier_rays(life: Stage) -> None:
    """This holds after an interrupted ray too, and in bands as used for large images."""
    with pytest.MonkeyPatch.context() as patch:
        at_once = life.traced(5, key="at once")
        assert np.array_equal(life.traced(5, key="at once"), at_once)
        patch.setattr(ray_tracer, "_RAYS_PER_STEP", 96 * 16)
        life.traced(2, key="in parts")
        steps = life.tracer.steps(life.view, WIDE, 5, life.out, "in parts")
        assert [next(steps) for _ in range(6)] == 6 * ["rays"]
        steps.close()
        assert np.array_equal(life.traced(5, key="in parts"), at_once)
        assert not np.array_equal(life.traced(4, key="in parts"), at_once)


def test_ray_tracer_restarts_for_fewer_rays_or_another_lens(life: Stage) -> None:
    three = life.traced(3, key="a")
    life.traced(6, key="a")
    assert np.array_equal(life.traced(3, key="a"), three)
    assert not np.array_equal(life.traced(3, PINHOLE, key="b"), three)


def test_ray_tracer_sees_moved_object_at_current_position(ctx: Device) -> None:
    """An object shrunk to nothing is not visible."""
    frames = {1: placement(z=-3), 2: placement(x=1, z=-3), 3: placement(z=-3, scale=0)}
    scene = scene_of(
        [plane(0.4)],
        materials=[lamp((1, 1, 1))],
        daylight=NIGHT,
        motion=lambda frame: frames[int(frame)][None],
    )
    stage = Stage(ctx, scene, SceneView(np.eye(4), (64, 36), 60.0, 3.0, 0.1, 10.0))
    middles = []
    for frame in frames:
        stage.raster.place(frame)
        light = stage.traced(2, PINHOLE, key=frame)[..., 0].sum(axis=0)
        middles.append((light @ np.arange(64) + 0.5) / light.sum() if light.any() else None)
    stage.release()
    assert middles[:2] == pytest.approx([32, 52], abs=0.5)
    assert middles[2] is None
