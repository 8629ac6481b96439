"""The whole picture of the window is the renderer's, bit for bit, however it came about."""

from dataclasses import replace

import numpy as np
import pytest

from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.settings import Bokeh, DefocusSettings, Method, Quality
from heatlens.core.model.shot.shot import Shot
from heatlens.core.model.view.view import Against, Compare, ViewState
from heatlens.render.frame_renderer import FrameRenderer
from heatlens.render.gpu.textures import download
from heatlens.studio.session.pictures.compare_sides import CompareSides
from heatlens.studio.session.pictures.live_picture import LivePicture
from support.plates import plate_of, room

LENS = Lens(50.0, 2.0, 2.0, 36.0)


@pytest.fixture(scope="module")
def loaded(session_context, renderer) -> FrameRenderer:
    renderer.load(plate_of(*room()))
    return renderer


@pytest.mark.parametrize(
    "defocus",
    [
        DefocusSettings(),
        DefocusSettings(Bokeh.GAUSSIAN, Quality.PREVIEW, layers=2),
        DefocusSettings(Bokeh.HEAT, Quality.DRAFT, layers=1),
        DefocusSettings(Bokeh.DISC, Quality.DRAFT, proxy=0.5),
    ],
    ids=lambda d: f"{d.bokeh} {d.quality}",
)
def test_the_whole_picture_is_the_renderers_bit_for_bit(ctx, loaded, defocus):
    """In short slices, after a drag, and beside the picture of another slot."""
    live = LivePicture(loaded)
    for focus_m in (1.0, 1.5, 2.5):
        shot = Shot(replace(LENS, f_stop=0.5, focus_distance_m=focus_m), defocus)
        live.request(shot, 0, 1e-4)
        quick = live.shown
        np.testing.assert_array_equal(
            download(quick.texture), loaded.pixels(replace(shot, defocus=quick.settings))
        )
        live.request(shot, 0, 1e-4)
    while live.is_working:
        live.work(1e-4)
    assert live.shown.settings == defocus
    np.testing.assert_array_equal(download(live.shown.texture), loaded.pixels(shot))


def test_answers_in_slices_of_one_step_are_the_renderers_bit_for_bit(ctx, loaded):
    """Also those of a drag, each of which comes late, and beside which B waits for its turn."""
    sides, seen = CompareSides(loaded), []
    view = ViewState(compare=Compare.WIPE, against=Against.METHOD, b_method=Method.GATHER)
    shots = [Shot(replace(LENS, focus_distance_m=1.0 + 0.01 * at)) for at in range(400)]
    for shot in shots:
        sides.request(view, shot, 0, 1e-4, within_s=1e-4)
        assert sides.a.is_answering or sides.b.is_working
        if sides.a.shown is not None and sides.a.shown.shot not in seen:
            seen.append(sides.a.shown.shot)
            quick = replace(seen[-1], defocus=sides.a.shown.settings)
            np.testing.assert_array_equal(download(sides.a.shown.texture), loaded.pixels(quick))
    assert seen and len(seen) < len(shots)
    while any(side.is_working for side in sides.rendered):
        sides.work(0, 1e-4)
        sides.request(view, shot, 0, 1e-4, within_s=1e-4)
        sides.work(1, 1e-4)
    np.testing.assert_array_equal(download(sides.a.shown.texture), loaded.pixels(shot))
    other = replace(shot, defocus=replace(shot.defocus, method=Method.GATHER))
    np.testing.assert_array_equal(download(sides.b.shown.texture), loaded.pixels(other))
