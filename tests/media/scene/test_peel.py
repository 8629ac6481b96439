"""What a scene has behind its picture, as fragment lists: small scenes whose lists are known."""

from collections.abc import Sequence
from dataclasses import replace
from itertools import cycle

import numpy as np
import pytest

from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.framing import CameraTrack, Framing, PoseKey, looking_at
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
from support.scenes import NIGHT, box, lamp, moved, plane, scene_of, sphere, still_life

SIZE = (48, 32)
RED, GREEN, BLUE = (0.5, 0.1, 0.1), (0.1, 0.5, 0.1), (0.1, 0.1, 0.5)
AHEAD = SceneCamera("ahead", CameraTrack((PoseKey(1, looking_at((0, 0, 0), (0, 0, -1))),)))
SHOT = Shot(
    Lens(50.0, 2.0, 3.0, 36.0),
    DefocusSettings(quality=Quality.PREVIEW),
    framing=Framing(*SIZE, camera="ahead"),
)
TURNED = np.diag([-1.0, 1.0, -1.0, 1.0])  # half a turn around y


def scene_with(meshes: Sequence[Mesh], places: Sequence[tuple[int, Array]]) -> Scene:
    materials = tuple(map(lamp, (RED, GREEN, BLUE)))
    return scene_of(meshes, places, materials, daylight=NIGHT, cameras=(AHEAD,))


