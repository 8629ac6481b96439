"""Test `heatlens bench --methods`: a complete table in which slow methods are skipped."""

import json
import math
from itertools import pairwise

import numpy as np
import pytest
from PIL import Image as PillowImage

from heatlens.core.model.focus.coc import coc_line, coc_px
from heatlens.core.model.lens.disc_shape import DiscShape
from heatlens.core.model.shot.settings import DefocusSettings, Method
from heatlens.fronts.commands.main import main
from heatlens.lab.measure.bench import methods, timing
from heatlens.lab.measure.bench.methods import (
    MethodReport,
    MethodRow,
    compared_methods,
    measure_methods,
    uniform_coc_scene,
    wall_framing,
)
from heatlens.lab.measure.bench.report import time_table
from heatlens.lab.measure.bench.synthetic_plate import LENS, uniform_coc_plate
from heatlens.lab.measure.bench.timing import BenchFrames
from heatlens.lab.measure.bench.timing import time_within_limit as bounded_frame
from heatlens.render.defocus.other_methods import gather_steps
from heatlens.render.defocus.scatter_pass import disc_fragments
from heatlens.render.gpu.textures import download

SIZE = (64, 48)
NAMES = [
    *("diffusion", "heat", "gather", "scatter", "pyramid"),
    *("accumulation 23", "accumulation 66", "raytraced 66"),
]
QUICK = ("bench", "--size", "64x48", "--runs", "1", "--quality", "draft")
REPORT = MethodReport(
    width=64,
    height=48,
    limit_s=20.0,
    rows=(
        MethodRow(2.0, {"diffusion": 4.0, "gather 23": 1.0}),
        MethodRow(20.0, {"diffusion": 4.1, "gather 23": 100.0}),
        MethodRow(200.0, {"diffusion": 4.0, "gather 23": None}),
    ),
)


pytestmark = pytest.mark.usefixtures("ctx")


@pytest.mark.usefixtures("ctx")
def test_bench_methods_has_times_errors_and_plot_of_every_method(capsys, monkeypatch, tmp_path):
    monkeypatch.setattr(methods, "METHOD_COC_PX", (2.0, 9.0))
    truth = ("--truth-size", "48x32", "--truth-views", "80", "--views", "4")
    words = (*QUICK, "--methods", *truth, "--json", "--plot", str(tmp_path / "methods.png"))
    assert main(list(words)) == 0
    printed, log = capsys.readouterr()
    assert "this takes about" in log  # a log gets no line for each part
    full_report = json.loads(printed)
    report, errors = full_report["methods"], full_report["method_errors"]
    assert (report["width"], report["height"]) == SIZE
    assert [row["coc_px"] for row in report["rows"]] == [2.0, 9.0]
    for row in report["rows"]:
        assert list(row["ms"]) == list(compared_methods(DefocusSettings(views=4)))
        assert all(math.isfinite(ms) and ms > 0 for ms in row["ms"].values())
    assert (errors["width"], errors["height"], errors["truth_views"]) == (48, 32, 80)
    assert set(errors["rows"][0]["cells"]["gather"]) == {"ms", "flip", "psnr_db", "ssim"}
    with PillowImage.open(tmp_path / "methods.png") as image:
        assert image.format == "PNG"


@pytest.mark.usefixtures("ctx")
def test_bench_without_methods_option_measures_none(capsys):
    quick = ("bench", "--size", "64x48", "--runs", "1")
    assert main([*quick, "--json", "--method", "scatter"]) == 0
    report = json.loads(capsys.readouterr().out)
    assert report["methods"] is None and report["method_errors"] is None
    assert report["frame"]["method"] == "scatter"
    assert [row["name"] for row in report["frame"]["passes"]] == ["coc", "scatter", "limits"]


