"""Test `heatlens bench --issues`, which counts the dispatches, draws and barriers of a frame."""

import json
from collections import Counter

import numpy as np
import pytest

from heatlens.core.base.errors import InputError
from heatlens.core.model.lens.aperture import Aperture
from heatlens.core.model.shot.settings import Bokeh, DefocusSettings, Method, Quality
from heatlens.fronts.commands.main import main
from heatlens.lab.measure.bench import issues
from heatlens.lab.measure.bench.issues import measure_issues
from heatlens.lab.measure.bench.synthetic_plate import LENS, scene_plate
from heatlens.lab.measure.bench.timing import BenchFrames
from heatlens.render.defocus.line_solver import SolverName
from heatlens.render.gpu.device import Device
from heatlens.render.gpu.opengl.counting import counting_device

FILM = DefocusSettings(Bokeh.DISC, Quality.FILM)
# A pass that film gains or saves changes these. A layer smaller than the picture needs one more,
# and one layer may be at two sizes.
ISSUES, ISSUES_A_LAYER = 22, 11
DRAWN = 2  # issues without a barrier: highlights are drawn, large ones after the others


def count_issues(ctx: Device, size: tuple[int, int], settings: DefocusSettings = FILM):
    return measure_issues(ctx, size, settings, 1, lambda _: None)


def test_issue_count_does_not_grow_with_picture_size(ctx):
    reports = [count_issues(ctx, (16 * scale, 9 * scale)) for scale in (20, 80, 120, 160)]
    for report in reports:
        extra_issues = report.issues - ISSUES - ISSUES_A_LAYER * report.layer_count
        assert 0 <= extra_issues < ISSUES_A_LAYER + report.layer_count
        assert report.barriers == report.issues - DRAWN
    assert len({report.layer_count for report in reports}) > 1
    assert reports[-2].issues == 79  # at 1920x1080


def test_every_dispatch_is_counted_with_a_barrier(ctx):
    for method in (Method.GATHER, Method.DIFFUSION):
        report = count_issues(ctx, (160, 90), DefocusSettings(method=method))
        assert report.barriers == report.dispatches + report.indirect_dispatches > 0
        barrier_free_issues = report.draws + report.clears
        assert report.issues == report.barriers + barrier_free_issues


def test_frame_creates_at_most_one_aperture(ctx, monkeypatch):
    """A GPU waits for Python, and creating a checked dataclass takes longer than a uniform."""
    created_apertures: list[int] = []
    frames = BenchFrames(ctx, SolverName.SWEEP)
    frame = frames.frame(scene_plate((160, 90)), LENS, FILM)
    frame.render()
    original_check = Aperture.__post_init__
    monkeypatch.setattr(
        Aperture, "__post_init__", lambda it: (created_apertures.append(1), original_check(it))
    )
    frame.render()
    assert len(created_apertures) <= 1


def test_counting_device_draws_nothing_and_keeps_context(ctx):
    target = ctx.simple_framebuffer((4, 4))
    target.clear(0.25, 0.5, 0.75, 1.0)
    pixels_before = target.read()
    renderer = ctx.name
    counts: Counter[str] = Counter()
    counting = counting_device(ctx, counts)
    counting.framebuffer([ctx.texture((4, 4), 4)]).clear(1.0, 1.0, 1.0, 1.0)
    assert counts == {"clear": 1}
    assert ctx.name == renderer != counting.name
    assert not counting.is_software
    np.testing.assert_array_equal(target.read(), pixels_before)


@pytest.mark.parametrize("bytes_per_pixel, python_ms", [(500.0, 1.0), (1.0, 1e4)])
def test_predicted_time_is_maximum_of_python_and_gpu(bytes_per_pixel, python_ms):
    counts = Counter({"dispatch": 10})
    report = issues._report(counts, 3, bytes_per_pixel, python_ms, (1000, 1000))
    for card in issues.CARDS:
        gpu_ms = bytes_per_pixel / card.gb_per_s + 10 * 36.5e-3 + 3 * 11.4 / card.processors
        assert report.predicted_ms[card.name] == pytest.approx(max(gpu_ms, python_ms))


@pytest.mark.parametrize(
    "option", ["--bare", "--sweep-coc", "--methods", "--methods demo", "--solver=sweep"]
)
def test_bench_issues_rejects_other_measurements(capsys, option):
    assert main(["bench", "--issues", *option.split()]) == 2
    refused_option = "--issues" if "demo" in option else option.partition("=")[0]
    assert f"leave {refused_option} out" in capsys.readouterr().err


def test_bench_issues_prints_text_or_json(capsys):
    words = ["bench", "--issues", "--size", "160x90", "--runs", "1"]
    assert main(words) == 0
    assert "predicted at most, not measured" in capsys.readouterr().out
    assert main([*words, "--json"]) == 0
    report = json.loads(capsys.readouterr().out)
    assert {"issues", "python_ms", "bytes_per_pixel"} <= report.keys()


def test_only_calls_of_opengl_are_counted(ctx: Device, monkeypatch):
    monkeypatch.setattr(ctx, "library", "wgpu")
    with pytest.raises(InputError, match="leave --gpu wgpu out"):
        count_issues(ctx, (160, 90))
