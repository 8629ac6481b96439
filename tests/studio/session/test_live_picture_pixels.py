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
def test_whole_live_picture_equals_the_renderers_bit_for_bit(ctx, loaded, defocus):
    """The picture is rendered in short slices, after a drag, beside that of the other slot."""
    live = LivePicture(loaded)
    for focus_m in (1.0, 1.5, 2.5):
        shot = Shot(replace(LENS, f_stop=0.5, focus_distance_m=focus_m), defocus)
        live.request(shot, 0, 1e-4)
        quick = live.output
        np.testing.assert_array_equal(
            download(quick.texture), loaded.pixels(replace(shot, defocus=quick.settings))
        )
        live.request(shot, 0, 1e-4)
    while live.is_working:
        live.work(1e-4)
    assert live.output.settings == defocus
    np.testing.assert_array_equal(download(live.output.texture), loaded.pixels(shot))


def test_answers_in_one_step_slices_equal_the_renderers_bit_for_bit(ctx, loaded):
    """Each answer of the drag comes late, and the picture of B waits for its turn."""
    sides, shown_shots = CompareSides(loaded), []
    view = ViewState(compare=Compare.WIPE, against=Against.METHOD, b_method=Method.GATHER)
    shots = [Shot(replace(LENS, focus_distance_m=1.0 + 0.01 * at)) for at in range(400)]
    for shot in shots:
        sides.request(view, shot, 0, 1e-4, within_s=1e-4)
        assert sides.a.is_answering or sides.b.is_working
        if sides.a.output is not None and sides.a.output.shot not in shown_shots:
            shown_shots.append(sides.a.output.shot)
            quick = replace(shown_shots[-1], defocus=sides.a.output.settings)
            np.testing.assert_array_equal(download(sides.a.output.texture), loaded.pixels(quick))
    assert shown_shots and len(shown_shots) < len(shots)
    while any(side.is_working for side in sides.active_sides):
        sides.work(0, 1e-4)
        sides.request(view, shot, 0, 1e-4, within_s=1e-4)
        sides.work(1, 1e-4)
    np.testing.assert_array_equal(download(sides.a.output.texture), loaded.pixels(shot))
    gather_shot = replace(shot, defocus=replace(shot.defocus, method=Method.GATHER))
    np.testing.assert_array_equal(download(sides.b.output.texture), loaded.pixels(gather_shot))
