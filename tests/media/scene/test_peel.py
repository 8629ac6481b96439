"""Test the fragment lists behind the image of a scene, for small scenes of known lists."""

from collections.abc import Sequence
from dataclasses import replace
from itertools import cycle

import numpy as np
import pytest

from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.camera_track import CameraTrack, PoseKey, pose_looking_at
from heatlens.core.model.shot.framing import Framing
from heatlens.core.model.shot.settings import DefocusSettings, Method, Quality
from heatlens.core.model.shot.shot import Shot
from heatlens.media.plate.fragments import FragmentLists
from heatlens.media.scene.scene import Array, Mesh, Scene, SceneCamera
from heatlens.render.frame_renderer import FrameRenderer
from heatlens.render.gpu.textures import download
from heatlens.render.scene_gpu import bands, peel
from heatlens.render.scene_gpu.closed_meshes import (
    BACK_BY_NORMAL,
    BACK_CLOCKWISE,
    BACK_COUNTERCLOCKWISE,
    BACK_NONE,
    ClosedMeshes,
    back_rule,
    is_closed,
)
from heatlens.render.scene_gpu.peel import Peeled
from heatlens.render.scene_gpu.pinhole_draw import drawing_steps
from support.scenes import NIGHT, box, lamp, placement, plane, scene_of, sphere, still_life

SIZE = (48, 32)
RED, GREEN, BLUE = (0.5, 0.1, 0.1), (0.1, 0.5, 0.1), (0.1, 0.1, 0.5)
AHEAD = SceneCamera("ahead", CameraTrack((PoseKey(1, pose_looking_at((0, 0, 0), (0, 0, -1))),)))
SHOT = Shot(
    Lens(50.0, 2.0, 3.0, 36.0),
    DefocusSettings(quality=Quality.PREVIEW),
    framing=Framing(*SIZE, camera="ahead"),
)
TURNED = np.diag([-1.0, 1.0, -1.0, 1.0])  # half a turn around y


def scene_with(meshes: Sequence[Mesh], places: Sequence[tuple[int, Array]]) -> Scene:
    materials = tuple(map(lamp, (RED, GREEN, BLUE)))
    return scene_of(meshes, places, materials, daylight=NIGHT, cameras=(AHEAD,))


