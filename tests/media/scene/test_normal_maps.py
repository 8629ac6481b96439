"""Test normal and occlusion maps as they are rasterized and ray traced."""

from dataclasses import replace

import numpy as np
import pytest

from heatlens.media.scene.material import Material
from heatlens.media.scene.mesh_make import add_tangents
from heatlens.media.scene.scene import Mesh, PointLight, Scene
from heatlens.render.scene_gpu.scene_buffers import SceneBuffers
from heatlens.render.scene_gpu.scene_records import VERTEX
from support.scenes import NIGHT, even_sky, placement, plane, scene_of, sphere, still_life

LAMP = PointLight((1.5, 1.0, 2.0), (9.0, 8.0, 7.0))
CLAY = Material(base_color=(0.6, 0.5, 0.4), roughness=0.7, metallic=0.2)
TEXEL = (180, 90, 220)
FLAT = (128, 128, 255)
RIGHT, UP, OUT = np.eye(3)


def one_texel(texel: tuple[int, int, int]) -> np.ndarray:
    """Return one texel, everywhere."""
    return np.full((1, 1, 4), (*texel, 255), np.uint8)


def noise_map(side: int = 16) -> np.ndarray:
    """Return bumps of all directions that change from texel to texel."""
    pixels = np.random.default_rng(7).integers(60, 200, (side, side, 4))
    pixels[..., 2] = 230
    return pixels.astype(np.uint8)


def lit_scene(mesh: Mesh, image: np.ndarray | None = None, place=None, **look: object) -> Scene:
    """Return a scene with one lamp at night, so that only normals matter."""
    material = CLAY if image is None else replace(CLAY, normal_map=0, **look)
    places = None if place is None else [(0, place)]
    images = () if image is None else (image,)
    scene_options = {"images": images, "lights": (LAMP,), "daylight": NIGHT}
    return scene_of([mesh], places, [material], **scene_options)


def with_normals(mesh: Mesh, normal: np.ndarray) -> Mesh:
    """Return the mesh with one normal at all its vertices."""
    return replace(mesh, normals=np.tile(np.float32(normal), (len(mesh.normals), 1)))


def expected_normal(texel, scale: float, along, up, out) -> np.ndarray:
    """Return the normal by the formula of glTF 2.0, section 3.9.3."""
    x, y, z = 2 * np.array(texel) / 255 - 1
    normal = scale * x * along + scale * y * up + z * out
    return normal / np.linalg.norm(normal)


def assert_images_close(found: np.ndarray, expected: np.ndarray, share: float = 2e-3) -> None:
    """Check that two pictures that are not empty agree within half float precision."""
    assert expected.max() > 0.05
    np.testing.assert_allclose(found, expected, rtol=share, atol=share * expected.max())


@pytest.mark.parametrize("scale", [0.5, 1.0, 2.0, -1.0])
def test_normal_map_tilts_normal_by_formula(stage, scale):
    sheet = plane(0.7)
    scene = lit_scene(add_tangents(sheet), one_texel(TEXEL), normal_scale=scale)
    expected = stage.seen(
        lit_scene(with_normals(sheet, expected_normal(TEXEL, scale, RIGHT, UP, OUT)))
    )
    assert_images_close(stage.seen(scene), expected)
    assert np.abs(expected - stage.seen(lit_scene(sheet))).max() > 0.02


@pytest.mark.parametrize(
    ("mirror", "along", "up"),
    [((-1, 1), -RIGHT, UP), ((1, -1), RIGHT, -UP), ((-1, -1), -RIGHT, -UP)],
)
def test_normal_map_mirrored_in_uv_is_mirrored(stage, mirror, along, up):
    sheet = plane(0.7)
    mirrored_mesh = add_tangents(replace(sheet, uvs=np.float32(sheet.uvs * mirror)))
    assert (mirrored_mesh.tangents[:, 3] == np.prod(mirror)).all()
    expected = stage.seen(
        lit_scene(with_normals(sheet, expected_normal(TEXEL, 1.0, along, up, OUT)))
    )
    assert_images_close(stage.seen(lit_scene(mirrored_mesh, one_texel(TEXEL))), expected)


def test_normal_map_uses_tangents_of_mesh(stage):
    sheet = plane(0.7)
    mesh_with_tangents = replace(
        sheet, tangents=np.tile(np.float32([*UP, -1]), (4, 1))
    )  # then y is to the right
    expected = stage.seen(
        lit_scene(with_normals(sheet, expected_normal(TEXEL, 1.0, UP, RIGHT, OUT)))
    )
    assert_images_close(stage.seen(lit_scene(mesh_with_tangents, one_texel(TEXEL))), expected)


def test_normal_map_projects_tangent_onto_surface(stage):
    sheet = plane(0.7)
    leaning = replace(sheet, tangents=np.tile(np.float32([0.6, 0, 0.8, 1]), (4, 1)))
    expected = stage.seen(lit_scene(add_tangents(sheet), one_texel(TEXEL)))
    assert_images_close(stage.seen(lit_scene(leaning, one_texel(TEXEL))), expected, 1e-4)


@pytest.mark.parametrize("turn", [1.0, -1.0])
def test_normal_map_of_mirrored_instance_is_mirrored(stage, turn):
    ball = add_tangents(sphere(0.7))
    place = np.diag([turn, 0.8, 1.2, 1.0])
    positions = np.float32(ball.positions_m * np.diag(place)[:3])
    normals = ball.normals / np.diag(place)[:3]
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    baked_ball = replace(
        ball,
        positions_m=positions,
        normals=np.float32(normals),
        tangents=None,
        triangles=np.ascontiguousarray(ball.triangles[:, :: int(turn)]),
    )
    found = stage.seen(lit_scene(ball, noise_map(), place))
    expected = stage.seen(lit_scene(add_tangents(baked_ball), noise_map()))
    is_other = np.abs(found - expected).max(axis=-1) > 0.02 * expected.max()
    assert is_other.mean() < 0.03  # tangents of stretched triangles weigh a little otherwise
    assert (
        np.abs(found - stage.seen(lit_scene(ball, None, place))).max(axis=-1) > 0.05
    ).mean() > 0.1


