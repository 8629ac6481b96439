"""Test `heatlens bench`: complete tables and consistent numbers, but not the speed itself."""

import json
import math
import re
from collections.abc import Iterator
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from heatlens.core.base.errors import GpuError
from heatlens.core.model.shot.settings import LAYERS_MAX, Bokeh, DefocusSettings
from heatlens.fronts.commands.main import main
from heatlens.lab.measure.bench import measure
from heatlens.lab.measure.bench.measure import (
    BareSweeps,
    conductances,
    copy_bytes_per_second,
    size_rows,
)
from heatlens.lab.measure.bench.report import BenchReport, report_text
from heatlens.lab.measure.bench.synthetic_plate import (
    LENS,
    lens_with_largest_coc,
    scene_coc_px,
    scene_plate,
    uniform_coc_plate,
)
from heatlens.lab.measure.bench.timing import BenchFrames, frame_seconds, median_seconds
from heatlens.render.defocus.kernels import named_kernel
from heatlens.render.defocus.line_solver import SOLVERS
from heatlens.render.defocus.pass_list import PASSES
from heatlens.render.gpu.device import Limits
from heatlens.render.gpu.textures import download
from support import oracle

SIZE = (64, 48)
HEAT = named_kernel("heat")
PASS_NAMES = {one.name for one in PASSES}
LAYERED_PASSES = PASS_NAMES - {"limits"}  # those are for a frame of one layer


pytestmark = pytest.mark.usefixtures("ctx")


def run_bench(capsys, *words: str) -> str:
    """Return stdout of a bench that must succeed; progress goes to stderr."""
    assert main(["bench", "--size", "64x48", "--runs", "2", *words]) == 0
    captured = capsys.readouterr()
    assert all(line.startswith("heatlens: ") for line in captured.err.splitlines())
    return captured.out


# Layered pictures are limited as they are composited, by the blur where no layer is smaller than
# the picture; the plates of the bench have no alpha, and their proxy is made once. Other methods
# have one pass each.
NOT_HERE = {"composite", "limits", "far parts", "whole parts", "alpha", "colours", "proxy"}
NOT_HERE |= {"near zones", "gather", "scatter", "pyramid"}


def numbers_in(value: object) -> Iterator[float]:
    """Return every number of a JSON value."""
    if isinstance(value, dict | list):
        for inner in value.values() if isinstance(value, dict) else value:
            yield from numbers_in(inner)
    elif isinstance(value, int | float):
        yield value


# The command


def test_bench_json_holds_every_pass_with_finite_numbers(capsys):
    report = json.loads(run_bench(capsys, "--json", "--bare", "--proxy", "0.5"))
    assert {row["name"] for row in report["frame"]["passes"]} == PASS_NAMES - NOT_HERE
    assert all(math.isfinite(number) and number >= 0 for number in numbers_in(report))
    assert (report["frame"]["width"], report["frame"]["height"]) == SIZE
    assert report["frame"]["solver"] in SOLVERS
    assert report["bare"]["ratio"] == pytest.approx(
        report["bare"]["heat_frame_ms"] / report["bare"]["bare_sweeps_ms"]
    )
    assert report["coc_sweep"] is None and report["peak_memory_mb"] > 10


@pytest.mark.parametrize("solver", SOLVERS)
def test_bench_uses_requested_solver(capsys, solver):
    words = ("--solver", solver, "--bokeh", "heat", "--layers", "1", "--json")
    report = json.loads(run_bench(capsys, *words))
    assert report["frame"]["solver"] == solver
    assert [row["name"] for row in report["frame"]["passes"]] == ["coc", "blur", "limits"]
    assert report["frame"]["layer_count"] == 1


def test_bench_text_has_line_per_pass_and_timing_method(capsys):
    text = run_bench(capsys)
    for name in PASS_NAMES - NOT_HERE:
        assert re.search(rf"^{name} +[\d.]+ +\d+ ", text, re.MULTILINE), name
    assert "glFinish" in text or "timer queries" in text
    assert re.search(r"^whole frame [\d.]+ ms; [\d.]+ ms with the stopwatch on$", text, re.M)
    assert re.search(r"^peak memory \d+ MB$", text, re.M)


