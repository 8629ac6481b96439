"""Test the plate of a scene: what is read back from the GPU, when, and that it is the same."""

from dataclasses import replace
from threading import Thread

import numpy as np
import pytest

from heatlens.core.base.errors import GpuError
from heatlens.core.model.boxes import Box
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.framing import Framing
from heatlens.core.model.shot.shot import Shot
from heatlens.core.model.value_bins import bin_values
from heatlens.media.plate.coc_line import depth_at_m
from heatlens.media.plate.plate import Plate, ReadPixels
from heatlens.render.frame_renderer import FrameRenderer
from heatlens.render.gpu.textures import download
from heatlens.render.scene_gpu import scene_plate
from support.scenes import still_life
from support.watched_calls import watch_calls

SIZE = (80, 48)
SCENE = still_life()
SHOT = Shot(Lens(50.0, 2.0, 3.0, 36.0), framing=Framing(*SIZE))


@pytest.fixture
def drawn_renderer(renderer: FrameRenderer) -> FrameRenderer:
    renderer.load_scene(SCENE)
    renderer.load_pinhole(SHOT)
    return renderer


def test_scene_plate_downloads_only_on_request(drawn_renderer, monkeypatch):
    downloads = watch_calls(monkeypatch, scene_plate, "download")
    wide = replace(SHOT, lens=replace(SHOT.lens, focal_length_mm=35.0))
    loaded = drawn_renderer.load_pinhole(wide)
    drawn_renderer.render(wide)
    depth_at_m(loaded.plate, 40, 24)
    assert downloads == []
    for _ in range(2):
        np.testing.assert_array_equal(loaded.plate.depth_m, download(loaded.depth))
        np.testing.assert_array_equal(loaded.plate.color, download(loaded.color))
    assert downloads == [(loaded.depth,), (loaded.color,)]


def test_scene_plate_areas_equal_parts_of_whole(drawn_renderer):
    plate = drawn_renderer.loaded.plate
    for area in (Box(0, 0, *SIZE), Box(79, 47, 80, 48), Box(3, 5, 4, 12), Box(30, 20, 37, 22)):
        rows, columns = slice(area.y0, area.y1), slice(area.x0, area.x1)
        np.testing.assert_array_equal(plate.pixels.color_in(area), plate.color[rows, columns])
        np.testing.assert_array_equal(plate.pixels.depth_in(area), plate.depth_m[rows, columns])


@pytest.mark.parametrize("at", [(0, 0), (40, 24), (79, 47), (1, 46)])
def test_depth_at_m_of_scene_plate_equals_that_in_memory(drawn_renderer, at):
    plate = drawn_renderer.loaded.plate
    assert isinstance(plate.in_memory().pixels, ReadPixels)
    assert depth_at_m(plate, *at) == depth_at_m(plate.in_memory(), *at)


def test_scene_plate_report_and_bins_match_its_depths(drawn_renderer):
    loaded = drawn_renderer.loaded
    depth_m, report = loaded.plate.depth_m, loaded.plate.depth
    finite = depth_m[np.isfinite(depth_m)]
    assert (report.near_m, report.far_m) == (finite.min(), finite.max())
    assert report.infinite_count == depth_m.size - finite.size
    expected = bin_values(np.float32(1.0) / depth_m)
    np.testing.assert_array_equal(loaded.bins.occupied, expected.occupied)


def test_scene_plate_raises_error_after_being_overwritten(drawn_renderer):
    old_plate = drawn_renderer.loaded.plate
    depth_before = old_plate.depth_m.copy()
    drawn_renderer.load_pinhole(replace(SHOT, lens=replace(SHOT.lens, focal_length_mm=80.0)))
    np.testing.assert_array_equal(old_plate.depth_m, depth_before)  # it was fetched in time
    with pytest.raises(GpuError, match="in place of this picture"):
        _ = old_plate.color
    with pytest.raises(GpuError, match="in place of this picture"):
        depth_at_m(old_plate, 1, 1)


def test_scene_plate_raises_error_in_other_threads(drawn_renderer):
    errors: list[BaseException] = []

    def asks(plate: Plate) -> None:
        try:
            _ = plate.color
        except AssertionError as error:
            errors.append(error)

    for prepared in (lambda plate: plate, Plate.in_memory):
        thread = Thread(target=asks, args=(prepared(drawn_renderer.loaded.plate),))
        thread.start()
        thread.join()
        assert len(errors) == 1