def test_entrants_include_accumulation_of_requested_23_and_66_views():
    with_five = compared_methods(DefocusSettings(views=5))
    assert [n for n in with_five if n.startswith("acc")] == [
        *("accumulation 5", "accumulation 23", "accumulation 66")
    ]
    assert {n: s.views for n, s in with_five.items()}["raytraced 5"] == 5
    assert list(compared_methods(DefocusSettings())) == NAMES
    assert {s.method for s in with_five.values()} == set(Method)


def test_time_table_is_aligned_and_marks_skipped_cells():
    lines = time_table(REPORT).splitlines()
    assert len({len(line) for line in lines[1:]}) == 1
    assert lines[1].split() == ["px", "diffusion", "gather"]
    assert lines[2].split() == ["23", "views"]
    assert lines[5].split() == ["200", "4.0", "skipped"]


def test_measure_methods_skips_slow_method_from_then_on(ctx, monkeypatch):
    monkeypatch.setattr(methods, "METHOD_COC_PX", (2.0, 9.0))
    monkeypatch.setattr(timing, "LIMIT_S", -1.0)
    messages: list[str] = []
    frames = BenchFrames(ctx, "sweep")
    report = measure_methods(frames, SIZE, DefocusSettings(), 1, messages.append)
    assert all(ms is None for row in report.rows for ms in row.ms.values())
    assert [s for s in messages if s.startswith("gather,")] == ["gather, circle of confusion 2 px"]
    assert sum("gather skipped" in s for s in messages) == 1


def test_bounded_frame_renders_at_most_requested_frames(ctx, monkeypatch):
    frame = BenchFrames(ctx, "sweep").frame(
        uniform_coc_plate(SIZE, 4.0), LENS, DefocusSettings(method=Method.PYRAMID)
    )
    frame.render()
    rendered: list[int] = []
    monkeypatch.setattr(type(frame), "render", lambda self: rendered.append(1))
    assert bounded_frame(frame, 3, 1000.0) is not None and len(rendered) == 3


@pytest.mark.parametrize("diameter_px", [2.0, 200.0])
def test_uniform_coc_scene_has_plate_colors_and_one_coc(ctx, diameter_px):
    renderer = BenchFrames(ctx, "sweep").scene_frame(
        uniform_coc_scene(SIZE, diameter_px), wall_framing(SIZE), LENS, DefocusSettings()
    )
    plate = renderer.renderer.load_pinhole(renderer.shot).plate
    coc = coc_px(plate.depth_m, coc_line(LENS, SIZE[0]))
    assert coc == pytest.approx(-diameter_px, rel=1e-3)
    expected = np.clip(uniform_coc_plate(SIZE, diameter_px).color[..., :3], 0, 1)
    assert np.abs(plate.color[..., :3] - expected).mean() < 0.02


@pytest.mark.parametrize("method", [Method.ACCUMULATION, Method.RAYTRACED])
def test_scene_frames_are_rendered_with_all_views_each_time(ctx, method):
    frame = BenchFrames(ctx, "sweep").scene_frame(
        uniform_coc_scene(SIZE, 9.0), wall_framing(SIZE), LENS, DefocusSettings(method=method)
    )
    first = download(frame.render())
    names = [*frame.steps(), *frame.steps()]
    assert len(names) == 2 * 66 and len(set(names)) == 1  # the pinhole picture is there already
    assert (first[..., :3].min(axis=(0, 1)) > 0.02).all()  # the wall goes on past the frame


def test_gather_and_scatter_work_grows_with_disc_area():
    """Twice the diameter gives four times the work: gathered samples, or fragments of quads."""
    cocs = (50, 100, 200)
    steps = [gather_steps((4096, 4096), (c // 2, c // 2)) for c in cocs]
    rows = [sum(s.disc_last - s.disc_first + 1 for s in e if s.band_start == 0) for e in steps]
    assert all(3.8 < (b / a) ** 2 < 4.1 for a, b in pairwise(rows))
    fragments = [disc_fragments(float(c), DiscShape(), (4096, 4096)) for c in cocs]
    assert all(3.8 < b / a < 4.1 for a, b in pairwise(fragments))
