"""Test the scene rasterizer against known geometry: positions and depths."""

from dataclasses import replace
from itertools import product

import numpy as np
import pytest

from heatlens.core.model.boxes import Box
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.lens.pupil import PINHOLE
from heatlens.core.model.shot.camera_track import pose_looking_at
from heatlens.media.scene.material import Material
from heatlens.media.scene.scene import Array, Scene
from heatlens.media.scene.scene_bounds import bounds_m
from heatlens.media.scene.scene_view import SceneView, view_of
from heatlens.render.gpu.device import Device
from heatlens.render.gpu.textures import download, new_texture
from heatlens.render.scene_gpu.accumulation import Accumulation, lens_samples
from heatlens.render.scene_gpu.raster import SceneRaster
from support.rounding import tolerance_for
from support.scenes import NIGHT, lamp, placement, plane, scene_of, sphere, still_life

SIZE = (48, 32)
VIEW = SceneView(
    world_to_camera=np.eye(4), size=SIZE, focal_px=60.0, focus_m=np.inf, near_m=0.1, far_m=100.0
)
LIGHT = (0.5, 2.25, 500.0)


def draw_scene(raster: SceneRaster, scene: Scene, view: SceneView = VIEW) -> Array:
    """Return (H, W, 4) with one sample a pixel."""
    raster.load(scene)
    raster.place(1)
    return draw_loaded(raster, view)


def draw_loaded(raster: SceneRaster, view: SceneView = VIEW) -> Array:
    color = new_texture(raster._ctx, view.size, 4)
    raster.draw(view, color)
    picture = download(color)
    color.release()
    return picture


def pinhole(raster: SceneRaster, scene: Scene, view: SceneView = VIEW) -> tuple[Array, Array]:
    """Return colour (H, W, 4) of one sample a pixel and depth (H, W)."""
    color = draw_scene(raster, scene, view)
    return color, depth_loaded(raster, view)


def depth_loaded(raster: SceneRaster, view: SceneView = VIEW) -> Array:
    depth = new_texture(raster._ctx, view.size, 1)
    raster.depth(view, depth)
    picture = download(depth)
    depth.release()
    return picture


def pixel_rays(view: SceneView) -> Array:
    """Return rays (H, W, 3) through the middles of pixels, one metre deep."""
    x, y = np.meshgrid(np.arange(view.size[0]) + 0.5, np.arange(view.size[1]) + 0.5)
    across, up = x - view.size[0] / 2, view.size[1] / 2 - y
    return np.stack([across / view.focal_px, up / view.focal_px, -np.ones_like(x)], axis=-1)


def view_from(view: SceneView, eye: tuple[float, float, float]) -> SceneView:
    """Return the view from `eye` to the origin."""
    return replace(view, world_to_camera=pose_looking_at(eye, (0.0, 0.0, 0.0)).world_to_camera)


@pytest.mark.parametrize("eye", [(0.0, 0.0, 3.0), (1.0, 2.0, 4.0), (-20.0, 9.0, 30.0)])
def test_depth_of_plane_is_planar_and_exact(ctx: Device, raster: SceneRaster, eye: tuple) -> None:
    view = view_from(VIEW, eye)
    _, depth = pinhole(raster, scene_of([plane(30.0, "z")]), view)
    to_world = np.linalg.inv(view.world_to_camera)
    along = pixel_rays(view) @ to_world[:3, :3].T
    expected = -to_world[2, 3] / along[..., 2]
    is_finite = np.isfinite(depth)
    assert is_finite.mean() > 0.9
    np.testing.assert_allclose(
        depth[is_finite], expected[is_finite], rtol=tolerance_for(ctx, 1e-5, 2e-4)
    )


def test_depth_of_sphere_lies_between_corners_and_faces(raster: SceneRaster) -> None:
    mesh = sphere(1.0, 4)
    scene = scene_of([mesh], [(0, placement(0.3, -0.2, -5.0))])
    _, depth = pinhole(raster, scene, replace(VIEW, focal_px=70.0))
    corners = mesh.positions_m[mesh.triangles].astype(float)
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    heights = np.einsum("ij,ij->i", normals, corners[:, 0]) / np.linalg.norm(normals, axis=1)
    view = replace(VIEW, focal_px=70.0)
    outer, inner = (sphere_depth(view, (0.3, -0.2, -5.0), r) for r in (1.0, heights.min()))
    sure = np.isfinite(inner)
    assert sure.mean() > 0.3
    assert np.all(depth[sure] >= outer[sure] * (1 - 1e-5))
    assert np.all(depth[sure] <= inner[sure] * (1 + 1e-5))
    assert np.all(np.isposinf(depth[np.isinf(outer)]))


def sphere_depth(view: SceneView, centre: tuple, radius: float) -> Array:
    """Return the planar depth of the near side, infinite outside."""
    along = pixel_rays(view)
    a, b = (along**2).sum(-1), along @ np.array(centre)
    inside = b * b - a * (np.dot(centre, centre) - radius**2)
    return np.where(inside > 0, (b - np.sqrt(np.maximum(inside, 0))) / a, np.inf)


