"""Test antialiasing of the pinhole image, and which pixels need no more samples."""

from collections.abc import Iterator
from dataclasses import replace
from functools import cached_property

import numpy as np
import pytest
from scipy.ndimage import uniform_filter

from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.framing import Framing
from heatlens.core.model.shot.shot import Shot
from heatlens.lab.measure.metrics import score
from heatlens.media.scene.scene_bounds import bounds_m, track_of
from heatlens.media.scene.scene_view import SceneView, view_of
from heatlens.render.gpu.device import Device
from heatlens.render.gpu.textures import download, new_texture
from heatlens.render.scene_gpu import bands
from heatlens.render.scene_gpu.antialias import Antialias
from heatlens.render.scene_gpu.raster import SceneRaster
from heatlens.render.scene_gpu.unsettled import UnsettledPixels
from support.scenes import NIGHT, lamp, placement, plane, scene_of, still_life

SIZE = 240, 136
SHOT = Shot(Lens(50.0, 2.0, 3.0, 36.0), framing=Framing(*SIZE, "camera"))


class Lab:
    """A still life with lamps, drawn directly and antialiased."""

    def __init__(self, ctx: Device) -> None:
        self.ctx = ctx
        self.raster = SceneRaster(ctx)
        scene = still_life()
        self.raster.load(scene)
        self.raster.place(1)
        pose = track_of(scene, SHOT.framing, SHOT.lens).pose_at(1)
        self.view: SceneView = view_of(pose, SHOT.lens, SIZE, bounds_m(scene, 1))
        self.out = new_texture(ctx, SIZE, 4)

    def meant(self, across: int) -> np.ndarray:
        """Return (H, W, 3), the mean of many pictures with one sample a pixel each."""
        found = np.zeros((SIZE[1], SIZE[0], 3))
        steps = (np.arange(across) + 0.5) / across - 0.5
        for y in steps.tolist():
            for x in steps.tolist():
                self.raster.draw(replace(self.view, jitter_px=(x, y)), self.out)
                found += download(self.out)[..., :3]
        return found / across**2

    @cached_property
    def many_samples(self) -> np.ndarray:
        """The mean (H, W, 3) of 64 samples."""
        return self.meant(8)

    def antialiased(
        self, across: int, antialias: Antialias | None = None, margin_px: int = 0
    ) -> tuple[np.ndarray, ...]:
        """Return the antialiased picture (H, W, 3), and which pixels were changed (H, W)."""
        antialias = antialias or Antialias(self.ctx, self.raster)
        for _ in antialias.steps(self.view, across, 1, margin_px, "key"):
            pass
        picture = antialias.picture(SIZE)
        return download(picture.mean)[..., :3], download(picture.done) > 0


@pytest.fixture(scope="module")
def lab(session_context: Device) -> Iterator[Lab]:
    held = Lab(session_context)
    yield held
    held.raster.release()


@pytest.mark.parametrize("across", [1, 2, 3])
def test_antialiased_image_is_mean_of_its_samples(ctx, lab, across):
    image, expected = lab.antialiased(across)[0], lab.meant(across)
    relative_error = np.abs(image - expected).max(axis=-1) / (expected.max(axis=-1) + 0.01)
    assert (
        np.quantile(relative_error, 0.99) < 0.02
    )  # maps are read a little sharper by closer samples
    assert image.sum() == pytest.approx(expected.sum(), rel=5e-3)


def test_antialias_done_pixels_need_no_more_samples(ctx, lab):
    few_samples, is_done = lab.antialiased(4)
    many_samples = lab.many_samples
    assert 0.4 < is_done.mean() < 0.95
    finished = np.where(is_done[..., None], few_samples, many_samples).astype(np.float32)
    assert score(finished, many_samples.astype(np.float32)).flip <= 0.001
    differs = np.abs(many_samples - few_samples).max(axis=-1) > 0.1 * (
        few_samples.max(axis=-1) + 0.01
    )
    assert differs.mean() > 0.001 and not (differs & is_done).any()


def test_antialias_margin_needs_more_samples_only_where_a_wide_disc_shows_them(ctx, lab):
    margin, rim = 50, 8
    (picture, is_done), (same, is_done_far) = (
        lab.antialiased(2, margin_px=px) for px in (0, margin)
    )
    np.testing.assert_array_equal(picture, same)
    frame = np.zeros_like(is_done)
    frame[margin - rim + 1 : rim - 1 - margin, margin - rim + 1 : rim - 1 - margin] = True
    np.testing.assert_array_equal(is_done[frame], is_done_far[frame])
    assert (is_done <= is_done_far).all() and (is_done_far & ~is_done).sum() > 500
    assert not is_done_far[~frame].all()  # the lamps
    error = np.where(
        is_done_far & ~is_done & ~frame, (picture - lab.many_samples).mean(axis=-1), 0.0
    )
    assert np.abs(uniform_filter(error, 2 * rim - 1)).max() < 0.004


