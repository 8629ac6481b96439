"""Test the errors of `heatlens bench --methods`, by rules that hold on every machine."""

import sys
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from heatlens.core.base.errors import InputError
from heatlens.core.model.focus.coc import coc_line, coc_px
from heatlens.core.model.shot.settings import DefocusSettings, Method
from heatlens.fronts.commands.main import main
from heatlens.lab.measure.bench import method_errors, methods, timing
from heatlens.lab.measure.bench.method_errors import (
    ErrorReport,
    check_errors,
    measure_errors,
    render_truth,
    truth_lens,
    truth_scene,
)
from heatlens.lab.measure.bench.methods import compared_methods, wall_framing
from heatlens.lab.measure.bench.report import error_tables
from heatlens.lab.measure.bench.synthetic_plate import LENS
from heatlens.lab.measure.bench.timing import BenchFrames, SceneFrame
from heatlens.lab.measure.metrics import score
from heatlens.render.gpu.device import Device
from heatlens.render.gpu.textures import FloatArray, download

SIZE = (64, 36)
VIEWS = 128
SETTINGS = DefocusSettings(views=4)  # rays are the slowest here


@pytest.fixture(scope="module")
def frames(session_context: Device) -> BenchFrames:
    return BenchFrames(session_context, "sweep")


def frame_of(frames: BenchFrames, largest_px: float, views: int = 1) -> SceneFrame:
    lens = truth_lens(largest_px, SIZE[0])
    settings = DefocusSettings(method=Method.ACCUMULATION, views=views)
    return frames.scene_frame(truth_scene(), wall_framing(SIZE), lens, settings)


def accumulated_picture(frames: BenchFrames, views: int) -> FloatArray:
    return np.ascontiguousarray(download(frame_of(frames, 10.0, views).render())[..., :3])


@pytest.fixture(scope="module")
def report(frames: BenchFrames) -> ErrorReport:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(methods, "METHOD_COC_PX", (2.0, 12.0))
        return measure_errors(frames, SIZE, SETTINGS, VIEWS, 1, lambda _: None)


@pytest.mark.usefixtures("ctx")
def test_accumulation_error_falls_with_more_views(frames):
    truth = accumulated_picture(frames, 256)
    flips = [score(accumulated_picture(frames, n), truth).flip for n in (4, 23, 66)]
    assert all(more < 0.85 * fewer for fewer, more in pairwise(flips)), flips


@pytest.mark.usefixtures("ctx")
def test_truth_is_reproducible_and_has_zero_error(frames):
    truth, half_flip = render_truth(frame_of(frames, 10.0), 64, lambda _: None)
    second_truth, _ = render_truth(frame_of(frames, 10.0), 64, lambda _: None)
    assert score(second_truth, truth).flip == 0 and half_flip > 0
    np.testing.assert_array_equal(truth, second_truth)


@pytest.mark.usefixtures("ctx")
def test_truth_equals_accumulation_of_same_view_count(frames):
    """The second half continues the views of the first, which gives the same mean."""
    truth, half_flip = render_truth(frame_of(frames, 10.0), 64, lambda _: None)
    np.testing.assert_allclose(truth, accumulated_picture(frames, 64), rtol=1e-4, atol=1e-4)
    assert half_flip == pytest.approx(score(accumulated_picture(frames, 32), truth).flip, abs=1e-3)


@pytest.mark.usefixtures("ctx")
def test_scene_frames_do_not_share_accumulated_views(frames):
    """Shared views would make the second frame with the same lens too fast."""
    shorter, longer = frame_of(frames, 10.0, 5), frame_of(frames, 10.0, 8)
    longer = replace(shorter, shot=longer.shot)
    assert [sum(step == "view" for step in frame.steps()) for frame in (shorter, longer)] == [5, 8]


@pytest.mark.usefixtures("ctx")
@pytest.mark.parametrize("largest_px", [2.0, 200.0])
def test_truth_lens_gives_requested_largest_blur(frames, largest_px):
    frame = frame_of(frames, largest_px)
    plate = frame.renderer.load_pinhole(frame.shot).plate
    coc = coc_px(plate.depth_m, coc_line(frame.shot.lens, SIZE[0]))
    assert np.abs(coc).max() == pytest.approx(largest_px, rel=1e-3)
    depths = np.unique(np.round(plate.depth_m, 1))
    assert {1.0, 3.0, 8.0, 20.0, 40.0} <= set(depths.tolist())
    assert plate.color[..., :3].max() > 5.0  # a lamp
    assert frame.shot.lens.focus_distance_m == LENS.focus_distance_m


