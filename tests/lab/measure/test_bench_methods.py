"""`heatlens bench --methods`: a whole table, what is too slow skipped, a plot that is one."""

import json
import math
from itertools import pairwise

import numpy as np
import pytest

from heatlens.core.model.focus.coc import coc_line, coc_px
from heatlens.core.model.lens.disc_shape import DiscShape
from heatlens.core.model.shot.settings import DefocusSettings, Method
from heatlens.fronts.commands.main import main
from heatlens.lab.measure.bench import methods, timing
from heatlens.lab.measure.bench.methods import (
    MethodReport,
    MethodRow,
    entrants,
    measure_methods,
    uniform_coc_scene,
    wall_framing,
)
from heatlens.lab.measure.bench.report import time_table
from heatlens.lab.measure.bench.synthetic_plate import LENS, uniform_coc_plate
from heatlens.lab.measure.bench.timing import BenchFrames
from heatlens.lab.measure.bench.timing import bounded as bounded_frame
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
    64,
    48,
    20.0,
    (
        MethodRow(2.0, {"diffusion": 4.0, "gather 23": 1.0}),
        MethodRow(20.0, {"diffusion": 4.1, "gather 23": 100.0}),
        MethodRow(200.0, {"diffusion": 4.0, "gather 23": None}),
    ),
)


pytestmark = pytest.mark.usefixtures("ctx")


@pytest.fixture
def few_cocs(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(methods, "METHOD_COC_PX", (2.0, 9.0))


@pytest.mark.usefixtures("ctx", "few_cocs")
def test_json_has_every_method_at_every_coc(capsys):
    assert main([*QUICK, "--methods", "--truth-views", "0", "--json"]) == 0
    whole = json.loads(capsys.readouterr().out)
    assert whole["method_errors"] is None
    report = whole["methods"]
    assert (report["width"], report["height"]) == SIZE
    assert [row["coc_px"] for row in report["rows"]] == [2.0, 9.0]
    for row in report["rows"]:
        assert list(row["ms"]) == NAMES
        assert all(math.isfinite(ms) and ms > 0 for ms in row["ms"].values())


@pytest.mark.usefixtures("ctx")
def test_without_being_asked_for_there_are_none(capsys):
    quick = ("bench", "--size", "64x48", "--runs", "1")
    assert main([*quick, "--json", "--method", "scatter"]) == 0
    report = json.loads(capsys.readouterr().out)
    assert report["methods"] is None and report["method_errors"] is None
    assert report["frame"]["method"] == "scatter"
    assert [row["name"] for row in report["frame"]["passes"]] == ["coc", "scatter", "limits"]


def test_accumulation_takes_part_with_the_views_asked_for_and_those_it_is_known_by():
    with_five = entrants(DefocusSettings(views=5))
    assert [n for n in with_five if n.startswith("acc")] == [
        *("accumulation 5", "accumulation 23", "accumulation 66")
    ]
    assert {n: s.views for n, s in with_five.items()}["raytraced 5"] == 5
    assert list(entrants(DefocusSettings())) == NAMES
    assert {s.method for s in with_five.values()} == set(Method)


def test_the_table_is_aligned_and_says_skipped():
    lines = time_table(REPORT).splitlines()
    assert len({len(line) for line in lines[1:]}) == 1
    assert lines[1].split() == ["px", "diffusion", "gather"]
    assert lines[2].split() == ["23", "views"]
    assert lines[5].split() == ["200", "4.0", "skipped"]


def test_a_method_that_takes_too_long_is_given_up_and_left_out_from_there_on(ctx, monkeypatch):
    monkeypatch.setattr(methods, "METHOD_COC_PX", (2.0, 9.0))
    monkeypatch.setattr(timing, "LIMIT_S", -1.0)
    said: list[str] = []
    frames = BenchFrames(ctx, "sweep")
    report = measure_methods(frames, SIZE, DefocusSettings(), 1, said.append)
    assert all(ms is None for row in report.rows for ms in row.ms.values())
    assert [s for s in said if s.startswith("gather,")] == ["gather, circle of confusion 2 px"]
    assert sum("gather skipped" in s for s in said) == 1


def test_where_time_is_short_fewer_frames_are_enough(ctx, monkeypatch):
    frame = BenchFrames(ctx, "sweep").frame(
        uniform_coc_plate(SIZE, 4.0), LENS, DefocusSettings(method=Method.PYRAMID)
    )
    frame.render()
    rendered: list[int] = []
    monkeypatch.setattr(type(frame), "render", lambda self: rendered.append(1))
    assert bounded_frame(frame, 3, 1000.0) is not None and len(rendered) == 3


@pytest.mark.parametrize("diameter_px", [2.0, 200.0])
def test_the_wall_is_the_plates_picture_with_the_same_blur_everywhere(ctx, diameter_px):
    renderer = BenchFrames(ctx, "sweep").scene_frame(
        uniform_coc_scene(SIZE, diameter_px), wall_framing(SIZE), LENS, DefocusSettings()
    )
    plate = renderer.renderer.look(renderer.shot).plate
    coc = coc_px(plate.depth_m, coc_line(LENS, SIZE[0]))
    assert coc == pytest.approx(-diameter_px, rel=1e-3)
    shown = np.clip(uniform_coc_plate(SIZE, diameter_px).color[..., :3], 0, 1)
    assert np.abs(plate.color[..., :3] - shown).mean() < 0.02


@pytest.mark.parametrize("method", [Method.ACCUMULATION, Method.RAYTRACED])
def test_every_frame_of_a_scene_takes_all_points_of_the_lens_anew(ctx, monkeypatch, method):
    frame = BenchFrames(ctx, "sweep").scene_frame(
        uniform_coc_scene(SIZE, 9.0), wall_framing(SIZE), LENS, DefocusSettings(method=method)
    )
    first = download(frame.render())
    names: list[str] = []
    monkeypatch.setattr(
        type(frame.renderer), "render", lambda self, shot: names.extend(self.steps(shot))
    )
    frame.render()
    frame.render()
    assert len(names) == 2 * 66 and len(set(names)) == 1  # the pinhole picture is there already
    assert (first[..., :3].min(axis=(0, 1)) > 0.02).all()  # the wall goes on past the frame


def test_work_grows_with_the_area_for_gather_and_scatter():
    """Twice the diameter, four times the work: rows times as many columns, quads of both sides."""
    cocs = (50, 100, 200)
    steps = [gather_steps((4096, 4096), (c // 2, c // 2)) for c in cocs]
    rows = [sum(s.disc_last - s.disc_first + 1 for s in e if s.band_start == 0) for e in steps]
    assert all(3.8 < (b / a) ** 2 < 4.1 for a, b in pairwise(rows))
    fragments = [disc_fragments(float(c), DiscShape(), (4096, 4096)) for c in cocs]
    assert all(3.8 < b / a < 4.1 for a, b in pairwise(fragments))