def peel_scene(renderer: FrameRenderer, scene: Scene) -> tuple[Peeled, int]:
    """Return the lists, and the index of the pixel in the middle of the image."""
    renderer.load_scene(scene)
    lists = renderer.load_pinhole(SHOT).peeled
    assert lists is not None
    width, height = lists.fragments.size
    return lists, width * (height // 2) + width // 2


def list_at(lists: FragmentLists, pixel: int) -> list[tuple[tuple[float, ...], float, float]]:
    """Return colour, coverage and metres of each fragment."""
    first, end = lists.begins[pixel : pixel + 2]
    with np.errstate(divide="ignore"):
        depth_m = 1 / lists.dioptres[first:end]
    rows = zip(lists.color[first:end], lists.coverage[first:end], depth_m, strict=True)
    return [(tuple(map(float, c)), float(a), float(m)) for c, a, m in rows]


def check_surface(fragment: tuple[tuple[float, ...], float, float], color, depth_m) -> None:
    assert fragment[0] == pytest.approx(color, abs=1e-3)
    assert fragment[1:] == (1.0, pytest.approx(depth_m, rel=1e-3))


def test_peeled_list_has_wall_behind_card_and_then_sky(renderer):
    cards = plane(0.3), plane(3.0, material=1), plane(3.0, material=2)
    places = [(0, placement(z=-2)), (1, placement(z=-4)), (2, placement(z=-5))]
    peeled_lists, middle = peel_scene(renderer, scene_with(cards, places))
    behind = list_at(peeled_lists.read(), middle)
    assert len(behind) == 2  # two behind what is seen
    check_surface(behind[0], GREEN, 4.0)
    check_surface(behind[1], BLUE, 5.0)
    assert not peeled_lists.read().has_front[middle]  # what is seen is in the picture
    list_beside = list_at(peeled_lists.read(), middle - peeled_lists.fragments.size[0] // 4)
    check_surface(list_beside[0], BLUE, 5.0)
    assert list_beside[1] == ((0.0, 0.0, 0.0), 1.0, np.inf)


@pytest.mark.parametrize("mesh", [box((0.3, 0.3, 0.3)), sphere(0.3)], ids=["box", "sphere"])
def test_peeled_list_omits_inside_of_closed_mesh(renderer, mesh):
    places = [(0, placement(z=-2)), (1, placement(z=-4))]
    peeled_lists, middle = peel_scene(renderer, scene_with((mesh, plane(3.0, material=1)), places))
    behind = list_at(peeled_lists.read(), middle)
    check_surface(behind[0], GREEN, 4.0)
    assert behind[1][2] == np.inf


@pytest.mark.parametrize("turn", [np.eye(4), TURNED], ids=["front", "back"])
def test_peeled_list_has_open_card_from_both_sides(renderer, turn):
    places = [(0, placement(z=-2)), (1, placement(z=-4) @ turn)]
    peeled_lists, middle = peel_scene(
        renderer, scene_with((plane(0.3), plane(3.0, material=1)), places)
    )
    check_surface(list_at(peeled_lists.read(), middle)[0], GREEN, 4.0)


def test_peeled_lists_with_front_flatten_to_image(renderer):
    # The card's edges run through pixels.
    places = [(0, placement(0.013, 0.011, z=-2)), (1, placement(z=-4))]
    peeled_lists, _ = peel_scene(renderer, scene_with((plane(0.3), plane(3.0, material=1)), places))
    lists, overscan = peeled_lists.read(), renderer.loaded.overscan
    assert overscan is not None
    color, depth_m = download(overscan.color), download(peeled_lists.depth)
    edges = np.flatnonzero(lists.has_front)
    assert len(edges) > 20
    for pixel in edges:
        shown, left = np.zeros(3), 1.0
        for light, cover, _ in (fragments := list_at(lists, int(pixel))):
            shown += left * cover * np.array(light)
            left *= 1 - cover
        assert left == 0
        np.testing.assert_allclose(shown, color[..., :3].reshape(-1, 3)[pixel], rtol=0.02)
        assert depth_m.ravel()[pixel] == pytest.approx(fragments[0][2], rel=1e-3)
        assert fragments[0][2] == pytest.approx(2.0, rel=1e-2)


def test_peeled_lists_drawn_in_bands_are_the_same(renderer, monkeypatch):
    places = [(0, placement(0.1, 0.05, z=-2)), (1, placement(z=-4))]
    scene = scene_with((sphere(0.3), plane(3.0, material=1)), places)
    whole = peel_scene(renderer, scene)[0].read()
    monkeypatch.setattr(bands, "_SAMPLES_MOST", 5000)
    banded = peel_scene(renderer, scene)[0].read()
    np.testing.assert_array_equal(whole.starts, banded.starts)
    np.testing.assert_allclose(whole.dioptres, banded.dioptres, rtol=1e-4)
    np.testing.assert_allclose(whole.coverage, banded.coverage, atol=1e-3)


def test_peeled_lists_grow_for_scene_with_more_surfaces(renderer, monkeypatch):
    places = [(0, placement(z=-2)), (1, placement(z=-4))]
    scene = scene_with((plane(2.0), plane(3.0, material=1)), places)
    expected = peel_scene(renderer, scene)[0].read()
    monkeypatch.setattr(peel, "_FRAGMENTS_PER_PIXEL", 0.5)
    peeled_lists, _ = peel_scene(renderer, scene)
    assert peeled_lists.count <= peeled_lists.capacity and peeled_lists.notes == ()
    np.testing.assert_array_equal(peeled_lists.read().starts, expected.starts)
    np.testing.assert_array_equal(peeled_lists.read().words, expected.words)


def test_peeled_lists_beyond_limit_are_left_out_with_a_note(renderer, monkeypatch):
    monkeypatch.setattr(peel, "_FRAGMENTS_MOST", 2000)
    places = [(0, placement(z=-2)), (1, placement(z=-4))]
    peeled_lists, _ = peel_scene(renderer, scene_with((plane(2.0), plane(3.0, material=1)), places))
    lists = peeled_lists.read()
    assert peeled_lists.count > peeled_lists.capacity >= lists.count
    assert (
        f"{peeled_lists.count - 2000} of {peeled_lists.count} were left out"
        in renderer.loaded.plate.notes[0]
    )
    assert lists.begins.max() == peeled_lists.capacity
    assert (np.diff(lists.begins) >= 0).all()
    assert np.isfinite(renderer.pixels(SHOT)).all()


def test_peeled_list_that_is_cut_covers_nothing_and_leaves_the_depth(renderer, monkeypatch):
    scene = scene_with(
        (plane(0.3), plane(3.0, material=1)),
        [(0, placement(0.013, 0.011, z=-2)), (1, placement(z=-4))],
    )
    lists = peel_scene(renderer, scene)[0].read()
    begins, front = lists.begins, lists.has_front
    # there is memory for only the first fragment of this list
    cut = int(np.flatnonzero(front & (np.diff(begins) > 1))[5])
    monkeypatch.setattr(peel, "_FRAGMENTS_MOST", int(begins[cut]) + 1)
    peeled_lists = peel_scene(renderer, scene)[0]
    few = peeled_lists.read()
    np.testing.assert_array_equal(few.words[:-1], lists.words[: begins[cut]])
    assert few.words[-1, 1] >> 16 == 0 and not few.has_front[cut:].any()
    depth_m, picture_m = download(peeled_lists.depth), download(renderer.loaded.overscan.depth)
    np.testing.assert_array_equal(depth_m.ravel()[cut:], picture_m.ravel()[cut:])


def test_peeled_bins_count_hidden_surfaces(renderer):
    places = [(0, placement(z=-2)), (1, placement(z=-4))]
    # The card fills picture and overscan, so that nothing of the wall is seen.
    peeled_lists, _ = peel_scene(renderer, scene_with((plane(3.0), plane(4.0, material=1)), places))
    occupied = peeled_lists.bins.occupied
    assert np.abs(occupied - 1 / 4).min() < 1e-3
    assert np.abs(occupied - 1 / 2).min() < 1e-3
    assert occupied[0] == 0  # the sky behind the wall


def test_peeled_lists_reuse_memory_from_third_frame_on(renderer):
    places = [(0, placement(z=-2)), (1, placement(z=-4))]
    peeled_lists, _ = peel_scene(renderer, scene_with((plane(0.3), plane(3.0, material=1)), places))
    first = peeled_lists.fragments
    for focal_length_mm in (60.0, 70.0):  # two banks: one is held while the other is drawn
        lens = replace(SHOT.lens, focal_length_mm=focal_length_mm)
        next_lists = renderer.load_pinhole(replace(SHOT, lens=lens)).peeled
        assert next_lists is not None and next_lists is not peeled_lists
    assert (next_lists.fragments.starts, next_lists.fragments.words) == (first.starts, first.words)


def test_peeled_lists_give_better_image_than_guesses(renderer, monkeypatch):
    """Each bar hides a stripe on the wall that only a wide lens sees."""
    bar, stripe = (
        replace(plane(0.5, material=m), positions_m=plane(0.5).positions_m * np.float32([w, 4, 1]))
        for m, w in ((0, 0.02), (2, 0.16))
    )
    aside_m = [0.08 * i - 0.2 for i in range(6)]
    places = [(0, placement(x, z=-0.4)) for x in aside_m] + [(1, placement(z=-4))]
    places += [(2, placement(10 * x * 0.99, z=-3.96)) for x in aside_m]
    renderer.load_scene(scene_with((bar, plane(3.0, material=1), stripe), places))
    film = replace(SHOT.defocus, quality=Quality.FILM)  # a preview guesses what is hidden
    shot = replace(SHOT, lens=replace(SHOT.lens, f_stop=1.0, focus_distance_m=4.0), defocus=film)
    many = replace(shot, defocus=replace(shot.defocus, method=Method.ACCUMULATION, views=128))
    truth = renderer.pixels(many)[..., :3]
    error_with_lists = np.abs(renderer.pixels(shot)[..., :3] - truth).mean()
    monkeypatch.setattr(renderer, "_loaded", replace(renderer.loaded, peeled=None))
    monkeypatch.setattr(renderer, "load_pinhole_steps", lambda *_: iter(()))
    error_of_guess = np.abs(renderer.pixels(shot)[..., :3] - truth).mean()
    assert error_with_lists < 0.7 * error_of_guess


def test_is_closed_of_meshes_without_boundary():
    assert is_closed(sphere(1.0, 1)) and is_closed(box())
    assert not is_closed(plane())
    open_sphere = replace(sphere(1.0, 1), triangles=sphere(1.0, 1).triangles[1:])
    assert not is_closed(open_sphere)
    assert not is_closed(replace(plane(), triangles=np.zeros((0, 3), np.uint32)))


def test_back_rule_follows_corner_order_that_agrees_with_normals():
    ball = sphere(1.0, 1)
    reversed_ball = replace(ball, triangles=ball.triangles[:, ::-1])
    assert back_rule(ball) == BACK_COUNTERCLOCKWISE
    assert back_rule(reversed_ball) == BACK_CLOCKWISE
    assert back_rule(box()) == BACK_BY_NORMAL  # half of its faces are ordered the other way
    assert back_rule(plane()) == BACK_NONE


def test_closed_meshes_rules_flip_for_mirror_and_end_inside():
    ball = sphere(1.0, 1)
    closed = ClosedMeshes((ball,), np.array([ball.box_m]))
    mirror = np.diag([-1.0, 1.0, 1.0, 1.0])
    to_world = np.stack([placement(z=-3), placement(z=-3) @ mirror, placement(z=-0.5)])
    to_object = np.linalg.inv(to_world).transpose(0, 2, 1)
    rules = closed.rules(np.zeros(3, np.int64), to_world, to_object, np.zeros(3))
    assert rules.tolist() == [BACK_COUNTERCLOCKWISE, BACK_CLOCKWISE, BACK_NONE]


def test_drawing_takes_as_many_steps_as_announced(renderer):
    places = [(0, placement(z=-2)), (1, placement(z=-4))]
    renderer.load_scene(scene_with((sphere(0.3), plane(3.0, material=1)), places))
    step_count = drawing_steps(renderer.ctx, renderer.scene.triangle_count, SIZE)
    assert len(list(renderer.load_pinhole_steps(SHOT, 0))) == step_count


def draw_in_steps(renderer: FrameRenderer, shares: Sequence[float]) -> list[np.ndarray]:
    """Return the results of drawing the still life in steps of these shares in turn."""
    renderer.load_scene(still_life())
    shot = replace(SHOT, framing=Framing(320, 200, camera="camera"))
    turns = cycle(shares)
    for _ in renderer.load_pinhole_steps(shot, 0):
        renderer.set_step_size(next(turns))
    loaded = renderer.loaded
    assert loaded.peeled is not None and loaded.overscan is not None
    lists, shown = loaded.peeled.read(), (loaded.overscan.color, loaded.overscan.depth)
    pictures = (*shown, loaded.color, loaded.depth, loaded.peeled.depth, loaded.peeled.positions)
    return [lists.starts, lists.words, *map(download, pictures)]


def test_result_does_not_depend_on_drawing_speed(renderer):
    """A busy machine draws in shorter steps, and its image has the same bits."""
    at_once = draw_in_steps(renderer, [1.0])
    for shares in ([1 / 16], [1.0, 1 / 4, 1 / 16, 1 / 2]):
        for found, expected in zip(draw_in_steps(renderer, shares), at_once, strict=True):
            np.testing.assert_array_equal(found, expected)
