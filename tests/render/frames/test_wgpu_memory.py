"""Pictures drawn by wgpu need no more memory than the first of them did."""

from collections.abc import Callable, Iterator

import pytest

from heatlens.core.base.memory import resident_bytes
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.settings import Bokeh, DefocusSettings, Quality
from heatlens.core.model.shot.shot import Shot
from heatlens.media.color.color_config import LINEAR_REC709, load_color_config
from heatlens.media.color.view_transform import view_transform
from heatlens.render.display.display_pass import DisplayPass
from heatlens.render.frame_renderer import FrameRenderer
from heatlens.render.gpu.textures import new_texture
from heatlens.render.gpu.wgpu.wgpu_device import headless_device
from support.plates import plate_of, wires_and_lamps

PICTURES, MOST_BYTES = 8, 1 << 20
ROUND = Lens(85.0, 1.2, 1.6, 36.0)
SHAPED = Lens(85.0, 1.2, 1.6, 36.0, squeeze=1.6, blades=5, cat_eye=0.5)
SHOTS = {
    "film": Shot(ROUND, DefocusSettings(Bokeh.DISC, Quality.FILM)),
    "film_by_blades": Shot(SHAPED, DefocusSettings(Bokeh.DISC, Quality.FILM)),
    "half_size_by_blades": Shot(SHAPED, DefocusSettings(Bokeh.DISC, Quality.FILM, proxy=0.5)),
}


@pytest.fixture(scope="module")
def renderer_by_wgpu() -> Iterator[FrameRenderer]:
    device = headless_device()
    renderer = FrameRenderer(device)
    renderer.load(plate_of(*wires_and_lamps(160, 90)))
    yield renderer
    device.release()


def grown_bytes(run: Callable[[], object]) -> int:
    """Return how much more memory the process holds after a few runs than after the first."""
    for _ in range(3):
        run()
    before = resident_bytes()
    if before is None:
        pytest.skip("the system does not say how much memory a process holds")
    for _ in range(PICTURES):
        run()
    after = resident_bytes()
    assert after is not None
    return after - before


@pytest.mark.parametrize("name", SHOTS)
def test_memory_does_not_grow_with_number_of_pictures(renderer_by_wgpu, name):
    """lavapipe of Mesa 22 may build a program for each run, and never frees it."""
    assert grown_bytes(lambda: renderer_by_wgpu.pixels(SHOTS[name])) <= MOST_BYTES


def test_memory_does_not_grow_with_number_of_views(renderer_by_wgpu):
    device, view = renderer_by_wgpu.ctx, "ACES 2.0 - SDR 100 nits (Rec.709)"
    display, picture, out = DisplayPass(device), *(new_texture(device, (64, 64), 4) for _ in "ab")
    colors = load_color_config(None)
    display.set_transform(view_transform(colors, "sRGB - Display", view, LINEAR_REC709[0]))

    def show() -> None:
        display.run(picture, out)
        device.finish()

    assert grown_bytes(show) <= MOST_BYTES