def test_bench_sweeps_have_ratios_and_skip_too_large_sizes(capsys, monkeypatch, ctx):
    too_wide = ctx.limits.texture_side_px + 1
    monkeypatch.setattr(measure, "SWEEP_COC_PX", (2.0, 9.0))
    monkeypatch.setattr(measure, "SWEEP_SIZES", ((32, 24), (64, 48), (too_wide, 1)))
    assert main(["bench", "--size", "64x48", "--runs", "1", "--sweep-coc", "--json"]) == 0
    captured = capsys.readouterr()
    report = json.loads(captured.out)
    assert [row["coc_px"] for row in report["coc_sweep"]] == [2.0, 9.0]
    for name in ("one_layer_ratio", "layered_ratio", "scene_ratio"):
        assert report["coc_sweep"][0][name] == 1.0
        ms = name.replace("ratio", "ms")
        assert report["coc_sweep"][1][name] == pytest.approx(
            report["coc_sweep"][1][ms] / report["coc_sweep"][0][ms]
        )
    assert [(row["width"], row["height"]) for row in report["size_sweep"]] == [(32, 24), (64, 48)]
    assert f"left out: The plate is {too_wide}x1" in captured.err


def test_bench_text_prints_sweeps(capsys, monkeypatch):
    monkeypatch.setattr(measure, "SWEEP_COC_PX", (2.0,))
    monkeypatch.setattr(measure, "SWEEP_SIZES", ((32, 24),))
    text = run_bench(capsys, "--sweep-coc", "--bare", "--quality", "draft")
    assert re.search(r"^ +2 +[\d.]+ +1\.00 +[\d.]+ +1\.00 +\d +[\d.]+ +1\.00 +\d$", text, re.M)
    assert re.search(r"^32x24 +[\d.]+ +1\.00 +[\d.]+ +1\.00 +\d$", text, re.M)
    assert re.search(r"^heat, one layer: frame .* ratio [\d.]+$", text, re.M)


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--solver", "magic"], "'magic'"),
        (["--size", "big"], "'big' is not a size"),
        (["--size", "0x5"], "'0x5' is not a size"),
        (["--runs", "many"], "'many'"),
    ],
)
def test_bench_parser_rejects_wrong_options(capsys, words, message):
    with pytest.raises(SystemExit) as exit_error:
        main(["bench", *words])
    assert exit_error.value.code == 2
    assert message in capsys.readouterr().err


@pytest.mark.parametrize(
    ("words", "message"),
    [(["--runs", "0"], "--runs"), (["--size", "999999x1"], "999999x1"), (["--layers", "9"], "9")],
)
def test_bench_rejects_values_out_of_range(capsys, words, message):
    assert main(["bench", *words]) == 2
    error = capsys.readouterr().err
    assert message in error and len(error.splitlines()) == 1


# Measurements


def test_frame_seconds_counts_passes_per_layer(ctx):
    frames = BenchFrames(ctx, "sweep")
    settings = DefocusSettings()
    frame = frames.frame(scene_plate(SIZE), lens_with_largest_coc(30.0, SIZE), settings)
    seconds = frame_seconds(frames.stopwatch, 2, frame.render)
    passes = seconds.passes
    assert frame.layer_count > 3
    for name in ("layer split", "coc fill", "blur"):
        assert passes[name].runs == frame.layer_count
    assert passes["coc"].runs == passes["highlights drawn"].runs == 1
    assert min(seconds.stopwatch_off, seconds.stopwatch_on) > 0 and all(
        entry.seconds > 0 for entry in passes.values()
    )
    assert not frames.stopwatch.is_on


def test_median_seconds_alternates_works_after_warm_up(ctx):
    calls: list[str] = []
    seconds = median_seconds(ctx, 2, lambda: calls.append("a"), lambda: calls.append("b"))
    assert calls == ["a", "b"] * 3
    assert len(seconds) == 2 and min(seconds) > 0


def test_copy_rate_is_positive_and_finite(ctx):
    assert 0 < copy_bytes_per_second(ctx, SIZE) < math.inf


