"""Previews on the screen: what is in focus has the detail of the plate at every preview size."""

from dataclasses import replace

import numpy as np
import pytest

from heatlens.core.model.boxes import Box
from heatlens.core.model.shot.settings import DefocusSettings
from heatlens.core.model.shot.shot import Shot
from heatlens.core.model.view.view import ViewState
from heatlens.render.display.picture_pass import PicturePass, PlacedPicture
from heatlens.render.display.screen_pictures import ScreenPictures
from heatlens.render.frame_renderer import run_all_steps
from heatlens.render.gpu.program import programs_built
from heatlens.render.gpu.resources import Sampling
from heatlens.render.preview.level_choice import cheaper_levels
from heatlens.render.preview.shown import ShownPicture
from support.plates import FAR_M, lens_blurring, plate_of

SIZE = (192, 128)


def screen_pixels(ctx, texture, detail) -> np.ndarray:
    """Return the screen, (H, W, 3) bytes, with a picture over all of it."""
    out = ctx.texture(SIZE, 4)
    target = ctx.framebuffer([out])
    texture.sampling = Sampling.LINEAR
    place = PlacedPicture(
        texture, (0.0, 0.0), (192.0, 128.0), Box(0, 0, *SIZE), detail is None, True, detail
    )
    PicturePass(ctx).run([place], target, SIZE)
    return np.frombuffer(target.read(components=3), np.uint8).reshape(*SIZE[::-1], 3).astype(int)


def preview_on_screen(
    ctx, renderer, shot, view, enlarges=True
) -> tuple[np.ndarray, ScreenPictures]:
    """Return the coarsest preview of a shot of the loaded plate as on the screen."""
    screen, level = ScreenPictures(ctx), cheaper_levels(DefocusSettings())[-1]
    picture = run_all_steps(renderer.steps(replace(shot, defocus=level), enlarges=enlarges))
    shown = ShownPicture(picture, shot, 0, level, 0.0, diffused=renderer.light_without_highlights())
    for _ in range(5):  # a plate that is new has no detail yet, nor has a slow first use
        detail = screen.detail(shown, renderer.loaded, view)
    preview = screen.a(shown, 0, renderer.loaded, view, renderer.loaded.color)
    assert detail is not None and detail.coarse.size == preview.size == picture.size
    return screen_pixels(ctx, preview, detail), screen


@pytest.mark.parametrize("enlarges", [False, True])
def test_preview_of_a_plate_in_focus_shows_the_plate(ctx, renderer, rng, enlarges):
    color = rng.uniform(0.1, 0.9, (*SIZE[::-1], 3)).astype(np.float32)
    renderer.load(plate_of(color, np.full(SIZE[::-1], FAR_M, np.float32)))
    lens = replace(lens_blurring(1.0, SIZE[0]), focus_distance_m=FAR_M, f_stop=64.0)
    view = ViewState()
    preview, screen = preview_on_screen(ctx, renderer, Shot(lens), view, enlarges)
    plate = screen_pixels(ctx, screen.b(renderer.loaded.color, renderer.loaded, view), None)
    assert np.abs(preview - plate).mean() < 1.0


@pytest.mark.parametrize("light_stops", [0, 12])
def test_preview_of_a_lamp_near_the_focus_has_no_ring(ctx, renderer, light_stops):
    """Check that the wall beside the lamp's disc has its own light, in bright plates too."""
    color = np.full((*SIZE[::-1], 3), 0.2 * 2.0**light_stops, np.float32)
    color[60:64, 90:94] *= 1000.0
    renderer.load(plate_of(color, np.full(SIZE[::-1], FAR_M, np.float32)))
    view = ViewState(exposure_stops=-float(light_stops))
    preview = preview_on_screen(ctx, renderer, Shot(lens_blurring(4.0, SIZE[0])), view)[0]
    y, x = np.mgrid[: SIZE[1], : SIZE[0]]
    from_lamp_px = np.hypot(y - 65.5, x - 91.5)  # rows run up
    wall, error = preview[0, 0], np.abs(preview - preview[0, 0])
    assert np.all(preview[from_lamp_px < 2.0] > 240) and np.all(wall < 130)
    assert error[from_lamp_px > 8.0].max() <= 12  # a preview's pixel; a ring had 23


def test_first_preview_builds_no_program_that_was_prepared(ctx, renderer):
    grey = np.full((*SIZE[::-1], 3), 0.5, np.float32)
    renderer.load(plate_of(grey, grey[..., 0]))
    shot, level = Shot(lens_blurring(1.0, SIZE[0])), cheaper_levels(DefocusSettings())[-1]
    picture, screen = ctx.texture((24, 16), 4, dtype="f4"), ScreenPictures(ctx)
    screen.prepare()
    while screen.take_request():
        screen.prepare()
    count = programs_built()
    shown = ShownPicture(picture, shot, 0, level, 0.0)
    screen.a(shown, 0, renderer.loaded, ViewState(), renderer.loaded.color)
    assert count > 0 and programs_built() == count
