"""A pass added to PASSES, the one list of passes, gets scratch memory, costs and shader builds."""

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
from heatlens.render.defocus.scratch import AFTER_THE_PICTURE, Scratch, lifetimes
from heatlens.render.gpu.device import Device
from heatlens.render.gpu.program_versions import combine_variants, without_and_with

WORK = Work((64, 48), named_kernel("heat"), SolverName.SWEEP)
GRAIN = Pass(
    name="grain",
    shaders={
        "grain.comp.glsl": combine_variants(without_and_with("COARSE"), without_and_with("COLORED"))
    },
    traffic=lambda _, runs: Traffic(24.0 * runs, 20.0 * runs),
    writes={"grained": ""},  # in memory of its own
    reads_last=("blurred",),
    private_memory={"noise": "poles"},  # reuses the memory of the texture `poles`
)


@pytest.fixture
def grain(monkeypatch: pytest.MonkeyPatch) -> Iterator[Pass]:
    """Add a pass at the end of the list."""
    monkeypatch.setattr(pass_list, "PASSES", (*pass_list.PASSES, GRAIN))
    yield GRAIN


def test_added_pass_has_declared_memory_lifetimes(ctx: Device, grain: Pass) -> None:
    lifetimes_by_name = lifetimes()
    grained = lifetimes_by_name["grained"]
    assert (grained.first, grained.last) == ("grain", AFTER_THE_PICTURE)
    noise = lifetimes_by_name["noise"]
    assert (noise.memory, noise.first, noise.last) == ("poles", "grain", "grain")
    assert lifetimes_by_name["blurred"].last == "grain"
    scratch = Scratch(ctx)
    noise_texture = scratch.texture("noise", (8, 8), 4)
    with pytest.raises(RuntimeError, match="'poles' still belongs to 'noise'"):
        scratch.texture("poles", (8, 8), 4)
    scratch.end_pass("grain")
    assert scratch.texture("poles", (8, 8), 4) is noise_texture
    scratch.release()


def test_bench_row_of_added_pass_has_its_bytes(grain: Pass) -> None:
    runs, pixels = 3, WORK.size[0] * WORK.size[1]
    row = pass_row("grain", PassSeconds(1e-3, runs), WORK, copy_bytes_per_s=1e9)
    assert (row.bytes_moved, row.bytes_least) == (24 * runs * pixels, 20 * runs * pixels)


def test_doctor_builds_each_variant_of_added_pass(grain: Pass) -> None:
    grain_defines = [defines for name, defines in pass_builds() if name == "grain.comp.glsl"]
    both = {"COARSE": 1, "COLORED": 1}
    assert grain_defines == [{}, {"COLORED": 1}, {"COARSE": 1}, both]


def test_pass_builds_are_unique() -> None:
    builds = [(name, tuple(sorted(defines.items()))) for name, defines in pass_builds()]
    assert len(set(builds)) == len(builds)


def test_pass_builds_cover_every_ifdef_of_shaders() -> None:
    built: dict[str, set[str]] = {}
    for name, defines in pass_builds():
        built.setdefault(name, set()).update(defines)
    for name in shader_names() & built.keys():
        text = (data_dir("shaders") / name).read_text()
        assert set(re.findall(r"^\s*#ifn?def ([A-Z_]+)", text, re.M)) <= built[name], name