def test_error_report_has_cell_per_method_and_blur(report):
    assert [row.coc_px for row in report.rows] == [2.0, 12.0]
    for row in report.rows:
        assert list(row.cells) == list(compared_methods(SETTINGS))
        assert all(cell is not None and cell.ms > 0 for cell in row.cells.values())
        assert all(0 < cell.flip < 1 and cell.ssim < 1 for cell in row.cells.values())


def test_errors_rise_with_blur_and_fall_with_views(report):
    small_blur, large_blur = (row.cells for row in report.rows)
    assert all(large_blur[name].flip > small_blur[name].flip for name in small_blur)
    for cells in (small_blur, large_blur):
        assert cells["accumulation 66"].flip < cells["accumulation 23"].flip
        assert cells["accumulation 66"].psnr_db > cells["accumulation 23"].psnr_db
        assert cells["accumulation 66"].ssim > cells["accumulation 23"].ssim


def test_diffusion_has_smaller_error_than_heat(report):
    cells = report.rows[-1].cells
    assert cells["diffusion"].ssim > cells["heat"].ssim + 0.02
    assert cells["diffusion"].psnr_db > cells["heat"].psnr_db


def test_noise_of_truth_is_below_error_of_23_views(report):
    for row in report.rows:
        assert 0 < row.truth_flip < row.cells["accumulation 23"].flip


def test_error_tables_are_complete_and_mark_skipped_cells(report):
    blocks = error_tables(report).split("\n\n")
    assert [block.splitlines()[-5].split(",")[0].split()[0] for block in blocks] == [
        *("FLIP", "PSNR", "SSIM", "ms")
    ]
    for block in blocks:
        rows = [line.split() for line in block.splitlines()[-2:]]
        assert [row[0] for row in rows] == ["2", "12"]
        assert {len(row) for row in rows} == {11 if block is blocks[0] else 10}
    cells = report.rows[0].cells | {"gather": None}
    row = method_errors.ErrorRow(2.0, 0.1, cells)
    assert error_tables(ErrorReport(*SIZE, 20.0, VIEWS, (row,))).count("skipped") == 4


@pytest.mark.usefixtures("ctx")
def test_measure_errors_skips_slow_method_from_then_on(frames, monkeypatch):
    monkeypatch.setattr(methods, "METHOD_COC_PX", (2.0, 9.0))
    monkeypatch.setattr(timing, "LIMIT_S", -1.0)
    messages: list[str] = []
    report = measure_errors(frames, SIZE, SETTINGS, VIEWS, 1, messages.append)
    assert all(cell is None for row in report.rows for cell in row.cells.values())
    assert sum("gather skipped" in sentence for sentence in messages) == 1
    assert sum(sentence.startswith("truth from 128 views") for sentence in messages) == 2


@pytest.mark.parametrize(
    ("size", "settings", "views", "message"),
    [
        (SIZE, DefocusSettings(), 66, "above 66, the views"),
        (SIZE, DefocusSettings(views=500), 500, "above 500, the views"),
        (SIZE, DefocusSettings(), -1, "or 0 to measure"),
        (SIZE, DefocusSettings(), 65537, "at most 65536"),
        ((64, 15), DefocusSettings(), 100, "16 pixels a side"),
        (SIZE, DefocusSettings(proxy=0.25), 100, "after --proxy"),
    ],
)
def test_check_errors_rejects_unsuitable_truth(size, settings, views, message):
    with pytest.raises(InputError, match=message):
        check_errors(size, settings, views)
    check_errors(SIZE, DefocusSettings(), 67)


def test_bench_methods_without_flip_suggests_install_or_option(monkeypatch, capsys):
    monkeypatch.setitem(sys.modules, "flip_evaluator", None)
    assert main(["bench", "--methods"]) == 2
    error = capsys.readouterr().err
    assert "heatlens[compare]" in error and "--truth-views 0" in error
