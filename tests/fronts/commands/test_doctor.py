"""Test `heatlens doctor`: it reports no fault on a good machine and finds each kind of fault."""

import json
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from heatlens.core.base.errors import GpuError
from heatlens.core.model.boxes import Box
from heatlens.fronts.commands import doctor as command
from heatlens.fronts.commands.main import main
from heatlens.fronts.doctor import gpu_check, machine_check, picture_check
from heatlens.fronts.doctor.finding import Finding, run_check
from heatlens.fronts.doctor.gpu_check import Gpu
from heatlens.fronts.doctor.solver_check import KERNELS, TOLERANCE, blur_in_float64
from heatlens.media.plate.exr.exr_write import write_exr
from heatlens.render.defocus.kernels import named_kernel
from support import oracle
from support.command_line import ENVIRONMENT
from support.x_server import Screen

TESTS = Path(__file__).resolve().parents[2]
GOLDENS, HIGHLIGHTS = "render/frames/test_golden.py", "render/defocus/test_highlights.py"


def states(findings) -> list[str]:
    return [finding.state for finding in findings]


def test_doctor_reports_all_checks_and_finds_no_fault(capsys, session_context):
    assert main(["doctor"]) == 0
    captured = capsys.readouterr()
    first, *further_lines = captured.err.splitlines()
    assert re.fullmatch(r"heatlens: this takes about \d+ (s|min); Ctrl-C ends it", first)
    longer_pattern = (
        r"heatlens: this takes longer here, about \d+ (s|min) in all"  # on a busy machine
    )
    assert all(re.fullmatch(longer_pattern, line) for line in further_lines)
    lines = captured.out.splitlines()
    assert lines[-1].endswith("no fault found")
    prefixes = [line.split(":")[0].split(maxsplit=1) for line in lines[:-1]]
    assert {name for _, name in prefixes} == set(command._checks())
    assert ["ok", "second", "start"] in [line.split(":")[0].split() for line in lines]
    assert session_context.name in "".join(lines)


def test_doctor_estimates_more_time_on_busy_machine(monkeypatch):
    """The estimate grows with the load of the machine."""
    monkeypatch.setattr(command.os, "sched_getaffinity", lambda _: {0, 1})
    planned = {}
    for load in (0.0, 5.0):
        monkeypatch.setattr(command.os, "getloadavg", lambda load=load: (load, 0.0, 0.0))
        planned[load] = sum(step.seconds for step in command._steps())
    assert planned[5.0] == pytest.approx(3 * planned[0.0])


def test_float64_blur_of_doctor_equals_oracle_of_tests(rng):
    color, coc = rng.random((13, 17, 3)), 30 * rng.random((13, 17)) ** 2
    for name in KERNELS:
        kernel = named_kernel(name)
        expected = oracle.blur(color, coc, kernel)
        np.testing.assert_allclose(blur_in_float64(color, coc, kernel), expected, atol=1e-12)


def test_doctor_finds_wrong_solver(ctx, monkeypatch):
    monkeypatch.setattr(gpu_check, "worst_error", lambda *_: 2 * TOLERANCE)
    assert states(Gpu(lambda: ctx).solvers()) == ["fault"] * 2


def test_doctor_names_shader_that_does_not_compile(ctx, monkeypatch):
    builds = [("defocus/coc.comp.glsl", {}), ("defocus/coc.comp.glsl", {"main": "++"})]
    monkeypatch.setattr(gpu_check, "pass_builds", lambda: builds)
    monkeypatch.setattr(gpu_check, "solver_builds", list)
    words, summary = Gpu(lambda: ctx).shaders()
    assert words.state == summary.state == "fault"
    assert "defocus/coc.comp.glsl" in words.said and summary.said == "1 of 2 builds"


def test_doctor_finds_picture_that_differs_from_stored_one(ctx, monkeypatch):
    picture = picture_check.render_still_life(ctx)
    picture[:10] += 0.1
    monkeypatch.setattr(picture_check, "render_still_life", lambda _: picture)
    (finding,) = picture_check.still_life(ctx)
    assert finding.state == "fault" and finding.details["share_off"] == pytest.approx(10 / 90)
    picture[:] = np.nan
    (finding,) = picture_check.still_life(ctx)
    assert finding.details["share_off"] == 1.0


def test_stored_picture_of_doctor_is_up_to_date(ctx, request):
    """`--update-golden` stores what the program draws now."""
    picture = picture_check.render_still_life(ctx)
    if request.config.getoption("--update-golden"):
        window = Box(0, 0, picture.shape[1], picture.shape[0])
        channels = {name: picture[..., i] for i, name in enumerate("RGB")}
        write_exr(picture_check.stored_path(), channels, window, window, compression="piz")
    assert states(picture_check.still_life(ctx)) == ["ok"]


def test_doctor_notes_driver_without_shader_cache(monkeypatch):
    start = subprocess.run
    quick = ["--method", "heat", "--proxy", "0.1"]  # few shaders, because each start builds all
    monkeypatch.setattr(
        machine_check.subprocess, "run", lambda words, **more: start([*words, *quick], **more)
    )
    monkeypatch.setenv("MESA_SHADER_CACHE_DISABLE", "true")
    (finding,) = machine_check.second_start()
    assert finding.state == "note" and "no shader cache" in finding.said