def test_depth_is_that_of_pixel_center(ctx: Device, raster: SceneRaster) -> None:
    scene = scene_of([plane(3.0, "y")], [(0, placement(y=-0.5, z=-4.0))])
    _, middle = pinhole(raster, scene)
    down = -pixel_rays(VIEW)[..., 1]
    is_finite = np.isfinite(middle)
    assert 0.2 < is_finite.mean() < 0.5
    np.testing.assert_allclose(
        middle[is_finite], 0.5 / down[is_finite], rtol=tolerance_for(ctx, 1e-5, 2e-4)
    )


def left_half(edge_px: float, slope: float = 0.0) -> Scene:
    """Return a lamp 1 m away whose right edge is at `edge_px` and `slope` farther right per row
    down.
    """
    mesh = plane(20.0)
    x, y = mesh.positions_m[:, 0], mesh.positions_m[:, 1]
    edge = (edge_px - SIZE[0] / 2) / VIEW.focal_px
    x[:] = np.where(x > 0, edge - slope * y, 3 * x)
    return scene_of([mesh], [(0, placement(z=-1.0))], [lamp(LIGHT)], daylight=NIGHT)


def test_jitter_to_the_right_shows_what_is_right(raster: SceneRaster) -> None:
    picture = draw_scene(raster, left_half(10.7))
    assert picture[0, 10, 0] > 0 and picture[0, 11, 0] == 0
    right = draw_loaded(raster, replace(VIEW, jitter_px=(0.4, 0.0)))
    assert right[0, 9, 0] > 0 and right[0, 10, 0] == 0


def test_jitter_down_shows_what_is_below(raster: SceneRaster) -> None:
    turn = np.array([[0.0, 1, 0, 0], [-1, 0, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]])
    scene = left_half(SIZE[0] / 2 + 2.3)  # turned so that the dark half is below
    scene = scene_of(scene.meshes, [(0, placement(z=-1.0) @ turn)], scene.materials, daylight=NIGHT)
    middle = SIZE[1] // 2
    picture = draw_scene(raster, scene)[:, 5, 0]
    assert picture[middle + 1] > 0 and picture[middle + 2] == 0
    low = draw_loaded(raster, replace(VIEW, jitter_px=(0.0, -0.4)))[:, 5, 0]
    assert low[middle + 2] > 0 and low[middle + 3] == 0


@pytest.mark.parametrize("slope", [0.0, 0.37, -1.0])
@pytest.mark.parametrize("views", [16, 64, 256])
@pytest.mark.parametrize("storage", ["f2", "f4"])
def test_pinhole_views_converge_to_covered_area(
    raster: SceneRaster, slope: float, views: int, storage: str
) -> None:
    """At its worst an even net errs less than random points do on the mean: 0.5 / sqrt(views)."""
    draw_scene(raster, left_half(20.3, slope))
    accumulation = Accumulation(raster._ctx, raster)
    color = new_texture(raster._ctx, VIEW.size, 4, storage)
    assert len(list(accumulation.steps(VIEW, PINHOLE, views, color, "key"))) == views
    wrong = download(color)[..., 0] / LIGHT[0] - covered_share(20.3, slope)
    assert np.abs(wrong).max() < 0.5 / np.sqrt(views)
    accumulation.release(), color.release()


def test_lamp_smaller_than_pixel_keeps_its_light(raster: SceneRaster) -> None:
    """64 views give its light within a twentieth, wherever in the pixel it is."""
    for place in (0.0, 0.3, 0.71):
        mesh = plane(0.3 / VIEW.focal_px)  # 0.6 px wide, 1 m away
        at = placement(place / VIEW.focal_px, 0.4 / VIEW.focal_px, -1.0)
        draw_scene(raster, scene_of([mesh], [(0, at)], [lamp(LIGHT)], daylight=NIGHT))
        jitters = lens_samples(0, 64, PINHOLE)[1].tolist()
        light = sum(draw_loaded(raster, replace(VIEW, jitter_px=tuple(j))).sum() for j in jitters)
        alpha = 64 * SIZE[0] * SIZE[1]
        assert (light - alpha) / 64 == pytest.approx(0.36 * sum(LIGHT), rel=0.05)


def covered_share(edge_px: float, slope: float) -> Array:
    """Return (H, W), the share of each pixel left of the edge, by 64x64 points in it."""
    fine = (np.arange(64) + 0.5) / 64
    y = np.arange(SIZE[1])[:, None, None, None] + fine[:, None] - SIZE[1] / 2
    x = np.arange(SIZE[0])[:, None, None] + fine
    return (x < edge_px + slope * y).mean(axis=(-2, -1))


