"""Every shader, in every build the program makes of it, passes the reference GLSL compiler.

Mesa is lenient; drivers of real GPUs are not. The compiler is Debian's package glslang-tools.
"""

import itertools
import re
import shutil
import subprocess
from pathlib import Path

import pytest

from heatlens.display import overlay_pass
from heatlens.gpu.shader_source import assemble
from heatlens.model.view import Overlay
from heatlens.paths import data_dir

SHADERS = data_dir("shaders")
OVERLAY = "overlay.comp.glsl"
SYSTEMS = {"lib/blur_system.lib.glsl": (1, 2, 5), "lib/fill_system.lib.glsl": (1,)}
STRATEGIES = {
    "solve_sweep.comp.glsl": [{"LINES_PER_GROUP": 8, "BLOCK": 8, "STRIPS": 1}],
    "solve_partition.comp.glsl": [{"LINES_PER_GROUP": 2, "RUNS": 256, "RUN": 8}],
    "solve_cyclic.comp.glsl": [{"STAGE": s} for s in ("LOAD", "REDUCE", "SUBSTITUTE", "STORE")],
}


def solver_builds() -> list[tuple[str, dict[str, object]]]:
    builds: list[tuple[str, dict[str, object]]] = []
    for (system, poles), rows in itertools.product(SYSTEMS.items(), (True, False)):
        for count, half in itertools.product(poles, (True, False)):
            defines = {"SYSTEM": system, "POLES": count, "COMPLEX": int(count > 1)}
            defines |= {"ROWS": 1} if rows else {}
            defines |= {"HALF_POLES": 1} if half else {}
            for name, variants in STRATEGIES.items():
                builds += [(name, defines | variant) for variant in variants]
    return builds


def pass_builds() -> list[tuple[str, dict[str, object]]]:
    names = [f.name for f in sorted(SHADERS.glob("*.glsl")) if f.name not in STRATEGIES]
    builds = [(name, {}) for name in names] + [
        (name, {"COUNT": 1}) for name in ("highlight_sprites.comp.glsl", "scatter_sort.comp.glsl")
    ]
    builds += [(OVERLAY, {"MODE": mode}) for mode in overlay_modes()]
    return builds + [
        (name, dict.fromkeys(chosen, 1))
        for name, _ in builds
        for count in (1, 2, 3)
        for chosen in itertools.combinations(("HOLES", "COLORS", "BUMPS"), count)
        if all(word in whole_text(name) for word in chosen)
    ]


def whole_text(name: str) -> str:
    """Of a shader and of all that it includes."""
    return "".join((SHADERS / file).read_text() for file in assemble(SHADERS, name, {}).files)


def overlay_modes() -> list[str]:
    return re.findall(r"^vec4 (\w+)\(ivec2 at, float", (SHADERS / OVERLAY).read_text(), re.M)


def test_every_overlay_has_its_build() -> None:
    assert sorted(overlay_modes()) == sorted(overlay_pass._MODES.values())
    assert set(overlay_pass._MODES) | {Overlay.NONE} == set(Overlay)


@pytest.mark.parametrize("builds", [solver_builds(), pass_builds()], ids=["solvers", "passes"])
def test_reference_compiler_takes_it(builds: list, tmp_path: Path) -> None:
    assert shutil.which("glslangValidator"), "apt-get install glslang-tools"
    by_file = {}
    for number, (name, defines) in enumerate(builds):
        stage = name.split(".")[1]
        file = tmp_path / f"{number}.{stage}"
        source = assemble(SHADERS, name, defines)
        file.write_text(source.text)
        by_file[str(file)] = (name, defines, source)
    run = subprocess.run(["glslangValidator", *by_file], capture_output=True, text=True)
    for file, (name, defines, source) in by_file.items():
        assert f"ERROR: {file}" not in run.stdout, (name, defines, source.explained(run.stdout))
    assert run.returncode == 0, run.stdout
    assert len(by_file) > 10
