"""The pinhole picture of few samples where they are enough, against all of them everywhere."""

from collections.abc import Iterator
from dataclasses import replace

import moderngl
import numpy as np
import pytest

from heatlens.gpu.textures import download, new_texture
from heatlens.measure.compare.metrics import score
from heatlens.model.framing import Framing
from heatlens.model.lens import Lens
from heatlens.model.pupil import PINHOLE
from heatlens.model.shot import Shot
from heatlens.scene.scene_bounds import bounds_m, track_of
from heatlens.scene.scene_view import SceneView, view_of
from heatlens.scene_gpu import bands
from heatlens.scene_gpu.accumulation import Accumulation
from heatlens.scene_gpu.antialias import Antialias
from heatlens.scene_gpu.raster import SceneRaster
from support.scenes import still_life

SIZE = 240, 136
SHOT = Shot(Lens(50.0, 2.0, 3.0, 36.0), framing=Framing(*SIZE, "camera"))
VIEWS, FOR_ALL = 64, 16


class Lab:
    """A still life with lamps, and what is seen of it."""

    def __init__(self, ctx: moderngl.Context) -> None:
        self.ctx = ctx
        self.raster = SceneRaster(ctx)
        scene = still_life()
        self.raster.load(scene)
        self.raster.place(1)
        pose = track_of(scene, SHOT.framing, SHOT.lens).pose_at(1)
        self.view: SceneView = view_of(pose, SHOT.lens, SIZE, bounds_m(scene, 1))
        self.out = new_texture(ctx, SIZE, 4)

    def meant(self, views: int) -> np.ndarray:
        """(H, W, 3): the mean of so many samples in every pixel."""
        sums = Accumulation(self.ctx, self.raster)
        for _ in sums.steps(self.view, PINHOLE, views, self.out, "key"):
            pass
        sums.release()
        return download(self.out)[..., :3]

    def antialiased(self, *views: int, sums: Antialias | None = None) -> np.ndarray:
        """(H, W, 3) after asking for each number of views in turn."""
        own = sums or Antialias(self.ctx, self.raster)
        for count in views:
            for _ in own.steps(self.view, count, self.out, "key"):
                pass
        return download(self.out)[..., :3]


@pytest.fixture(scope="module")
def lab(session_context: moderngl.Context) -> Iterator[Lab]:
    held = Lab(session_context)
    yield held
    held.raster.release()


def test_the_picture_is_that_of_all_views_as_far_as_can_be_seen(ctx, lab):
    found, expected = lab.antialiased(VIEWS), lab.meant(VIEWS)
    assert score(found, expected).flip <= 0.001
    assert found.sum() == pytest.approx(expected.sum(), rel=1e-3)
    wrong = np.abs(found - expected).max(axis=-1) / (expected.max(axis=-1) + 0.01)
    assert np.mean(wrong > 0.02) < 2e-3


def test_each_pixel_has_all_views_or_those_that_all_have(ctx, lab):
    found, all_views, few = lab.antialiased(VIEWS), lab.meant(VIEWS), lab.meant(FOR_ALL)
    is_whole = np.isclose(found, all_views, rtol=1e-6, atol=0).all(axis=-1)
    is_done = np.isclose(found, few, rtol=1e-6, atol=0).all(axis=-1)
    assert np.all(is_whole | is_done)
    differs = np.abs(all_views - few).max(axis=-1) > 0.1 * (few.max(axis=-1) + 0.01)
    assert differs.mean() > 0.001 and np.mean(is_whole[differs]) > 0.95
    assert np.mean(is_done) > 0.4


@pytest.mark.parametrize("views", [2, 5, FOR_ALL])
def test_few_views_are_the_same_everywhere(ctx, lab, views):
    np.testing.assert_allclose(lab.antialiased(views), lab.meant(views), rtol=1e-6)


def test_more_views_go_on_where_the_others_stopped(ctx, lab):
    at_once = lab.antialiased(VIEWS)
    np.testing.assert_array_equal(lab.antialiased(1, FOR_ALL, 20, VIEWS, VIEWS), at_once)
    np.testing.assert_array_equal(lab.antialiased(VIEWS, 5, VIEWS), at_once)


def test_bands_and_breaks_make_no_difference(ctx, lab, monkeypatch):
    """Steps that are left half way are gone on with, to the last bit."""
    at_once = lab.antialiased(VIEWS)
    monkeypatch.setattr(bands, "_LEAST_PX", 1)
    monkeypatch.setattr(lab.raster, "bands", bands.Bands(lab.ctx, 0))
    assert len(lab.raster.bands.of(SIZE)) == 3
    sums = Antialias(lab.ctx, lab.raster)
    for taken in (5, 1, 47, 3, 2, 90):
        steps = sums.steps(lab.view, VIEWS, lab.out, "key")
        for _ in range(taken):
            next(steps)
    np.testing.assert_array_equal(lab.antialiased(VIEWS, sums=sums), at_once)


def test_another_key_begins_again(ctx, lab):
    sums = Antialias(lab.ctx, lab.raster)
    for _ in sums.steps(replace(lab.view, jitter_px=(0.0, 0.0)), 3, lab.out, "other"):
        pass
    np.testing.assert_array_equal(lab.antialiased(4, sums=sums), lab.antialiased(4))


def test_bands_cover_a_picture_once(ctx, lab):
    for size in ((1, 1), (640, 360), (1920, 1080), (16384, 3)):
        found = lab.raster.bands.of(size)
        assert [band.y0 for band in found] == [0, *(band.y1 for band in found[:-1])]
        assert found[-1].y1 == size[1] and all(band.width == size[0] for band in found)