def peeled(renderer: FrameRenderer, scene: Scene) -> tuple[Peeled, int]:
    """Return the lists, and the number of the pixel in the middle of the picture."""
    renderer.load_scene(scene)
    lists = renderer.look(SHOT).peeled
    assert lists is not None
    width, height = lists.fragments.size
    return lists, width * (height // 2) + width // 2


def list_at(lists: FragmentLists, pixel: int) -> list[tuple[tuple[float, ...], float, float]]:
    """Return colour, coverage and metres of each fragment."""
    first, end = lists.starts[pixel] >> 1, lists.starts[pixel + 1] >> 1
    with np.errstate(divide="ignore"):
        depth_m = 1 / lists.dioptres[first:end]
    rows = zip(lists.color[first:end], lists.coverage[first:end], depth_m, strict=True)
    return [(tuple(map(float, c)), float(a), float(m)) for c, a, m in rows]


def check_surface(fragment: tuple[tuple[float, ...], float, float], color, depth_m) -> None:
    assert fragment[0] == pytest.approx(color, abs=1e-3)
    assert fragment[1:] == (1.0, pytest.approx(depth_m, rel=1e-3))


def test_a_wall_behind_a_card_is_in_its_list_and_the_sky_behind_that(renderer):
    cards = plane(0.3), plane(3.0, material=1), plane(3.0, material=2)
    places = [(0, moved(z=-2)), (1, moved(z=-4)), (2, moved(z=-5))]
    found, middle = peeled(renderer, scene_with(cards, places))
    behind = list_at(found.read(), middle)
    assert len(behind) == 2  # two behind what is seen
    check_surface(behind[0], GREEN, 4.0)
    check_surface(behind[1], BLUE, 5.0)
    assert not found.read().starts[middle] & 1  # what is seen is in the picture
    beside = list_at(found.read(), middle - found.fragments.size[0] // 4)
    check_surface(beside[0], BLUE, 5.0)
    assert beside[1] == ((0.0, 0.0, 0.0), 1.0, np.inf)


@pytest.mark.parametrize("mesh", [box((0.3, 0.3, 0.3)), sphere(0.3)], ids=["box", "sphere"])
def test_the_inside_of_what_is_closed_does_not_count(renderer, mesh):
    places = [(0, moved(z=-2)), (1, moved(z=-4))]
    found, middle = peeled(renderer, scene_with((mesh, plane(3.0, material=1)), places))
    behind = list_at(found.read(), middle)
    check_surface(behind[0], GREEN, 4.0)
    assert behind[1][2] == np.inf


@pytest.mark.parametrize("turn", [np.eye(4), TURNED], ids=["front", "back"])
def test_an_open_card_counts_from_both_sides(renderer, turn):
    places = [(0, moved(z=-2)), (1, moved(z=-4) @ turn)]
    found, middle = peeled(renderer, scene_with((plane(0.3), plane(3.0, material=1)), places))
    check_surface(list_at(found.read(), middle)[0], GREEN, 4.0)


def test_lists_that_begin_with_what_is_seen_flatten_to_the_picture(renderer):
    # The card's edges run through pixels.
    places = [(0, moved(0.013, 0.011, z=-2)), (1, moved(z=-4))]
    found, _ = peeled(renderer, scene_with((plane(0.3), plane(3.0, material=1)), places))
    lists, overscan = found.read(), renderer.loaded.overscan
    assert overscan is not None
    color, depth_m = download(overscan.color), download(found.depth)
    edges = np.flatnonzero(lists.starts[:-1] & 1)
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


def test_bands_make_the_same_lists(renderer, monkeypatch):
    places = [(0, moved(0.1, 0.05, z=-2)), (1, moved(z=-4))]
    scene = scene_with((sphere(0.3), plane(3.0, material=1)), places)
    whole = peeled(renderer, scene)[0].read()
    monkeypatch.setattr(bands, "_SAMPLES_MOST", 5000)
    banded = peeled(renderer, scene)[0].read()
    np.testing.assert_array_equal(whole.starts, banded.starts)
    np.testing.assert_allclose(whole.dioptres, banded.dioptres, rtol=1e-4)
    np.testing.assert_allclose(whole.coverage, banded.coverage, atol=1e-3)


def test_a_scene_with_more_surfaces_gets_more_room(renderer, monkeypatch):
    places = [(0, moved(z=-2)), (1, moved(z=-4))]
    scene = scene_with((plane(2.0), plane(3.0, material=1)), places)
    expected = peeled(renderer, scene)[0].read()
    monkeypatch.setattr(peel, "_A_PIXEL", 0.5)
    found, _ = peeled(renderer, scene)
    assert found.count <= found.capacity and found.notes == ()
    np.testing.assert_array_equal(found.read().starts, expected.starts)
    np.testing.assert_array_equal(found.read().words, expected.words)


def test_lists_that_do_not_fit_are_left_out_whole_and_that_is_said(renderer, monkeypatch):
    monkeypatch.setattr(peel, "_FRAGMENTS_MOST", 2000)
    places = [(0, moved(z=-2)), (1, moved(z=-4))]
    found, _ = peeled(renderer, scene_with((plane(2.0), plane(3.0, material=1)), places))
    lists = found.read()
    assert found.count > found.capacity >= lists.count
    assert f"{found.count - 2000} of {found.count} were left out" in renderer.loaded.plate.notes[0]
    assert (lists.starts >> 1).max() == found.capacity
    assert (np.diff((lists.starts >> 1).astype(int)) >= 0).all()
    assert np.isfinite(renderer.pixels(SHOT)).all()


def test_bins_count_what_is_hidden(renderer):
    places = [(0, moved(z=-2)), (1, moved(z=-4))]
    # The card fills picture and overscan, so that nothing of the wall is seen.
    found, _ = peeled(renderer, scene_with((plane(3.0), plane(4.0, material=1)), places))
    occupied = found.bins.occupied
    assert np.abs(occupied - 1 / 4).min() < 1e-3
    assert np.abs(occupied - 1 / 2).min() < 1e-3
    assert occupied[0] == 0  # the sky behind the wall


def test_a_third_frame_takes_the_memory_of_the_first(renderer):
    places = [(0, moved(z=-2)), (1, moved(z=-4))]
    found, _ = peeled(renderer, scene_with((plane(0.3), plane(3.0, material=1)), places))
    first = found.fragments
    for focal_length_mm in (60.0, 70.0):  # two banks: one is held while the other is drawn
        lens = replace(SHOT.lens, focal_length_mm=focal_length_mm)
        again = renderer.look(replace(SHOT, lens=lens)).peeled
        assert again is not None and again is not found
    assert (again.fragments.starts, again.fragments.words) == (first.starts, first.words)


def test_what_is_known_is_nearer_to_the_truth_than_what_is_guessed(renderer, monkeypatch):
    """Bars, and on a wall behind each a stripe that only a wide lens sees."""
    bar, stripe = (
        replace(plane(0.5, material=m), positions_m=plane(0.5).positions_m * np.float32([w, 4, 1]))
        for m, w in ((0, 0.02), (2, 0.16))
    )
    aside_m = [0.08 * i - 0.2 for i in range(6)]
    places = [(0, moved(x, z=-0.4)) for x in aside_m] + [(1, moved(z=-4))]
    places += [(2, moved(10 * x * 0.99, z=-3.96)) for x in aside_m]
    renderer.load_scene(scene_with((bar, plane(3.0, material=1), stripe), places))
    film = replace(SHOT.defocus, quality=Quality.FILM)  # a preview guesses what is hidden
    shot = replace(SHOT, lens=replace(SHOT.lens, f_stop=1.0, focus_distance_m=4.0), defocus=film)
    many = replace(shot, defocus=replace(shot.defocus, method=Method.ACCUMULATION, views=128))
    truth = renderer.pixels(many)[..., :3]
    known = np.abs(renderer.pixels(shot)[..., :3] - truth).mean()
    monkeypatch.setattr(renderer, "_loaded", replace(renderer.loaded, peeled=None))
    monkeypatch.setattr(renderer, "looking", lambda *_: iter(()))
    guessed = np.abs(renderer.pixels(shot)[..., :3] - truth).mean()
    assert known < 0.7 * guessed


def test_meshes_without_a_rim_are_closed():
    assert is_closed(sphere(1.0, 1)) and is_closed(box())
    assert not is_closed(plane())
    open_sphere = replace(sphere(1.0, 1), triangles=sphere(1.0, 1).triangles[1:])
    assert not is_closed(open_sphere)
    assert not is_closed(replace(plane(), triangles=np.zeros((0, 3), np.uint32)))


def test_backs_are_told_by_the_order_of_corners_where_that_agrees_with_the_normals():
    ball = sphere(1.0, 1)
    turned = replace(ball, triangles=ball.triangles[:, ::-1])
    assert back_rule(ball) == BACK_COUNTERCLOCKWISE
    assert back_rule(turned) == BACK_CLOCKWISE
    assert back_rule(box()) == BACK_BY_NORMAL  # half of its faces are ordered the other way
    assert back_rule(plane()) == BACK_NONE


def test_a_mirrored_mesh_is_told_the_other_way_and_a_room_from_inside_not_at_all():
    ball = sphere(1.0, 1)
    closed = ClosedMeshes((ball,), np.array([ball.box_m]))
    mirror = np.diag([-1.0, 1.0, 1.0, 1.0])
    to_world = np.stack([moved(z=-3), moved(z=-3) @ mirror, moved(z=-0.5)])
    to_object = np.linalg.inv(to_world).transpose(0, 2, 1)
    rules = closed.rules(np.zeros(3, np.int64), to_world, to_object, np.zeros(3))
    assert rules.tolist() == [BACK_COUNTERCLOCKWISE, BACK_CLOCKWISE, BACK_NONE]


def test_as_many_steps_are_taken_as_are_told(renderer):
    places = [(0, moved(z=-2)), (1, moved(z=-4))]
    renderer.load_scene(scene_with((sphere(0.3), plane(3.0, material=1)), places))
    told = drawing_steps(renderer.ctx, renderer.scene.triangle_count, SIZE)
    assert len(list(renderer.looking(SHOT, 0))) == told


def in_steps(renderer: FrameRenderer, shares: Sequence[float]) -> list[np.ndarray]:
    """Return what a look at the still life finds, drawn in steps of these shares in turn."""
    renderer.load_scene(still_life())
    shot = replace(SHOT, framing=Framing(320, 200, camera="camera"))
    turns = cycle(shares)
    for _ in renderer.looking(shot, 0):
        renderer.pace(next(turns))
    seen = renderer.loaded
    assert seen.peeled is not None and seen.overscan is not None
    lists, shown = seen.peeled.read(), (seen.overscan.color, seen.overscan.depth)
    pictures = (*shown, seen.color, seen.depth, seen.peeled.depth, seen.peeled.places)
    return [lists.starts, lists.words, *map(download, pictures)]


def test_how_fast_the_machine_draws_makes_no_difference(renderer):
    """A busy machine draws in shorter steps; its picture has the same bits."""
    at_once = in_steps(renderer, [1.0])
    for shares in ([1 / 16], [1.0, 1 / 4, 1 / 16, 1 / 2]):
        for found, expected in zip(in_steps(renderer, shares), at_once, strict=True):
            np.testing.assert_array_equal(found, expected)