TURNED = np.array([[0.6, -0.7, 0.1, 0.2], [0.8, 0.6, 0.2, 0.1], [0.1, -0.3, 1.1, 0], [0, 0, 0, 1]])


@pytest.mark.parametrize("place", [placement(), TURNED])
def test_normal_map_is_same_in_ray_tracer_and_raster(stage, place):
    drawn, traced = stage.seen(lit_scene(add_tangents(sphere(0.8)), noise_map(), place))
    assert_images_close(drawn, traced, 1e-2)
    assert np.abs(np.diff(drawn, axis=1)).max() > 0.1


def test_normal_map_survives_small_scale(stage):
    sheet, normal = plane(7e4), expected_normal(TEXEL, 1.0, RIGHT, UP, OUT)
    scene = lit_scene(add_tangents(sheet), one_texel(TEXEL), placement(scale=1e-5))
    assert_images_close(stage.seen(scene), stage.seen(lit_scene(with_normals(plane(0.7), normal))))


def test_normal_map_is_inverted_on_back_side(stage):
    """Seen from behind, the whole normal is flipped, as in section 3.7.2.1 for two sides."""
    sheet = plane(0.7)
    about = np.diag([-1.0, 1.0, -1.0, 1.0])
    normal = expected_normal(TEXEL, 1.0, RIGHT, UP, OUT) * (-1, 1, -1)
    expected = stage.seen(lit_scene(with_normals(sheet, -normal)))
    assert_images_close(
        stage.seen(lit_scene(add_tangents(sheet), one_texel(TEXEL), about)), expected
    )


def test_flat_normal_map_equals_no_map_within_8_bits(stage):
    ball = add_tangents(sphere(0.8))
    found, expected = stage.seen(lit_scene(ball, one_texel(FLAT))), stage.seen(lit_scene(ball))
    assert_images_close(found, expected, 2e-2)
    assert np.abs(found - expected).mean() < 2e-3 * expected.max()


def test_normal_map_of_zero_scale_equals_no_map(stage):
    ball = add_tangents(sphere(0.8))
    assert_images_close(
        stage.seen(lit_scene(ball, noise_map(), normal_scale=0.0)),
        stage.seen(lit_scene(ball)),
        1e-4,
    )


@pytest.mark.parametrize("kind", ["no uvs", "a line of uvs", "no tangents", "upright", "black"])
def test_normal_map_without_direction_keeps_surface_normal(stage, kind):
    ball = sphere(0.8)
    if kind != "no tangents":
        uvs = {"no uvs": 0 * ball.uvs, "a line of uvs": ball.uvs[:, :1] * np.float32([1, 2])}
        ball = add_tangents(replace(ball, uvs=uvs.get(kind, ball.uvs)))
    if kind == "upright":
        ones = np.ones((len(ball.normals), 1), np.float32)
        ball = replace(ball, tangents=np.concatenate([ball.normals, ones], axis=1))
    image = one_texel((128, 128, 0)) if kind == "black" else noise_map()
    scale = 0.0 if kind == "black" else 1.0
    assert_images_close(
        stage.seen(lit_scene(ball, image, normal_scale=scale)), stage.seen(lit_scene(ball)), 1e-4
    )


def test_mesh_without_normal_map_is_unchanged_beside_one_with(stage):
    left, right = placement(-0.8, scale=0.5), placement(0.8, scale=0.5)
    scene_without_map = scene_of([sphere(), sphere()], [(0, left), (1, right)], [CLAY])
    bumpy = replace(CLAY, normal_map=0)
    meshes = (add_tangents(replace(sphere(), material=1)), sphere())
    scene_with_map = replace(
        scene_without_map, meshes=meshes, materials=(CLAY, bumpy), images=(noise_map(),)
    )
    found, before = stage.seen(scene_with_map), stage.seen(scene_without_map)
    np.testing.assert_allclose(found[:, :, 16:], before[:, :, 16:], atol=1e-5)
    assert np.abs(found[:, :, :16] - before[:, :, :16]).max() > 0.02


def test_scene_without_normal_maps_stores_no_tangents(ctx):
    plain, bumpy = still_life(), lit_scene(add_tangents(plane()), noise_map())
    for scene, has_bumps in ((plain, False), (bumpy, True)):
        buffers = SceneBuffers(ctx, scene)
        count = sum(len(mesh.positions_m) for mesh in scene.meshes)
        assert buffers.vertices.size == count * (VERTEX.itemsize + 16 * has_bumps)
        assert ("BUMPS" in buffers.defines) == has_bumps
        buffers.release()


@pytest.mark.parametrize(("strength", "share"), [(0.0, 1.0), (0.5, 0.6), (1.0, 0.2)])
def test_occlusion_map_darkens_sky_light_only(stage, strength, share):
    shaded = replace(CLAY, occlusion_map=0, occlusion=strength)
    image_options = {"images": (one_texel((51, 255, 255)),)}
    sky, lamp = {"daylight": even_sky()}, {"lights": (LAMP,), "daylight": NIGHT}
    for light, part in ((sky, share), (lamp, 1.0)):
        found = stage.seen(scene_of([plane(2.0)], materials=[shaded], **image_options, **light))
        assert_images_close(
            found,
            part * stage.seen(scene_of([plane(2.0)], materials=[CLAY], **image_options, **light)),
        )