def test_doctor_reports_failed_second_start_as_fault(monkeypatch, tmp_path):
    monkeypatch.setattr(machine_check, "data_dir", lambda _: tmp_path)
    (finding,) = run_check("second start", machine_check.second_start)
    assert finding.state == "fault" and "still_life.exr is not there" in finding.said


def test_reported_gpu_parts_equal_planned_steps(ctx, monkeypatch):
    builds = [("defocus/coc.comp.glsl", {})]
    monkeypatch.setattr(gpu_check, "pass_builds", lambda: builds)
    monkeypatch.setattr(gpu_check, "solver_builds", lambda: builds)
    reported_parts = []
    gpu = Gpu(lambda: ctx, reported_parts.append)
    list(gpu.shaders()), list(gpu.solvers())
    planned = [step.sentence for step in command._steps()]
    assert reported_parts == [words for words in planned if words[:7] in ("shader ", "solver ")]
    assert [words for words in planned if words not in reported_parts] == list(command._checks())


def test_doctor_reports_missing_package_as_note_or_fault(monkeypatch):
    monkeypatch.setitem(sys.modules, "av", None)
    monkeypatch.setitem(sys.modules, "fileseq", None)
    findings = list(machine_check.packages())
    assert [(f.state, f.said.split()[0].rstrip(":")) for f in findings[:-1]] == [
        ("fault", "fileseq"),
        ("note", "av"),
    ]


def test_doctor_without_opengl_runs_other_checks(capsys, monkeypatch):
    def none_here():
        raise GpuError("No OpenGL 4.3 (none).")

    monkeypatch.setattr(command, "headless_context", none_here)
    monkeypatch.setattr(machine_check, "second_start", lambda: iter(()))  # has a test of its own
    assert main(["doctor", "--json"]) == 1
    report = json.loads(capsys.readouterr().out)
    by_name = {finding["name"]: finding["state"] for finding in report["findings"]}
    assert not report["ok"] and by_name["OpenGL"] == by_name["still life"] == "fault"
    assert by_name["packages"] == by_name["fonts"] == "ok"


def test_exception_in_doctor_check_becomes_fault():
    def breaks():
        yield Finding(name="x", state="ok", said="so far")
        raise ZeroDivisionError("by zero")

    first, second = run_check("x", breaks)
    assert (first.state, second.state) == ("ok", "fault")
    assert second.said == "ZeroDivisionError: by zero"


def test_display_check_works_while_other_context_is_current(ctx, monkeypatch):
    screen = Screen()
    monkeypatch.setenv("DISPLAY", screen.display)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    try:
        (finding,) = run_check("display", machine_check.display)
    finally:
        screen.close()
    assert finding.state == "ok", finding.said
    assert ctx.name in finding.details["renderer"]


def test_display_check_reports_missing_display_as_fault(monkeypatch):
    monkeypatch.setenv("DISPLAY", ":987")
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    (finding,) = run_check("display", machine_check.display)
    assert finding.state == "fault" and ":987" in finding.said
    assert "Traceback" not in finding.said


@pytest.fixture(scope="module")
def second_driver(tmp_path_factory) -> dict[str, str]:
    """Return the environment for OpenGL on Vulkan on the CPU: other compilers, uncleared memory."""
    icds = list(Path("/usr/share/vulkan/icd.d").glob("lvp_icd*.json"))
    assert icds, "apt-get install mesa-vulkan-drivers"
    return ENVIRONMENT | {
        "LIBGL_ALWAYS_SOFTWARE": "1",
        "GALLIUM_DRIVER": "zink",
        "ZINK_INLINE_UNIFORMS": "0",  # Mesa 22.3 keeps loop bounds of an earlier dispatch with it
        "XDG_RUNTIME_DIR": str(tmp_path_factory.mktemp("runtime")),
    }


def test_doctor_finds_no_fault_on_second_driver(second_driver):
    program = (
        "from heatlens.fronts.commands.main import main;"
        "from heatlens.fronts.doctor import machine_check;"
        "machine_check.second_start = lambda: iter(());"  # how a cache fills is not its rendering
        "raise SystemExit(main(['doctor', '--json']))"
    )
    command = [sys.executable, "-c", program]
    run = subprocess.run(command, env=second_driver, capture_output=True, text=True)
    report = json.loads(run.stdout)
    (device,) = (f for f in report["findings"] if f["name"] == "OpenGL")
    assert "zink" in device["details"]["renderer"]
    assert run.returncode == 0, report


def test_golden_and_law_tests_pass_on_second_driver_with_nan_filled_textures(second_driver):
    """Every new texture and buffer is filled with NaN, and the pictures must not change."""
    files = [TESTS / name for name in (GOLDENS, HIGHLIGHTS, "render/frames/test_laws.py")]
    # The other qualities draw with the same programs.
    chosen = ("-k", "not (test_laws and (draft or preview or gaussian))")
    pytest_words = ("-m", "pytest", "-q", "-p", "no:cacheprovider", *chosen)
    command = [sys.executable, *pytest_words, *map(str, files)]
    environment = second_driver | {"HEATLENS_FILL_NAN": "1"}
    run = subprocess.run(command, env=environment, cwd=TESTS.parent, capture_output=True, text=True)
    assert run.returncode == 0, run.stdout[-4000:]
