"""Test partly transparent surfaces, drawn alike by ray tracer and rasterizer."""

from dataclasses import replace

import numpy as np
import pytest

from heatlens.core.model.lens.pupil import PINHOLE
from heatlens.media.scene.material import MapPlace, Material
from heatlens.media.scene.scene_view import SceneView
from heatlens.render.defocus.plate_passes import CropPass
from heatlens.render.gpu.textures import download, new_texture
from heatlens.render.scene_gpu.antialias import Antialias
from heatlens.render.scene_gpu.raster import SceneRaster
from heatlens.render.scene_gpu.ray_tracer import RayTracer
from heatlens.render.scene_gpu.scene_buffers import Instances
from support.scenes import BLACK, NIGHT, even_sky, lamp, placement, plane, scene_of

VIEW = SceneView(
    world_to_camera=np.eye(4), size=(12, 8), focal_px=10.0, focus_m=np.inf, near_m=0.1, far_m=100.0
)
RED, GREEN = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)


def panes_before_wall(*alphas, **fields):
    """Return a scene of red panes one behind the other, and a green wall."""
    glass_materials = [
        replace(lamp(RED), base_alpha=alpha, is_blended=True, **fields) for alpha in alphas
    ]
    places = [(i, placement(z=-2.0 - i)) for i in range(len(alphas) + 1)]
    meshes = [plane(20.0, material=i) for i in range(len(alphas) + 1)]
    return scene_of(meshes, places, [*glass_materials, lamp(GREEN)], daylight=NIGHT)


@pytest.fixture(scope="module")
def render_both(session_context):
    """Return a function that renders a scene by rasteriser and by rays, 64 samples a pixel."""
    ctx = session_context
    raster = SceneRaster(ctx)
    antialias, rays = Antialias(ctx, raster), RayTracer(ctx, raster)
    crop = CropPass(ctx)

    def raster_steps(out):
        yield from antialias.steps(VIEW, 8, 1, 0, object())
        crop.run(antialias.picture(VIEW.size).mean, (0, 0), out)

    def ray_steps(out):
        return rays.steps(VIEW, PINHOLE, 64, out, object())

    def pictures(scene):
        found = []
        for method in (raster_steps, ray_steps):
            raster.load(scene)
            raster.place(1)
            out = new_texture(ctx, VIEW.size, 4)
            for _ in method(out):
                pass
            found.append(download(out)[..., :3])
            out.release()
        return found

    yield pictures
    for resource in (crop, rays, antialias, raster):
        resource.release()


@pytest.mark.parametrize("alphas", [(0.3,), (0.5, 0.5), (0.9, 0.2), (0.0,), (1.0,)])
def test_blended_panes_multiply_their_transparencies(render_both, alphas):
    green = np.prod(1 - np.array(alphas))
    expected = (1 - green, green, 0.0)
    drawn, traced = render_both(panes_before_wall(*alphas))
    np.testing.assert_allclose(drawn.mean(axis=(0, 1)), expected, atol=0.02)
    np.testing.assert_allclose(traced.mean(axis=(0, 1)), expected, atol=0.03)
    # The samples of a pixel are spread, so that 64 of them are as good as thousands at random.
    assert np.percentile(np.abs(drawn - expected), 95) < (0.02 if len(alphas) == 1 else 0.1)


def test_raster_depth_is_that_of_surface_covering_half(ctx):
    raster = SceneRaster(ctx)
    depth = new_texture(ctx, VIEW.size, 1)
    for alpha, expected_m in ((0.4, 3.0), (0.6, 2.0)):
        raster.load(panes_before_wall(alpha))
        raster.place(1)
        raster.depth(replace(VIEW, sample=7), depth)
        np.testing.assert_allclose(download(depth), expected_m, rtol=1e-4)
    raster.release()
    depth.release()


def test_unlit_surface_ignores_the_light(render_both):
    color = (0.3, 0.5, 0.7)
    unlit = Material(base_color=color, is_lit=False)
    for daylight in (NIGHT, even_sky()):
        scene = scene_of([plane(20.0)], [(0, placement(z=-2.0))], [unlit], daylight=daylight)
        for picture in render_both(scene):
            np.testing.assert_allclose(picture, np.broadcast_to(color, picture.shape), 1e-5)


def test_maps_use_their_own_uv_placement(render_both):
    """The left half of the map is red and the right half is green."""
    image = np.zeros((1, 2, 4), np.uint8)
    image[0, 0], image[0, 1] = (255, 0, 0, 255), (0, 255, 0, 255)
    first, second = (np.tile(np.float32([[u, 0.5]]), (4, 1)) for u in (0.25, 0.9))
    sheet, ahead = replace(plane(20.0), uvs=first, more_uvs=second), [(0, placement(z=-2.0))]
    for chosen, expected in (
        (MapPlace(), RED),
        (MapPlace(offset=(0.5, 0.0)), GREEN),
        (MapPlace(1, offset=(-0.15, 0.0)), GREEN),
        (MapPlace(1, ((0.0, 0.5), (0.0, 1.0))), RED),
    ):
        places = (MapPlace(), MapPlace(), chosen, MapPlace(), MapPlace())
        shining = Material("", BLACK, emission=(1.0, 1.0, 1.0), emission_map=0, map_places=places)
        scene = scene_of([sheet], ahead, [shining], images=(image,), daylight=NIGHT)
        for picture in render_both(scene):
            np.testing.assert_allclose(picture[4, 6], expected, atol=1e-5)


def test_holes_change_nothing_of_surfaces_without_them(ctx):
    solid = scene_of([plane(20.0)], [(0, placement(z=-3.0))], [lamp(GREEN)], daylight=NIGHT)
    both = panes_before_wall(0.0)
    raster, depth = SceneRaster(ctx), new_texture(ctx, VIEW.size, 1)
    depths_m = []
    for scene in (solid, both):
        raster.load(scene)
        raster.place(1)
        kinds = raster.buffers.commands
        assert kinds[Instances.SOLID][1] + kinds[Instances.HOLED][1] == len(scene.instances)
        assert kinds[Instances.SOLID][1] == 1
        raster.depth(VIEW, depth)
        depths_m.append(download(depth))
    np.testing.assert_array_equal(*depths_m)
    raster.release()
    depth.release()
