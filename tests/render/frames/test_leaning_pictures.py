"""Pictures with tilted focus planes or split diopters: sharpness, disc sizes, and ray tracing."""

from dataclasses import replace

import numpy as np
import pytest

from heatlens.core.base.errors import InputError
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.framing import Framing
from heatlens.core.model.shot.lens_parameter import LensParameter
from heatlens.core.model.shot.settings import DefocusSettings, Method, Quality
from heatlens.core.model.shot.shot import Shot
from heatlens.media.plate.behind import with_behind
from heatlens.media.plate.coc_line import focus_offset_in, focused_at_pixel, line_of
from heatlens.render.defocus.focus_offset_survey import FocusOffsetSurvey
from heatlens.render.source.plate_on_gpu import PlateOnGpu
from support.plates import plate_of, room
from support.scenes import still_life

LENS = Lens(50.0, 1.4, 2.0, 36.0)
LEANS = [
    {"tilt_deg": 6.0},
    {"tilt_deg": -4.0, "tilt_direction_deg": 60.0},
    {"tilt_deg": 3.0, "tilt_direction_deg": -20.0, "split_dioptres": 0.2},
]
METHODS = (Method.DIFFUSION, Method.HEAT, Method.GATHER, Method.SCATTER, Method.PYRAMID)


def focus_distances_m(lens: Lens, width: int, height: int) -> np.ndarray:
    """Return the distances (H, W) at which each pixel is sharp."""
    level = plate_of(np.zeros((height, width, 3), np.float32), np.ones((height, width)))
    y, x = np.mgrid[:height, :width] + 0.5
    return 1 / (1 / lens.focus_distance_m + focus_offset_in(level, lens).dioptres_at(x, y))


@pytest.mark.parametrize("method", METHODS, ids=str)
@pytest.mark.parametrize("focus_offset", LEANS)
def test_surface_in_tilted_focus_plane_is_unchanged(ctx, renderer, rng, method, focus_offset):
    lens = replace(LENS, focus_distance_m=1.5, **focus_offset)
    depth = focus_distances_m(lens, 64, 40)
    assert depth.min() > 0.5 and depth.max() > 1.5 * depth.min()
    color = rng.random((40, 64, 3), np.float32)
    renderer.load(plate_of(color, depth))
    shot = Shot(lens, DefocusSettings(method=method, quality=Quality.FILM))
    np.testing.assert_allclose(renderer.pixels(shot)[..., :3], color, atol=2e-3)
    level = renderer.pixels(replace(shot, lens=replace(LENS, focus_distance_m=1.5)))
    assert np.abs(level[..., :3] - color).max() > 0.03


@pytest.mark.parametrize("focus_offset", LEANS)
def test_hidden_surfaces_do_not_show_in_tilted_focus_plane(ctx, renderer, focus_offset):
    lens = replace(LENS, focus_distance_m=1.5, **focus_offset)
    color, _ = room(64, 40)
    depth = focus_distances_m(lens, 64, 40).astype(np.float32)
    plate = plate_of(color, depth)
    behind = plate_of(np.ones_like(color), 3 * depth)
    renderer.load(with_behind(plate, [behind]))
    shot = Shot(lens, DefocusSettings(quality=Quality.FILM))
    np.testing.assert_allclose(renderer.pixels(shot)[..., :3], color, atol=2e-3)


@pytest.mark.parametrize("method", [Method.DIFFUSION, Method.GATHER, Method.SCATTER], ids=str)
@pytest.mark.parametrize("at", [(30, 30), (98, 40), (64, 100)])
def test_lamp_disc_has_coc_of_tilted_focus_at_its_pixel(ctx, renderer, method, at):
    lens = Lens(50.0, 0.5, 3.0, 36.0, tilt_deg=5.0, tilt_direction_deg=25.0)
    color = np.full((129, 129, 3), 2.0**-7, np.float32)
    color[at[1], at[0]] = 300.0
    plate = plate_of(color, np.full((129, 129), 1.2, np.float32))
    renderer.load(plate)
    picture = renderer.pixels(Shot(lens, DefocusSettings(method=method, quality=Quality.FILM)))
    light = picture[..., 1].astype(np.float64) - 2.0**-7
    y, x = np.mgrid[:129, :129]
    variance = (light * ((x - at[0]) ** 2 + (y - at[1]) ** 2)).sum() / light.sum()
    line = line_of(plate, lens)
    nearer = line.focus_offset.dioptres_at(at[0] + 0.5, at[1] + 0.5)
    diameter = line.at_infinity_px + line.per_dioptre_px * (1 / 1.2 - nearer)
    assert diameter < -3.0
    assert np.sqrt(8 * variance) == pytest.approx(-diameter, rel=0.06, abs=0.6)


