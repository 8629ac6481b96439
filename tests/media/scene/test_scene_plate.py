"""A scene's plate: what of it is read back, when, and that it is what lies on the GPU."""

from dataclasses import replace
from threading import Thread

import numpy as np
import pytest

from heatlens.core.base.errors import GpuError
from heatlens.core.model.boxes import Box
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.framing import Framing
from heatlens.core.model.shot.shot import Shot
from heatlens.core.model.value_bins import bins_of
from heatlens.media.plate.coc_line import depth_at_m
from heatlens.media.plate.plate import Plate, ReadPixels
from heatlens.render.frame_renderer import FrameRenderer
from heatlens.render.gpu.device import Texture
from heatlens.render.gpu.textures import download
from heatlens.render.scene_gpu import scene_plate
from support.scenes import still_life

SIZE = (80, 48)
SCENE = still_life()
SHOT = Shot(Lens(50.0, 2.0, 3.0, 36.0), framing=Framing(*SIZE))


@pytest.fixture
def looked(renderer: FrameRenderer) -> FrameRenderer:
    renderer.load_scene(SCENE)
    renderer.look(SHOT)
    return renderer


def test_nothing_of_whole_size_is_read_back_until_it_is_asked_for(looked, monkeypatch):
    asked: list[Texture] = []
    monkeypatch.setattr(scene_plate, "download", lambda tx: asked.append(tx) or download(tx))
    wide = replace(SHOT, lens=replace(SHOT.lens, focal_length_mm=35.0))
    loaded = looked.look(wide)
    looked.render(wide)
    depth_at_m(loaded.plate, 40, 24)
    assert asked == []
    for _ in range(2):
        np.testing.assert_array_equal(loaded.plate.depth_m, download(loaded.depth))
        np.testing.assert_array_equal(loaded.plate.color, download(loaded.color))
    assert asked == [loaded.depth, loaded.color]


def test_areas_are_those_of_the_whole(looked):
    plate = looked.loaded.plate
    for area in (Box(0, 0, *SIZE), Box(79, 47, 80, 48), Box(3, 5, 4, 12), Box(30, 20, 37, 22)):
        rows, columns = slice(area.y0, area.y1), slice(area.x0, area.x1)
        np.testing.assert_array_equal(plate.pixels.color_in(area), plate.color[rows, columns])
        np.testing.assert_array_equal(plate.pixels.depth_in(area), plate.depth_m[rows, columns])


@pytest.mark.parametrize("at", [(0, 0), (40, 24), (79, 47), (1, 46)])
def test_a_click_finds_what_it_finds_in_memory(looked, at):
    plate = looked.loaded.plate
    assert isinstance(plate.in_memory().pixels, ReadPixels)
    assert depth_at_m(plate, *at) == depth_at_m(plate.in_memory(), *at)


def test_report_and_bins_are_those_of_the_depths(looked):
    loaded = looked.loaded
    depth_m, report = loaded.plate.depth_m, loaded.plate.depth
    finite = depth_m[np.isfinite(depth_m)]
    assert (report.near_m, report.far_m) == (finite.min(), finite.max())
    assert report.infinite_count == depth_m.size - finite.size
    expected = bins_of(np.float32(1.0) / depth_m)
    np.testing.assert_array_equal(loaded.bins.occupied, expected.occupied)


def test_what_has_been_drawn_over_is_not_taken_for_what_it_was(looked):
    before = looked.loaded.plate
    kept = before.depth_m.copy()
    looked.look(replace(SHOT, lens=replace(SHOT.lens, focal_length_mm=80.0)))
    np.testing.assert_array_equal(before.depth_m, kept)  # it was fetched in time
    with pytest.raises(GpuError, match="overwritten"):
        _ = before.color
    with pytest.raises(GpuError, match="overwritten"):
        depth_at_m(before, 1, 1)


def test_other_threads_are_told_instead_of_given_whatever_lies_there(looked):
    told: list[BaseException] = []

    def asks(plate: Plate) -> None:
        try:
            _ = plate.color
        except AssertionError as error:
            told.append(error)

    for prepared in (lambda plate: plate, Plate.in_memory):
        thread = Thread(target=asks, args=(prepared(looked.loaded.plate),))
        thread.start()
        thread.join()
        assert len(told) == 1
