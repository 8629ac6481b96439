"""Maps of normals and of occlusion as they are seen: drawn, and by rays."""

from dataclasses import replace

import numpy as np
import pytest

from heatlens.media.scene.mesh_make import with_tangents
from heatlens.media.scene.scene import Material, Mesh, PointLight, Scene
from heatlens.render.scene_gpu.scene_buffers import VERTEX, SceneBuffers
from support.scenes import NIGHT, even_sky, moved, plane, scene_of, sphere, still_life

LAMP = PointLight((1.5, 1.0, 2.0), (9.0, 8.0, 7.0))
CLAY = Material(base_color=(0.6, 0.5, 0.4), roughness=0.7, metallic=0.2)
TEXEL = (180, 90, 220)
FLAT = (128, 128, 255)
RIGHT, UP, OUT = np.eye(3)


def picture(texel: tuple[int, int, int]) -> np.ndarray:
    """Return one texel, everywhere."""
    return np.full((1, 1, 4), (*texel, 255), np.uint8)


def noise(side: int = 16) -> np.ndarray:
    """Return bumps of all directions that change from texel to texel."""
    pixels = np.random.default_rng(7).integers(60, 200, (side, side, 4))
    pixels[..., 2] = 230
    return pixels.astype(np.uint8)


def lit(mesh: Mesh, image: np.ndarray | None = None, place=None, **look: object) -> Scene:
    """Return a scene with one lamp at night, so that only normals make a difference."""
    material = CLAY if image is None else replace(CLAY, normal_map=0, **look)
    places = None if place is None else [(0, place)]
    images = () if image is None else (image,)
    told = {"images": images, "lights": (LAMP,), "daylight": NIGHT}
    return scene_of([mesh], places, [material], **told)


def bent(mesh: Mesh, normal: np.ndarray) -> Mesh:
    """Return the mesh with other normals at its vertices."""
    return replace(mesh, normals=np.tile(np.float32(normal), (len(mesh.normals), 1)))


def tilted(texel, scale: float, along, up, out) -> np.ndarray:
    """Return the formula of glTF 2.0, section 3.9.3."""
    x, y, z = 2 * np.array(texel) / 255 - 1
    normal = scale * x * along + scale * y * up + z * out
    return normal / np.linalg.norm(normal)


def same(found: np.ndarray, expected: np.ndarray, share: float = 2e-3) -> None:
    """Check that two pictures that are not empty agree within half float precision."""
    assert expected.max() > 0.05
    np.testing.assert_allclose(found, expected, rtol=share, atol=share * expected.max())


@pytest.mark.parametrize("scale", [0.5, 1.0, 2.0, -1.0])
def test_a_normal_is_tilted_as_the_formula_says(stage, scale):
    sheet = plane(0.7)
    scene = lit(with_tangents(sheet), picture(TEXEL), normal_scale=scale)
    expected = stage.seen(lit(bent(sheet, tilted(TEXEL, scale, RIGHT, UP, OUT))))
    same(stage.seen(scene), expected)
    assert np.abs(expected - stage.seen(lit(sheet))).max() > 0.02


@pytest.mark.parametrize(
    ("mirror", "along", "up"),
    [((-1, 1), -RIGHT, UP), ((1, -1), RIGHT, -UP), ((-1, -1), -RIGHT, -UP)],
)
def test_a_picture_that_lies_mirrored_is_bumpy_as_it_lies(stage, mirror, along, up):
    sheet = plane(0.7)
    turned = with_tangents(replace(sheet, uvs=np.float32(sheet.uvs * mirror)))
    assert (turned.tangents[:, 3] == np.prod(mirror)).all()
    expected = stage.seen(lit(bent(sheet, tilted(TEXEL, 1.0, along, up, OUT))))
    same(stage.seen(lit(turned, picture(TEXEL))), expected)


def test_tangents_that_a_mesh_tells_are_taken(stage):
    sheet = plane(0.7)
    told = replace(sheet, tangents=np.tile(np.float32([*UP, -1]), (4, 1)))  # then y is to the right
    expected = stage.seen(lit(bent(sheet, tilted(TEXEL, 1.0, UP, RIGHT, OUT))))
    same(stage.seen(lit(told, picture(TEXEL))), expected)


def test_a_tangent_that_leans_out_of_the_surface_is_laid_down_on_it(stage):
    sheet = plane(0.7)
    leaning = replace(sheet, tangents=np.tile(np.float32([0.6, 0, 0.8, 1]), (4, 1)))
    expected = stage.seen(lit(with_tangents(sheet), picture(TEXEL)))
    same(stage.seen(lit(leaning, picture(TEXEL))), expected, 1e-4)


@pytest.mark.parametrize("turn", [1.0, -1.0])
def test_an_instance_that_is_mirrored_mirrors_its_bumps(stage, turn):
    ball = with_tangents(sphere(0.7))
    place = np.diag([turn, 0.8, 1.2, 1.0])
    positions = np.float32(ball.positions_m * np.diag(place)[:3])
    normals = ball.normals / np.diag(place)[:3]
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    made = replace(
        ball,
        positions_m=positions,
        normals=np.float32(normals),
        tangents=None,
        triangles=np.ascontiguousarray(ball.triangles[:, :: int(turn)]),
    )
    found = stage.seen(lit(ball, noise(), place))
    expected = stage.seen(lit(with_tangents(made), noise()))
    is_other = np.abs(found - expected).max(axis=-1) > 0.02 * expected.max()
    assert is_other.mean() < 0.03  # tangents of stretched triangles weigh a little otherwise
    assert (np.abs(found - stage.seen(lit(ball, None, place))).max(axis=-1) > 0.05).mean() > 0.1


