"""Test the light of scenes against physical laws: furnaces, shadows, lamps, and no NaN."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from heatlens.core.model.shot.camera_track import pose_looking_at
from heatlens.media.scene.material import Material
from heatlens.media.scene.scene import Array, Daylight, PointLight, Scene
from heatlens.media.scene.scene_view import SceneView
from heatlens.render.gpu.textures import download, new_texture
from heatlens.render.scene_gpu.mesh_draw import SIDE_PX, sun_view
from heatlens.render.scene_gpu.raster import SceneRaster, sun_direction
from heatlens.render.scene_gpu.scene_records import layer_size
from heatlens.render.scene_gpu.sky_light import diffuse_polynomial, sky_radiance
from support.scenes import BLACK, NIGHT, even_sky, lamp, placement, plane, scene_of, sphere

SIZE = (48, 32)
VIEW = SceneView(
    world_to_camera=np.eye(4), size=SIZE, focal_px=60.0, focus_m=np.inf, near_m=0.1, far_m=100.0
)
AHEAD = [(0, placement(z=-2.0))]
WHITE = Material(base_color=(1.0, 1.0, 1.0), roughness=1.0)
# Of the light on WHITE what leaves it straight on: what GGX does not mirror, approximated as in
# Karis 2014 with what Turquin 2019 adds, and F D V pi = 0.04 / 4 of what it does.
OF_WHITE = 1 - (0.04 * 0.4524 - 0.0024) * (1 + 0.04 * (1 / 0.45 - 1)) + 0.04 / 4


def draw_scene(raster: SceneRaster, scene: Scene, view: SceneView = VIEW) -> Array:
    """Return (H, W, 4) with one sample a pixel."""
    raster.load(scene)
    raster.place(1)
    color = new_texture(raster._ctx, view.size, 4)
    raster.draw(view, color)
    picture = download(color)
    color.release()
    return picture


def view_from(eye: tuple[float, float, float], at: tuple = (0.0, 0.0, 0.0)) -> SceneView:
    return replace(VIEW, world_to_camera=pose_looking_at(eye, at).world_to_camera)


@pytest.mark.parametrize("light", [(0.5, 2.25, 500.0), (1e-3, 0.0, 65504.0)])
def test_lamp_emits_its_radiance(raster: SceneRaster, light: tuple) -> None:
    picture = draw_scene(raster, scene_of([plane(9.0)], AHEAD, [lamp(light)], daylight=NIGHT))
    expected = np.float32([*light, 1.0])
    np.testing.assert_array_equal(picture, np.broadcast_to(expected, picture.shape))


def test_radiance_is_limited_to_half_float(raster: SceneRaster) -> None:
    picture = draw_scene(
        raster, scene_of([plane(9.0)], AHEAD, [lamp((1e9, 7e4, 1.0))], daylight=NIGHT)
    )
    assert tuple(picture[5, 5]) == (65504.0, 65504.0, 1.0, 1.0)


def test_even_sky_is_not_exceeded_by_reflection(raster: SceneRaster) -> None:
    grid = [(r, m) for m in (0.0, 0.5, 1.0) for r in (0.0, 0.3, 0.6, 1.0)]
    materials = [Material(base_color=(1.0, 0.5, 0.0), roughness=r, metallic=m) for r, m in grid]
    meshes = [sphere(0.3, 3, i) for i in range(len(grid))]
    places = [(i, placement(i % 4 - 1.5, i // 4 - 1.0, -5.0)) for i in range(len(grid))]
    picture = draw_scene(raster, scene_of(meshes, places, materials, daylight=even_sky()))
    is_object = picture[..., 2] < 0.9  # the sky is white, these have no blue
    assert 0.1 < is_object.mean() < 0.6
    assert picture.max() <= 1.0 + 1e-5
    assert picture[is_object][:, 0].min() > 0.6  # half a metal is darker than either
    np.testing.assert_allclose(picture[~is_object], 1.0, atol=0.12)


def test_white_matte_object_vanishes_in_even_sky(raster: SceneRaster) -> None:
    scene = scene_of([sphere(0.6, 3)], AHEAD, [WHITE], daylight=even_sky((2.0, 1.0, 0.5)))
    picture = draw_scene(raster, scene)
    np.testing.assert_allclose(picture[..., :3] / (2.0, 1.0, 0.5), 1.0, rtol=1e-4)


def test_sky_is_drawn_where_nothing_is(raster: SceneRaster) -> None:
    view = view_from((0.0, 0.0, 5.0), (1.0, 1.0, 0.0))
    far_off = [(0, placement(z=50.0))]
    picture = draw_scene(raster, scene_of([plane(0.1)], far_off), view)
    x, y = np.meshgrid(np.arange(SIZE[0]) + 0.5, np.arange(SIZE[1]) + 0.5)
    across, up = x - SIZE[0] / 2, SIZE[1] / 2 - y
    along = np.stack([across, up, np.full_like(x, -VIEW.focal_px)], -1)
    along = along @ view.world_to_camera[:3, :3]
    height = along[..., 1] / np.linalg.norm(along, axis=-1)
    assert height.min() < -0.05 and height.max() > 0.3
    np.testing.assert_allclose(picture[..., :3], sky_radiance(Daylight(), height), rtol=1e-4)
    assert np.all(picture[..., 3] == 1.0)


@given(st.tuples(*[st.floats(0, 2)] * 3), st.tuples(*[st.floats(0, 2)] * 3))
@settings(max_examples=15, deadline=None)
def test_diffuse_polynomial_is_cosine_mean_of_sky(zenith: tuple, ground: tuple) -> None:
    daylight = Daylight(zenith=zenith, horizon=(1.0, 1.0, 1.0), ground=ground)
    rng = np.random.default_rng(7)
    directions = rng.normal(size=(200_000, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    sky = sky_radiance(daylight, directions[:, 1])
    a, b, c = diffuse_polynomial(daylight)
    for y in (-1.0, -0.4, 0.0, 0.7, 1.0):
        cosine = np.maximum(directions @ (np.sqrt(1 - y * y), y, 0.0), 0)
        mean = (cosine[:, None] * sky).sum(0) / cosine.sum()
        np.testing.assert_allclose(a + b * y + c * y * y, mean, atol=0.05)


def test_shadow_falls_where_geometry_says(raster: SceneRaster) -> None:
    to_sun, centre, radius = (0.5, 1.0, 0.3), np.array([0.0, 1.0, 0.0]), 0.5
    daylight = replace(NIGHT, to_sun=to_sun, sun=(3.0, 3.0, 3.0))
    scene = scene_of(
        [plane(3.0, "y"), sphere(radius, 5)], [(0, placement()), (1, placement(y=1.0))]
    )
    view = replace(view_from((0.5, -4.0, 0.2)), size=(96, 64))  # from below: the ball hides nothing
    picture = draw_scene(raster, replace(scene, daylight=daylight), view)
    assert not picture[..., :3].any()  # the floor is dark from below
    view = replace(view_from((0.0, 3.0, -5.0)), size=(96, 64))
    picture = draw_scene(raster, replace(scene, daylight=daylight), view)
    floor, ball = floor_and_ball(view, centre, radius)
    sun = sun_direction(daylight)
    ray_distance = np.linalg.norm(np.cross(floor - centre, sun), axis=-1)
    slack = 4 * 6 * 2**0.5 / SIDE_PX + 0.004  # texels of the map, and the ball's flat faces
    seen = ~ball & (np.abs(floor[..., [0, 2]]).max(axis=-1) < 2.9)
    dark, bright = seen & (ray_distance < radius - slack), seen & (ray_distance > radius + slack)
    assert dark.sum() > 40 and bright.sum() > 600
    assert not picture[dark][:, :3].any()
    assert picture[bright][:, :3].min() > 0.3


def floor_and_ball(view: SceneView, centre: Array, radius: float) -> tuple[Array, Array]:
    """Return where each pixel meets y = 0, (H, W, 3), and whether a larger ball covers it."""
    to_world = np.linalg.inv(view.world_to_camera)
    x, y = np.meshgrid(np.arange(view.size[0]) + 0.5, np.arange(view.size[1]) + 0.5)
    across, up = x - view.size[0] / 2, view.size[1] / 2 - y
    along = np.stack([across, up, np.full_like(x, -view.focal_px)], -1) @ to_world[:3, :3].T
    eye = to_world[:3, 3]
    ray_distance = np.linalg.norm(np.cross(centre - eye, along), axis=-1) / np.linalg.norm(
        along, axis=-1
    )
    down = np.minimum(along[..., 1], -1e-3)
    return eye - along * (eye[1] / down)[..., None], ray_distance < radius * 1.03


def test_sunlit_ball_has_no_shadow_speckles(raster: SceneRaster) -> None:
    daylight = replace(NIGHT, to_sun=(0.3, 0.2, 1.0), sun=(3.0, 3.0, 3.0))
    picture = draw_scene(raster, scene_of([sphere(0.5, 5)], AHEAD, [WHITE], daylight=daylight))
    lit = picture[8:24, 16:32, 1]
    assert lit.min() > 0.3


def test_surface_is_lit_alike_from_both_sides(raster: SceneRaster) -> None:
    sun = replace(NIGHT, to_sun=(0.0, 0.0, 1.0), sun=(1.0, 1.0, 1.0))
    front = draw_scene(raster, scene_of([plane(1.0)], AHEAD, [WHITE], daylight=sun))
    behind = [(0, placement(z=-2.0) @ np.diag([-1.0, 1.0, -1.0, 1.0]))]
    back = draw_scene(raster, scene_of([plane(1.0)], behind, [WHITE], daylight=sun))
    np.testing.assert_allclose(front, back, rtol=1e-4)
    np.testing.assert_allclose(front[16, 24, :3], OF_WHITE / np.pi, rtol=2e-3)


@pytest.mark.parametrize("distance", [0.5, 1.0, 3.0])
def test_point_light_falls_off_with_square_of_distance(
    raster: SceneRaster, distance: float
) -> None:
    light = PointLight((0.0, 0.0, distance - 2.0), (8.0, 4.0, 0.0))
    wide = replace(VIEW, focal_px=1e4)
    scene = scene_of([plane(9.0)], AHEAD, [WHITE], lights=(light,), daylight=NIGHT)
    expected = np.array([8.0, 4.0, 0.0]) * OF_WHITE / np.pi / distance**2
    np.testing.assert_allclose(draw_scene(raster, scene, wide)[16, 24, :3], expected, rtol=2e-3)


def test_spot_shines_only_into_its_cone(raster: SceneRaster) -> None:
    spot = PointLight((0.0, 0.0, 0.0), (9.0, 9.0, 9.0), (0.0, 0.0, -3.0), (0.999, 0.995))
    picture = draw_scene(
        raster, scene_of([plane(9.0)], AHEAD, [WHITE], lights=(spot,) * 40, daylight=NIGHT)
    )[..., 0]
    # tan(acos 0.995) is 0.1: six pixels
    x, y = np.meshgrid(np.arange(SIZE[0]) - 23.5, np.arange(SIZE[1]) - 15.5)
    np.testing.assert_array_equal(picture > 0, np.hypot(x, y) < 60 * np.tan(np.arccos(0.995)))
    assert picture.max() == pytest.approx(32 * 9 * OF_WHITE / np.pi / 4, rel=0.01)


def test_shader_returns_no_nan(raster: SceneRaster) -> None:
    mesh = sphere(0.5, 2)
    nothing = replace(mesh, normals=np.zeros_like(mesh.normals))
    broken = replace(mesh, normals=np.full_like(mesh.normals, np.nan), uvs=mesh.uvs * np.nan)
    flat = np.diag([1.0, 0.0, 1.0, 1.0])
    flat[2, 3] = -3.0
    places = [
        (0, placement(-0.5, z=-2.0)),
        (1, placement(0.5, z=-2.0)),
        (0, flat),
        (0, placement(scale=1e-9)),
    ]
    materials = [Material(roughness=0.0, metallic=1.0, emission=(np.inf, 0.0, 1.0))]
    light = PointLight((-0.5, 0.0, -1.5), (1e30, 1.0, 1.0))
    daylight = Daylight(to_sun=(0.0, 0.0, 0.0))
    scene = scene_of([nothing, broken], places, materials, lights=(light,), daylight=daylight)
    picture = draw_scene(raster, scene)
    assert np.all(np.isfinite(picture)) and picture.max() <= 65504.0


@given(st.tuples(*[st.floats(-1, 1)] * 3).filter(lambda v: np.linalg.norm(v) > 0.1), st.integers())
@settings(max_examples=50, deadline=None)
def test_sun_view_covers_whole_scene(to_sun: tuple, seed: int) -> None:
    corners = np.random.default_rng(abs(seed)).normal(size=(16, 3)) * (5.0, 1.0, 0.01)
    unit = np.array(to_sun) / np.linalg.norm(to_sun)
    clip, texel = sun_view(corners, unit)
    seen = corners @ clip[:3, :3].T + clip[:3, 3]
    assert np.abs(seen).max() <= 1.0
    nearer = clip[:3, :3] @ unit
    np.testing.assert_allclose(nearer[:2], 0.0, atol=1e-9)
    assert nearer[2] < 0 and 0 < texel < 0.03


def test_layer_size_is_largest_map_within_memory() -> None:
    small, wide = np.zeros((8, 4, 4), np.uint8), np.zeros((2, 64, 4), np.uint8)
    assert layer_size([small, wide]) == (64, 8)
    assert layer_size([np.broadcast_to(small[:1, :1], (4096, 4096, 4))] * 200) == (512, 512)


def test_map_colors_surface_at_its_uvs(raster: SceneRaster) -> None:
    image = np.zeros((64, 64, 4), np.uint8)
    image[:32, :32] = 255, 0, 0, 255  # the upper left
    image[32:, 32:] = 0, 188, 0, 255  # sRGB for a half
    material = replace(lamp((2.0, 2.0, 2.0)), emission_map=1)
    images = (np.full((2, 2, 4), 255, np.uint8), image)
    scene = scene_of([plane(0.6)], AHEAD, [material], images=images, daylight=NIGHT)
    picture = draw_scene(raster, scene)[..., :3]
    np.testing.assert_allclose(picture[8, 14], (2.0, 0.0, 0.0))
    np.testing.assert_allclose(picture[24, 34], (0.0, 1.0, 0.0), atol=0.01)
    assert picture[8, 34].tolist() == list(BLACK)


@pytest.mark.parametrize("roughness", [0.6, 0.8, 1.0])
@pytest.mark.parametrize("eye", [(0.0, 1.0, 1e-3), (0.8, 0.6, 0.0)])
def test_rough_white_metal_reflects_all_light(
    raster: SceneRaster, roughness: float, eye: tuple
) -> None:
    """Lamps all around, each for an equal share of the hemisphere, are a furnace."""
    far_m, rows, columns = 1e3, 4, 8
    up = np.sqrt((np.arange(rows) + 0.5) / rows)
    turn = 2 * np.pi * (np.arange(columns) + 0.25) / columns
    lights = [
        PointLight(
            (far_m * aside * np.cos(t), far_m * height, far_m * aside * np.sin(t)),
            (far_m**2 * np.pi / (rows * columns) / height,) * 3,
        )
        for height, aside in zip(up, np.sqrt(1 - up * up), strict=True)
        for t in turn
    ]
    metal = Material(base_color=(1.0, 1.0, 1.0), roughness=roughness, metallic=1.0)
    scene = replace(
        scene_of([plane(3.0, "y")], [(0, np.eye(4))], [metal], daylight=NIGHT), lights=tuple(lights)
    )
    picture = draw_scene(raster, scene, view_from(eye))
    assert picture[16, 24, 0] == pytest.approx(1.0, abs=0.06)
