"""The f-stop of a camera file gives a renderer the discs of the shot, and nothing is lost of it."""

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


def as_model(shot: Shot, model: LensModel) -> Shot:
    return replace(shot, lens=replace(shot.lens, model=model))


@given(SHOTS, st.sampled_from(list(LensModel)))
def test_a_renderer_with_the_told_f_stop_makes_the_same_discs(shot, model):
    shot = as_model(shot, model)
    camera = with_renderer_f_stop(camera_of_shot(shot, "c"))
    assert camera.f_stop is not None
    for frame, f_stop in zip(camera.frames, camera.f_stop, strict=True):
        lens = shot.lens_at(frame)
        there = replace(lens, f_stop=f_stop, model=LensModel.RENDERER)
        found, wanted = coc_line(there, 1920), coc_line(lens, 1920)
        assert found.per_dioptre_px == pytest.approx(wanted.per_dioptre_px, rel=1e-9)


@given(SHOTS, st.sampled_from(list(LensModel)))
def test_a_shot_takes_back_the_nominal_f_stop_and_the_model(shot, model):
    shot = as_model(shot, model)
    camera = with_renderer_f_stop(camera_of_shot(shot, "c"))
    back = with_camera(Shot(Lens(50, 2, 3, 36)), camera)
    assert back.lens.model is model
    for frame in FRAMES:
        assert back.lens_at(frame).f_stop == pytest.approx(shot.lens_at(frame).f_stop, rel=4e-7)


def test_the_nominal_f_stop_can_be_kept():
    camera = with_renderer_f_stop(PHOTOGRAPHIC)
    assert camera.f_stop[0] == pytest.approx(1.3 * (1 - 0.05 / 0.94), rel=1e-12)
    assert camera.f_stop[-1] == 1.3  # with focus at infinity both models are one
    assert camera.nominal_f_stop == PHOTOGRAPHIC.f_stop
    assert with_nominal_f_stop(camera) == PHOTOGRAPHIC
    assert with_renderer_f_stop(camera) == camera


@pytest.mark.parametrize("model", [None, LensModel.RENDERER])
def test_what_is_a_renderers_already_stays(model):
    camera = moving_camera(lens_model=model)
    assert with_renderer_f_stop(camera) is camera


@pytest.mark.parametrize("suffix", [".json", ".csv", ".usda"])
def test_files_hold_both_f_stops_and_the_model(tmp_path, suffix):
    camera = with_renderer_f_stop(PHOTOGRAPHIC)
    write_camera(tmp_path / f"cam{suffix}", camera)
    found = read_camera(str(tmp_path / f"cam{suffix}"))
    assert found.lens_model is LensModel.PHOTOGRAPHIC
    assert found.f_stop == pytest.approx(camera.f_stop, rel=1e-6)
    assert found.nominal_f_stop == pytest.approx(camera.nominal_f_stop, rel=1e-6)


def test_nuke_shows_the_nominal_f_stop_on_a_knob_of_its_own():
    text = nuke_text(with_renderer_f_stop(PHOTOGRAPHIC))
    assert "nominal_f_stop 1.3\n" in text and "fstop {{curve x1001 1.23" in text


@pytest.mark.parametrize("parameter", LensParameter)
def test_keys_leave_the_model_alone(parameter):
    shot = Shot(Lens(50, 2, 3, 36, model=LensModel.RENDERER)).with_key(1, parameter)
    assert shot.lens_at(2.5).model is LensModel.RENDERER
