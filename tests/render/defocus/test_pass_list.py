"""A pass is declared in one place: one that is added there has memory, costs and builds."""

import re
from collections.abc import Iterator

import pytest

from heatlens.core.base.paths import data_dir
from heatlens.fronts.doctor.gpu_check import pass_builds, shader_names
from heatlens.lab.measure.bench.measure import pass_row
from heatlens.lab.measure.bench.timing import PassSeconds
from heatlens.render.defocus import pass_list
from heatlens.render.defocus.kernels import named_kernel
from heatlens.render.defocus.line_solver import SolverName
from heatlens.render.defocus.pass_costs import Traffic, Work
from heatlens.render.defocus.pass_list import Pass
from heatlens.render.defocus.scratch import Scratch, lifetimes
from heatlens.render.gpu.device import Device
from heatlens.render.gpu.program_versions import crossed, either

WORK = Work((64, 48), named_kernel("heat"), SolverName.SWEEP)
GRAIN = Pass(
    "grain",
    {"grain.comp.glsl": crossed(either("COARSE"), either("COLORED"))},
    lambda _, runs: Traffic(24.0 * runs, 20.0 * runs),
    {"grained": ""},
    ("blurred",),
    {"noise": "poles"},
)


@pytest.fixture
def grain(monkeypatch: pytest.MonkeyPatch) -> Iterator[Pass]:
    """Add a pass at the end of the list."""
    monkeypatch.setattr(pass_list, "PASSES", (*pass_list.PASSES, GRAIN))
    yield GRAIN


def test_its_memory_lives_as_it_declares(ctx: Device, grain: Pass) -> None:
    lives = lifetimes()
    assert (lives["grained"].first, lives["grained"].last) == ("grain", "")
    noise = lives["noise"]
    assert (noise.memory, noise.first, noise.last) == ("poles", "grain", "grain")
    assert lives["blurred"].last == "grain"
    scratch = Scratch(ctx)
    held = scratch.texture("noise", (8, 8), 4)
    with pytest.raises(RuntimeError, match="'poles' still belongs to 'noise'"):
        scratch.texture("poles", (8, 8), 4)
    scratch.passed("grain")
    assert scratch.texture("poles", (8, 8), 4) is held
    scratch.release()


def test_bench_tells_its_bytes(grain: Pass) -> None:
    row = pass_row("grain", PassSeconds(1e-3, 3), WORK, 1e9)
    assert (row.bytes_moved, row.bytes_least) == (3 * 24 * 64 * 48, 3 * 20 * 64 * 48)


def test_doctor_builds_each_of_its_variants(grain: Pass) -> None:
    found = [defines for name, defines in pass_builds() if name == "grain.comp.glsl"]
    both = {"COARSE": 1, "COLORED": 1}
    assert found == [{}, {"COLORED": 1}, {"COARSE": 1}, both]


def test_no_build_is_made_twice() -> None:
    builds = [(name, tuple(sorted(defines.items()))) for name, defines in pass_builds()]
    assert len(set(builds)) == len(builds)


def test_every_define_that_a_shader_asks_for_itself_is_in_a_build() -> None:
    built: dict[str, set[str]] = {}
    for name, defines in pass_builds():
        built.setdefault(name, set()).update(defines)
    for name in shader_names() & built.keys():
        text = (data_dir("shaders") / name).read_text()
        assert set(re.findall(r"^\s*#ifn?def ([A-Z_]+)", text, re.M)) <= built[name], name