@pytest.mark.parametrize("size", [(64, 48), (1, 9), (7, 1)])
def test_bare_sweeps_equal_oracle_and_frame(ctx, size):
    plate, coc = scene_plate(size), scene_coc_px(size)
    bare = BareSweeps(ctx, plate.color, coc)
    bare.run()
    bare_result = download(bare.out)
    bare.release()
    color, coc_px = plate.color.astype(np.float64), coc.astype(np.float64)
    expected_bare = oracle.blur(
        color, coc_px, HEAT, repeats_border=False
    )  # bare: nothing is done beyond the border
    np.testing.assert_allclose(bare_result, expected_bare, rtol=1e-4, atol=1e-5)
    exact = oracle.blur(color, coc_px, HEAT)
    frame = BenchFrames(ctx, "sweep").frame(plate, LENS, DefocusSettings(Bokeh.HEAT, layers=1))
    np.testing.assert_allclose(download(frame.render()), exact, rtol=2e-3, atol=2e-3)


def test_conductances_use_smaller_coc_and_end_with_zero():
    coc = np.array([[2.0, -4.0, 1.0]], np.float32)
    np.testing.assert_allclose(conductances(coc, axis=1), [[4 / 32, 1 / 32, 0.0]])
    np.testing.assert_allclose(conductances(coc.T, axis=0), [[4 / 32], [1 / 32], [0.0]])


def test_bare_sweeps_reject_size_beyond_storage_block():
    small = SimpleNamespace(limits=Limits(1 << 14, 1 << 20, 1024))
    pixels = np.ones((300, 300), np.float32)
    with pytest.raises(GpuError, match="smaller --size"):
        BareSweeps(ctx=small, color=pixels, coc_px=pixels)  # type: ignore[arg-type]


def test_size_rows_give_time_per_pixel_relative_to_first():
    first, second = size_rows([((10, 10), 1.0, 5.0, 2), ((20, 20), 6.0, 20.0, 3)])
    assert (first.one_layer_per_pixel_ratio, first.layered_per_pixel_ratio) == (1.0, 1.0)
    assert second.one_layer_per_pixel_ratio == pytest.approx(1.5)
    assert second.layered_per_pixel_ratio == pytest.approx(1.0)


# The plates


def test_scene_plate_is_reproducible_and_has_several_layers(ctx):
    plate, second_plate = scene_plate((1920, 1080)), scene_plate((1920, 1080))
    np.testing.assert_array_equal(plate.color, second_plate.color)
    np.testing.assert_array_equal(plate.depth_m, second_plate.depth_m)
    assert plate.color.min() >= 0.0 and plate.color.max() > 10.0
    assert np.isinf(plate.depth_m).any() and plate.depth_m.min() == 1.0
    frame = BenchFrames(ctx, "sweep").frame(plate, LENS, DefocusSettings())
    assert 4 <= frame.layer_count <= LAYERS_MAX


@pytest.mark.parametrize("size", [(1, 1), (3, 2), SIZE])
def test_scene_plate_of_any_size_is_finite(size):
    plate = scene_plate(size)
    assert plate.color.shape == (size[1], size[0], 4)
    assert np.isfinite(plate.color).all() and (plate.depth_m > 0).all()


@pytest.mark.parametrize("coc_px", [2.0, 200.0])
def test_lens_with_largest_coc_gives_requested_largest_coc(coc_px):
    lens = lens_with_largest_coc(coc_px, SIZE)
    assert np.abs(scene_coc_px(SIZE, lens)).max() == pytest.approx(coc_px, rel=1e-6)


def test_uniform_coc_plate_has_one_coc():
    plate = uniform_coc_plate(SIZE, 7.0)
    assert plate.depth_m is None and set(plate.coc_px.ravel()) == {7.0}


def test_report_text_for_gpu_names_timer_queries(ctx):
    frames = BenchFrames(ctx, "sweep")
    frame = measure.measure_frame(frames, SIZE, DefocusSettings(), 1, lambda sentence: None)
    on_gpu = BenchReport(replace(frame, is_software=False), None, None, None, 100.0)
    assert "timer queries" in report_text(on_gpu) and "glFinish" not in report_text(on_gpu)