TURNED = np.array([[0.6, -0.7, 0.1, 0.2], [0.8, 0.6, 0.2, 0.1], [0.1, -0.3, 1.1, 0], [0, 0, 0, 1]])


@pytest.mark.parametrize("place", [moved(), TURNED])
def test_rays_and_triangles_see_the_same_bumps(stage, place):
    drawn, traced = stage.seen(lit(with_tangents(sphere(0.8)), noise(), place))
    same(drawn, traced, 1e-2)
    assert np.abs(np.diff(drawn, axis=1)).max() > 0.1


def test_a_thing_scaled_small_keeps_its_bumps(stage):
    sheet, normal = plane(7e4), tilted(TEXEL, 1.0, RIGHT, UP, OUT)
    scene = lit(with_tangents(sheet), picture(TEXEL), moved(scale=1e-5))
    same(stage.seen(scene), stage.seen(lit(bent(plane(0.7), normal))))


def test_a_back_side_bulges_where_the_front_is_hollow(stage):
    """Seen from behind the whole normal is turned, as section 3.7.2.1 has it of two sides."""
    sheet = plane(0.7)
    about = np.diag([-1.0, 1.0, -1.0, 1.0])
    normal = tilted(TEXEL, 1.0, RIGHT, UP, OUT) * (-1, 1, -1)
    expected = stage.seen(lit(bent(sheet, -normal)))
    same(stage.seen(lit(with_tangents(sheet), picture(TEXEL), about)), expected)


def test_a_flat_map_is_none_as_nearly_as_eight_bits_tell(stage):
    ball = with_tangents(sphere(0.8))
    found, expected = stage.seen(lit(ball, picture(FLAT))), stage.seen(lit(ball))
    same(found, expected, 2e-2)
    assert np.abs(found - expected).mean() < 2e-3 * expected.max()


def test_a_scale_of_nothing_is_no_map(stage):
    ball = with_tangents(sphere(0.8))
    same(stage.seen(lit(ball, noise(), normal_scale=0.0)), stage.seen(lit(ball)), 1e-4)


@pytest.mark.parametrize("kind", ["no uvs", "a line of uvs", "no tangents", "upright", "black"])
def test_where_a_map_has_no_direction_the_surface_keeps_its_own(stage, kind):
    ball = sphere(0.8)
    if kind != "no tangents":
        uvs = {"no uvs": 0 * ball.uvs, "a line of uvs": ball.uvs[:, :1] * np.float32([1, 2])}
        ball = with_tangents(replace(ball, uvs=uvs.get(kind, ball.uvs)))
    if kind == "upright":
        ones = np.ones((len(ball.normals), 1), np.float32)
        ball = replace(ball, tangents=np.concatenate([ball.normals, ones], axis=1))
    image = picture((128, 128, 0)) if kind == "black" else noise()
    scale = 0.0 if kind == "black" else 1.0
    same(stage.seen(lit(ball, image, normal_scale=scale)), stage.seen(lit(ball)), 1e-4)


def test_a_mesh_without_a_map_stays_what_it_is_beside_one_that_has_one(stage):
    left, right = moved(-0.8, scale=0.5), moved(0.8, scale=0.5)
    alone = scene_of([sphere(), sphere()], [(0, left), (1, right)], [CLAY])
    bumpy = replace(CLAY, normal_map=0)
    meshes = (with_tangents(replace(sphere(), material=1)), sphere())
    both = replace(alone, meshes=meshes, materials=(CLAY, bumpy), images=(noise(),))
    found, before = stage.seen(both), stage.seen(alone)
    np.testing.assert_allclose(found[:, :, 16:], before[:, :, 16:], atol=1e-5)
    assert np.abs(found[:, :, :16] - before[:, :, :16]).max() > 0.02


def test_a_scene_without_bumps_carries_none(ctx):
    plain, bumpy = still_life(), lit(with_tangents(plane()), noise())
    for scene, has_bumps in ((plain, False), (bumpy, True)):
        buffers = SceneBuffers(ctx, scene)
        count = sum(len(mesh.positions_m) for mesh in scene.meshes)
        assert buffers.vertices.size == count * (VERTEX.itemsize + 16 * has_bumps)
        assert ("BUMPS" in buffers.defines) == has_bumps
        buffers.release()


@pytest.mark.parametrize(("strength", "share"), [(0.0, 1.0), (0.5, 0.6), (1.0, 0.2)])
def test_occlusion_takes_of_the_sky_and_not_of_lamps(stage, strength, share):
    shaded = replace(CLAY, occlusion_map=0, occlusion=strength)
    told = {"images": (picture((51, 255, 255)),)}
    sky, lamp = {"daylight": even_sky()}, {"lights": (LAMP,), "daylight": NIGHT}
    for light, part in ((sky, share), (lamp, 1.0)):
        found = stage.seen(scene_of([plane(2.0)], materials=[shaded], **told, **light))
        same(found, part * stage.seen(scene_of([plane(2.0)], materials=[CLAY], **told, **light)))