@pytest.mark.parametrize("lens", [LENS, replace(LENS, split_dioptres=0.0, tilt_direction_deg=70.0)])
def test_lens_without_tilt_or_split_gives_level_picture(ctx, renderer, lens):
    renderer.load(plate_of(*room()))
    level = renderer.pixels(Shot(LENS))
    for focus_offset in (
        {},
        {"split_position": 0.4, "split_softness": 0.5},
        {"tilt_direction_deg": 90.0},
    ):
        assert np.array_equal(renderer.pixels(Shot(replace(lens, **focus_offset))), level)


def test_the_bins_are_those_of_every_surface_less_the_focus_offset(ctx):
    color, depth = room(48, 32)
    plate = with_behind(plate_of(color, depth), [plate_of(color, np.full_like(depth, 40.0))])
    lens = replace(LENS, tilt_deg=7.0, tilt_direction_deg=40.0, split_dioptres=1.0)
    focus_offset, on_gpu = focus_offset_in(plate, lens), PlateOnGpu(ctx)
    lists = plate.fragments
    for _ in on_gpu.load_steps(plate):
        pass
    plate_before = on_gpu.loaded
    found = FocusOffsetSurvey(ctx).bins(
        plate_before.depth, plate_before.fragments, plate_before.bins, focus_offset
    )
    y, x = np.mgrid[:32, :48] + 0.5
    nearer = focus_offset.dioptres_at(x, y)
    counts = np.diff(lists.begins)
    all_ = np.concatenate(
        [(1 / plate.depth_m - nearer).ravel(), lists.dioptres - np.repeat(nearer, counts)]
    )
    on_gpu.release()
    assert found.counts.sum() == len(all_) > depth.size
    step = (found.high - found.low) / len(found.counts)
    np.testing.assert_allclose(np.repeat(found.middles, found.counts), np.sort(all_), atol=step)


def render_still_life(renderer, lens: Lens, method: Method) -> np.ndarray:
    renderer.load_scene(still_life())
    settings = DefocusSettings(method=method, quality=Quality.FILM, views=256)
    shot = Shot(lens, settings, framing=Framing(width_px=96, height_px=64))
    return renderer.pixels(shot)[..., :3]


SCENE_LENS = Lens(50.0, 1.4, 3.0, 36.0)


@pytest.fixture(scope="module")
def level(renderer) -> np.ndarray:
    """Return the ray-traced scene through a lens without tilt."""
    return render_still_life(renderer, SCENE_LENS, Method.RAYTRACED)


@pytest.mark.parametrize(
    "focus_offset",
    [
        {"tilt_deg": 8.0, "tilt_direction_deg": -35.0},
        {"split_dioptres": 0.3, "split_softness": 0.1},
    ],
)
def test_tilted_scene_blur_is_near_ray_traced_one(ctx, renderer, level, focus_offset):
    """Check that the error to ray tracing is far below the change that the tilt itself makes."""
    leaning = replace(SCENE_LENS, **focus_offset)
    truth = render_still_life(renderer, leaning, Method.RAYTRACED)
    error = np.abs(render_still_life(renderer, leaning, Method.DIFFUSION) - truth).mean()
    assert error < 0.5 * np.abs(level - truth).mean()
    if "split_dioptres" in focus_offset:
        with pytest.raises(InputError, match="no split diopter: use raytraced"):
            render_still_life(renderer, leaning, Method.ACCUMULATION)
    else:
        error = np.abs(render_still_life(renderer, leaning, Method.ACCUMULATION) - truth).mean()
        assert error < 0.25 * np.abs(level - truth).mean()  # noise, which falls with more views


def test_accumulation_refuses_split_diopter_from_a_key(renderer):
    """Check that `render` uses the lens at the frame, whose split comes from a key."""
    renderer.load_scene(still_life())
    settings = DefocusSettings(method=Method.ACCUMULATION, views=2)
    shot = Shot(SCENE_LENS, settings, framing=Framing(width_px=32, height_px=24))
    shot = shot.with_key(1, LensParameter.SPLIT, 0.0).with_key(9, LensParameter.SPLIT, 0.4)
    renderer.render(shot, 1)
    with pytest.raises(InputError, match="no split diopter: use raytraced"):
        renderer.render(shot, 9)


@pytest.mark.parametrize("focus_offset", LEANS)
def test_focused_at_pixel_makes_pixel_sharp_with_tilt(focus_offset):
    lens, depth = replace(LENS, **focus_offset), np.full((40, 64), 1.4, np.float32)
    plate = plate_of(np.zeros((40, 64, 3), np.float32), depth)
    for x, y in ((3, 4), (60, 20), (32, 38)):
        clicked = focused_at_pixel(plate, lens, x, y)
        assert focus_distances_m(clicked, 64, 40)[y, x] == pytest.approx(1.4, rel=1e-6)
        assert focused_at_pixel(plate, LENS, x, y).focus_distance_m == pytest.approx(1.4)
