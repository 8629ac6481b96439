"""Every shader, in every build the program makes of it, passes the reference GLSL compiler.

Mesa is lenient; drivers of real GPUs are not. The compiler is Debian's package glslang-tools.
"""

import re
import shutil
import subprocess
from pathlib import Path

import pytest

from heatlens.core.base.paths import data_dir
from heatlens.core.model.view.overlays import overlays_by_name
from heatlens.fronts.doctor.gpu_check import pass_builds, solver_builds
from heatlens.render.gpu.shader_source import assemble

SHADERS = data_dir("shaders")


def test_overlay_shader_has_function_of_every_overlay() -> None:
    text = (SHADERS / "display/overlay.comp.glsl").read_text()
    functions = re.findall(r"^vec4 (\w+)\(ivec2 at, float", text, re.M)
    assert sorted(functions) == sorted(it.function for it in overlays_by_name().values())


def test_no_shader_finds_nan_or_infinity_by_arithmetic() -> None:
    """Metal's compiler takes both for impossible: `lib/finite.lib.glsl` looks at their bits."""
    files = list(SHADERS.rglob("*.glsl"))
    asking = [it.name for it in files if re.search(r"\bis(nan|inf)\s*\(", it.read_text("utf-8"))]
    assert files and asking == []


@pytest.mark.parametrize("builds", [solver_builds(), pass_builds()], ids=["solvers", "passes"])
def test_reference_compiler_accepts_every_build(builds: list, tmp_path: Path) -> None:
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
        assert f"ERROR: {file}" not in run.stdout, (name, defines, source.explain_log(run.stdout))
    assert run.returncode == 0, run.stdout
    assert len(by_file) > 10
