"""What `heatlens bench --methods` says of errors: the laws that hold on every machine."""

import json
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
    truth_lens,
    truth_of,
    truth_scene,
)
from heatlens.lab.measure.bench.methods import entrants, wall_framing
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


def accumulated(frames: BenchFrames, views: int) -> FloatArray:
    return np.ascontiguousarray(download(frame_of(frames, 10.0, views).render())[..., :3])


@pytest.fixture(scope="module")
def report(frames: BenchFrames) -> ErrorReport:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(methods, "METHOD_COC_PX", (2.0, 12.0))
        return measure_errors(frames, SIZE, SETTINGS, VIEWS, 1, lambda _: None)


@pytest.mark.usefixtures("ctx")
def test_more_views_are_nearer_to_the_truth(frames):
    truth = accumulated(frames, 256)
    flips = [score(accumulated(frames, n), truth).flip for n in (4, 23, 66)]
    assert all(more < 0.85 * fewer for fewer, more in pairwise(flips)), flips


@pytest.mark.usefixtures("ctx")
def test_the_truth_held_against_itself_has_no_error(frames):
    truth, half_flip = truth_of(frame_of(frames, 10.0), 64, lambda _: None)
    again, _ = truth_of(frame_of(frames, 10.0), 64, lambda _: None)
    assert score(again, truth).flip == 0 and half_flip > 0
    np.testing.assert_array_equal(truth, again)


@pytest.mark.usefixtures("ctx")
def test_the_truth_is_the_mean_of_so_many_views_through_that_lens(frames):
    """The second half goes on where the first stopped, and that is the same as at one go."""
    truth, half_flip = truth_of(frame_of(frames, 10.0), 64, lambda _: None)
    np.testing.assert_allclose(truth, accumulated(frames, 64), rtol=1e-4, atol=1e-4)
    assert half_flip == pytest.approx(score(accumulated(frames, 32), truth).flip, abs=1e-3)


@pytest.mark.usefixtures("ctx")
def test_no_frame_goes_on_with_the_views_of_another(frames):
    """Or the second of two on one lens would be timed for what the first had left to do."""
    shorter, longer = frame_of(frames, 10.0, 5), frame_of(frames, 10.0, 8)
    longer = replace(shorter, shot=longer.shot)
    assert [sum(step == "view" for step in frame.steps()) for frame in (shorter, longer)] == [5, 8]


@pytest.mark.usefixtures("ctx")
@pytest.mark.parametrize("largest_px", [2.0, 200.0])
def test_the_largest_blur_of_the_truth_scene_is_the_one_asked_for(frames, largest_px):
    frame = frame_of(frames, largest_px)
    plate = frame.renderer.look(frame.shot).plate
    coc = coc_px(plate.depth_m, coc_line(frame.shot.lens, SIZE[0]))
    assert np.abs(coc).max() == pytest.approx(largest_px, rel=1e-3)
    depths = np.unique(np.round(plate.depth_m, 1))
    assert {1.0, 3.0, 8.0, 20.0, 40.0} <= set(depths.tolist())
    assert plate.color[..., :3].max() > 5.0  # a lamp
    assert frame.shot.lens.focus_distance_m == LENS.focus_distance_m


def test_every_method_has_a_cell_at_every_blur(report):
    assert [row.coc_px for row in report.rows] == [2.0, 12.0]
    for row in report.rows:
        assert list(row.cells) == list(entrants(SETTINGS))
        assert all(cell is not None and cell.ms > 0 for cell in row.cells.values())
        assert all(0 < cell.flip < 1 and cell.ssim < 1 for cell in row.cells.values())


def test_errors_rise_with_the_blur_and_fall_with_the_views(report):
    little, much = (row.cells for row in report.rows)
    assert all(much[name].flip > little[name].flip for name in little)
    for cells in (little, much):
        assert cells["accumulation 66"].flip < cells["accumulation 23"].flip
        assert cells["accumulation 66"].psnr_db > cells["accumulation 23"].psnr_db
        assert cells["accumulation 66"].ssim > cells["accumulation 23"].ssim


def test_layers_of_diffusion_are_nearer_to_the_truth_than_one_of_heat(report):
    cells = report.rows[-1].cells
    assert cells["diffusion"].ssim > cells["heat"].ssim + 0.02
    assert cells["diffusion"].psnr_db > cells["heat"].psnr_db


def test_the_truth_is_surer_than_fewer_views(report):
    for row in report.rows:
        assert 0 < row.truth_flip < row.cells["accumulation 23"].flip


def test_the_tables_have_all_rows_and_columns_and_say_skipped(report):
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
def test_one_that_takes_too_long_is_given_up_and_left_out_from_there_on(frames, monkeypatch):
    monkeypatch.setattr(methods, "METHOD_COC_PX", (2.0, 9.0))
    monkeypatch.setattr(timing, "LIMIT_S", -1.0)
    said: list[str] = []
    found = measure_errors(frames, SIZE, SETTINGS, VIEWS, 1, said.append)
    assert all(cell is None for row in found.rows for cell in row.cells.values())
    assert sum("gather skipped" in sentence for sentence in said) == 1
    assert sum(sentence.startswith("truth from 128 views") for sentence in said) == 2


@pytest.mark.usefixtures("ctx")
def test_the_command_puts_errors_beside_times(capsys, monkeypatch):
    monkeypatch.setattr(methods, "METHOD_COC_PX", (5.0,))
    words = ("bench", "--size", "64x48", "--runs", "1", "--views", "4", "--methods")
    truth = ("--truth-size", "64x36", "--truth-views", "80")
    assert main([*words, *truth, "--json"]) == 0
    said = capsys.readouterr()
    found = json.loads(said.out)["method_errors"]
    assert (found["width"], found["height"], found["truth_views"]) == (64, 36, 80)
    assert set(found["rows"][0]["cells"]["gather"]) == {"ms", "flip", "psnr_db", "ssim"}
    assert "this takes about" in said.err  # a log gets no line for each part


@pytest.mark.parametrize(
    ("size", "settings", "views", "said"),
    [
        (SIZE, DefocusSettings(), 66, "above 66, the views"),
        (SIZE, DefocusSettings(views=500), 500, "above 500, the views"),
        (SIZE, DefocusSettings(), -1, "or 0 to measure"),
        (SIZE, DefocusSettings(), 65537, "at most 65536"),
        ((64, 15), DefocusSettings(), 100, "16 pixels a side"),
        (SIZE, DefocusSettings(proxy=0.25), 100, "after --proxy"),
    ],
)
def test_what_would_be_no_truth_is_refused(size, settings, views, said):
    with pytest.raises(InputError, match=said):
        check_errors(size, settings, views)
    check_errors(SIZE, DefocusSettings(), 67)


def test_without_the_packages_that_measure_the_way_out_is_said(monkeypatch, capsys):
    monkeypatch.setitem(sys.modules, "flip_evaluator", None)
    assert main(["bench", "--methods"]) == 2
    error = capsys.readouterr().err
    assert "heatlens[compare]" in error and "--truth-views 0" in error
