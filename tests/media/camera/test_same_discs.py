"""Test that the f-stop of a camera file gives a renderer the same blur, without loss."""

from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from heatlens.core.model.focus.coc import coc_line
from heatlens.core.model.lens.lens import Lens, LensModel
from heatlens.core.model.shot.lens_parameter import LensParameter
from heatlens.core.model.shot.shot import Shot
from heatlens.media.camera.camera_file import read_camera, write_camera
from heatlens.media.camera.into_shot import with_camera
from heatlens.media.camera.nuke_write import nuke_text
from heatlens.media.camera.samples import with_nominal_f_stop, with_renderer_f_stop
from heatlens.render.source.named import camera_of_shot
from support.cameras import FRAMES, SHOTS, moving_camera

PHOTOGRAPHIC = moving_camera(lens_model=LensModel.PHOTOGRAPHIC)


def with_lens_model(shot: Shot, model: LensModel) -> Shot:
    return replace(shot, lens=replace(shot.lens, model=model))


@given(SHOTS, st.sampled_from(list(LensModel)))
def test_renderer_f_stop_gives_same_circles_of_confusion(shot, model):
    shot = with_lens_model(shot, model)
    camera = with_renderer_f_stop(camera_of_shot(shot, "c"))
    assert camera.f_stop is not None
    for frame, f_stop in zip(camera.frames, camera.f_stop, strict=True):
        lens = shot.lens_at(frame)
        renderer_lens = replace(lens, f_stop=f_stop, model=LensModel.RENDERER)
        renderer_line, shot_line = coc_line(renderer_lens, 1920), coc_line(lens, 1920)
        assert renderer_line.per_dioptre_px == pytest.approx(shot_line.per_dioptre_px, rel=1e-9)


@given(SHOTS, st.sampled_from(list(LensModel)))
def test_with_camera_restores_nominal_f_stop_and_model(shot, model):
    shot = with_lens_model(shot, model)
    camera = with_renderer_f_stop(camera_of_shot(shot, "c"))
    new_shot = with_camera(Shot(Lens(50, 2, 3, 36)), camera)
    assert new_shot.lens.model is model
    for frame in FRAMES:
        assert new_shot.lens_at(frame).f_stop == pytest.approx(shot.lens_at(frame).f_stop, rel=4e-7)


def test_with_nominal_f_stop_reverts_with_renderer_f_stop():
    camera = with_renderer_f_stop(PHOTOGRAPHIC)
    assert camera.f_stop[0] == pytest.approx(1.3 * (1 - 0.05 / 0.94), rel=1e-12)
    assert camera.f_stop[-1] == 1.3  # with focus at infinity both models are one
    assert camera.nominal_f_stop == PHOTOGRAPHIC.f_stop
    assert with_nominal_f_stop(camera) == PHOTOGRAPHIC
    assert with_renderer_f_stop(camera) == camera


@pytest.mark.parametrize("model", [None, LensModel.RENDERER])
def test_with_renderer_f_stop_keeps_camera_of_renderer_model(model):
    camera = moving_camera(lens_model=model)
    assert with_renderer_f_stop(camera) is camera


@pytest.mark.parametrize("suffix", [".json", ".csv", ".usda"])
def test_camera_files_hold_both_f_stops_and_model(tmp_path, suffix):
    camera = with_renderer_f_stop(PHOTOGRAPHIC)
    write_camera(tmp_path / f"cam{suffix}", camera)
    read_back = read_camera(str(tmp_path / f"cam{suffix}"))
    assert read_back.lens_model is LensModel.PHOTOGRAPHIC
    assert read_back.f_stop == pytest.approx(camera.f_stop, rel=1e-6)
    assert read_back.nominal_f_stop == pytest.approx(camera.nominal_f_stop, rel=1e-6)


def test_nuke_camera_has_knob_for_nominal_f_stop():
    text = nuke_text(with_renderer_f_stop(PHOTOGRAPHIC))
    assert "nominal_f_stop 1.3\n" in text and "fstop {{curve x1001 1.23" in text


@pytest.mark.parametrize("parameter", LensParameter)
def test_with_key_keeps_lens_model(parameter):
    shot = Shot(Lens(50, 2, 3, 36, model=LensModel.RENDERER)).with_key(1, parameter)
    assert shot.lens_at(2.5).model is LensModel.RENDERER