def test_runs_of_unsettled_pixels_hold_them_all(ctx):
    done = np.random.default_rng(5).random((40, 700)) > 0.002
    texture = new_texture(ctx, (700, 40), 1, "f2")
    texture.write(done.astype(np.float16).tobytes())
    pixels = UnsettledPixels(texture, is_read=True)
    for rows in ((0, 10), (10, 40), (30, 50)):
        is_drawn = np.zeros(700, bool)
        for x0, x1 in pixels.runs(rows):
            assert not is_drawn[x0:x1].any()
            is_drawn[x0:x1] = True
        assert is_drawn[~done[slice(*rows)].all(axis=0)].all() and not is_drawn.all()
    assert UnsettledPixels(texture, is_read=False).runs((0, 10)) == [(0, 700)]
    texture.release()


def test_antialias_edge_between_two_pixels_is_not_done(ctx):
    raster = SceneRaster(ctx)
    card_placement = placement(2.0, z=-2.0)  # the left rim of a card runs between two pixels
    scene = scene_of((plane(2.0),), [(0, card_placement)], (lamp((0.5, 0.5, 0.5)),), daylight=NIGHT)
    raster.load(scene)
    raster.place(1)
    view = SceneView(
        world_to_camera=np.eye(4),
        size=(16, 8),
        focal_px=20.0,
        focus_m=np.inf,
        near_m=0.1,
        far_m=10.0,
    )
    antialias = Antialias(ctx, raster)
    for _ in antialias.steps(view, 4, 1, 0, "key"):
        pass
    mean, done = (
        download(it)
        for it in (antialias.picture(view.size).mean, antialias.picture(view.size).done)
    )
    assert mean[4, 7, 0] == 0 and mean[4, 8, 0] == pytest.approx(0.5)
    assert not done[4, 7:9].any() and done[4, [2, 6, 9, 13]].all()
    for held in (antialias, raster):
        held.release()


def test_antialias_in_bands_gives_same_image(ctx, lab, monkeypatch):
    at_once = lab.antialiased(4)
    monkeypatch.setattr(bands, "_LEAST_PX", 1)
    monkeypatch.setattr(bands, "_SAMPLES_MOST", 40 * 16 * SIZE[0])
    monkeypatch.setattr(lab.raster, "bands", bands.Bands(lab.ctx, 10**9))
    assert len(list(lab.raster.bands.of_samples(SIZE, 4, 1))) == 4
    for banded, expected in zip(lab.antialiased(4), at_once, strict=True):
        difference = np.abs(banded.astype(float) - expected)
        assert np.quantile(difference, 0.995) < 1e-3  # rims may be met by another sample


def test_antialias_does_not_draw_same_key_again(ctx, lab):
    antialias = Antialias(ctx, lab.raster)
    assert list(antialias.steps(lab.view, 2, 1, 0, "key")) != []
    assert list(antialias.steps(lab.view, 2, 1, 0, "key")) == []
    assert list(antialias.steps(lab.view, 2, 1, 0, "other")) != []
    abandoned = antialias.steps(lab.view, 3, 1, 0, "other")
    next(abandoned)
    abandoned.close()
    assert list(antialias.steps(lab.view, 2, 1, 0, "other")) != []
    antialias.release()


def test_bands_cover_image_once(ctx, lab):
    for size in ((1, 1), (640, 360), (1920, 1080), (16384, 3)):
        band_list = list(lab.raster.bands.of(size))
        assert [band.y0 for band in band_list] == [0, *(band.y1 for band in band_list[:-1])]
        assert band_list[-1].y1 == size[1] and all(band.width == size[0] for band in band_list)


@pytest.mark.parametrize("across", [1, 4, 8])
def test_bands_of_samples_have_equal_rows_and_cover_image_once(lab, across):
    for size in ((1, 1), (640, 360), (1920, 1080), (2000, 3)):
        band_list = list(lab.raster.bands.of_samples(size, across, 2))
        assert [first for first, _ in band_list] == [0, *(end for _, end in band_list[:-1])]
        assert band_list[-1][1] - len(band_list) < size[1] <= band_list[-1][1]
        assert len({end - first for first, end in band_list}) == 1
        assert size[0] * across**2 * band_list[0][1] <= max(
            bands._SAMPLES_MOST, size[0] * across**2
        )