def test_instances_are_drawn_as_separate_meshes(raster: SceneRaster) -> None:
    places = [
        placement(-0.6, 0.1, -3.0, 0.4),
        placement(0.5, 0.0, -2.5, 0.3),
        placement(0.0, -0.3, -4.0),
    ]
    rock, tile = sphere(0.8, 2, 0), plane(0.5, "z", 1)
    materials = (Material(base_color=(0.9, 0.2, 0.1)), Material(roughness=0.2))
    shared = [(0, places[0]), (1, placement(0.2, 0.3, -2.0, 0.5)), (0, places[1]), (0, places[2])]
    shared_image = draw_scene(raster, scene_of([rock, tile], shared, materials))
    separate = [(i, at) for i, (_, at) in enumerate(shared)]
    separate_image = draw_scene(raster, scene_of([rock, tile, rock, rock], separate, materials))
    np.testing.assert_array_equal(shared_image, separate_image)
    assert len(np.unique(shared_image[..., 0])) > 50


def test_moving_object_is_drawn_at_current_position(raster: SceneRaster) -> None:
    def motion(frame: float) -> Array:
        return placement(z=-2.0 - frame)[None]

    raster.load(replace(scene_of([plane(9.0)]), motion=motion))
    for frame in (0.0, 1.0, 2.5):
        raster.place(frame)
        np.testing.assert_allclose(depth_loaded(raster), 2.0 + frame, rtol=1e-5)


def test_alpha_hole_shows_what_is_behind(raster: SceneRaster) -> None:
    image = np.full((2, 2, 4), 255, np.uint8)
    image[0, :, 3] = 0  # the upper half
    front = Material("leaf", emission=LIGHT, alpha_cutoff=0.5, base_color_map=0)
    meshes = (plane(1.0, "z", 0), plane(9.0, "z", 1))
    places = [(0, placement(z=-3.0)), (1, placement(z=-5.0))]
    scene = scene_of(meshes, places, (front, lamp((0.25, 0.0, 0.0))), images=(image,))
    color, depth = pinhole(raster, replace(scene, daylight=NIGHT))
    middle = SIZE[0] // 2
    assert depth[9, middle] == pytest.approx(5.0) and depth[22, middle] == pytest.approx(3.0)
    assert color[9, middle, 0] == 0.25 and color[22, middle, 1] == LIGHT[1]


def test_lens_points_agree_at_focus_distance(raster: SceneRaster) -> None:
    scene, view = left_half(20.5), replace(VIEW, focus_m=1.0)
    middle = draw_scene(raster, scene, view)
    edge = draw_loaded(raster, replace(view, offset_m=(0.05, 0.03)))
    np.testing.assert_array_equal(middle, edge)
    defocused = draw_loaded(raster, replace(view, offset_m=(0.05, 0.03), focus_m=2.0))
    # F u (1/S - 1/z) = 60 * 0.05 * (1/2 - 1) px
    np.testing.assert_array_equal(defocused[:, 17:20, 0] > 0, [[True, True, False]] * SIZE[1])


def test_raster_draws_into_half_float_textures_of_changing_size(raster: SceneRaster) -> None:
    draw_scene(raster, left_half(10.7))
    for number in range(9):
        color = new_texture(raster._ctx, (8 + number, 8), 4, "f2")
        raster.draw(replace(VIEW, size=color.size), color)
        color.release()
    assert raster._ctx.error == ""


def test_still_life_is_drawn_through_its_camera(raster: SceneRaster) -> None:
    scene, lens = still_life(), Lens(50.0, 2.8, 3.5, 36.0)
    view = view_of(scene.cameras[0].track.pose_at(1), lens, SIZE, bounds_m(scene, 1))
    color, depth = pinhole(raster, scene, view)
    assert np.all(np.isfinite(color)) and np.all(color[..., 3] == 1.0)
    assert 2.0 < depth.min() and 0.2 < np.isinf(depth).mean() < 0.5
    assert color.max() == pytest.approx(40.0, rel=0.2)


def test_band_leaves_out_what_it_cannot_show_and_nothing_else(ctx, rows=8):
    """All parts of eight bands are the whole picture, and each draws fewer instances than it."""
    rng = np.random.default_rng(5)
    middles = rng.uniform((-12, -8, -30), (12, 8, 2), (60, 3))
    places = [(0, placement(*map(float, middle))) for middle in middles]
    raster, view = SceneRaster(ctx), replace(VIEW, jitter_px=(0.3, -0.4))
    whole = draw_scene(raster, scene_of((sphere(0.6, splits=1),), places), view)
    color, counts = new_texture(ctx, SIZE, 4), []
    for x, y in product((0, 5), range(0, SIZE[1], rows)):
        band = Box(x, y, SIZE[0] if x else 5, y + rows)
        counts.append(int(raster.may_show(view, band).sum()))
        raster.draw(view, color, band)
        part = slice(band.y0, band.y1), slice(band.x0, band.x1)
        np.testing.assert_array_equal(download(color)[part], whole[part])
    assert max(counts) < 40 and sum(counts) > 0
