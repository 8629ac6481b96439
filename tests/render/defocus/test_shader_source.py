"""Assembled shader sources: includes, defines, constants and line numbers of driver logs."""

import json
import re
import subprocess
import sys
from pathlib import Path

import pytest

from heatlens.core.base.errors import ShaderError
from heatlens.core.base.paths import data_dir
from heatlens.core.model.shot.settings import LAYERS_MAX
from heatlens.core.model.view.overlays import OVERLAYS, overlay_of
from heatlens.fronts.doctor.gpu_check import shader_names
from heatlens.render.gpu import shader_constants
from heatlens.render.gpu.device import Device
from heatlens.render.gpu.program import ComputeProgram
from heatlens.render.gpu.shader_source import assemble
from support.command_line import ENVIRONMENT

_EVERY_TEXT = """
import json
from hashlib import sha256
from heatlens.media.color.view_transform import srgb_transform
from heatlens.fronts.doctor.gpu_check import pass_builds, solver_builds
from heatlens.render.gpu.shader_source import assemble
from heatlens.core.base.paths import data_dir
texts = [(name, defines, assemble(data_dir("shaders"), name, defines).text)
         for name, defines in solver_builds() + pass_builds()]
texts.append(("sRGB", {}, srgb_transform().glsl))
print(json.dumps([[name, defines, sha256(text.encode()).hexdigest()]
                  for name, defines, text in texts]))
"""


def write_shaders(folder: Path, **files: str) -> None:
    for name, text in files.items():
        (folder / f"{name}.glsl").write_text(text)


def test_assemble_includes_file_in_place_and_once(tmp_path: Path) -> None:
    write_shaders(tmp_path, a='first\n#include "b.glsl"\n#include "b.glsl"\nlast\n', b="inside\n")
    text = assemble(tmp_path, "a.glsl").text
    assert text.count("inside") == 1
    assert text.index("first") < text.index("inside") < text.index("last")


def test_assemble_includes_file_named_by_define(tmp_path: Path) -> None:
    write_shaders(tmp_path, a="#include SYSTEM\n", b="inside\n")
    assert "inside" in assemble(tmp_path, "a.glsl", {"SYSTEM": "b.glsl"}).text


def test_assemble_puts_defines_after_version(tmp_path: Path) -> None:
    write_shaders(tmp_path, a="body\n")
    lines = assemble(tmp_path, "a.glsl", {"POLES": 4}).text.splitlines()
    assert lines[:2] == ["#version 430 core", "#define POLES 4"]


def test_explain_log_maps_lines_to_files(tmp_path: Path) -> None:
    write_shaders(tmp_path, a='one\n#include "b.glsl"\nthree\n', b="x\ny\n")
    source = assemble(tmp_path, "a.glsl")
    assert source.explain_log("0:10002(3): error: no") == "b.glsl:2(3): error: no"
    assert source.explain_log("0:3(1): error: no") == "a.glsl:3(1): error: no"
    assert (
        source.explain_log("0(10002) : error C7586: no") == "b.glsl:2 : error C7586: no"
    )  # NVIDIA
    assert "#line 3" in source.text


def test_assemble_counts_repeated_include_as_a_line(tmp_path: Path) -> None:
    write_shaders(tmp_path, a='#include "b.glsl"\n#include "b.glsl"\nlast\n', b="inside\n")
    assert assemble(tmp_path, "a.glsl").text.endswith("#line 3\nlast\n")


def test_assemble_defines_only_constants_in_use(tmp_path: Path) -> None:
    write_shaders(
        tmp_path, a='#include "b.glsl"\n', b="float side = TILE; vec3 color = OVERLAY_NEAR;\n"
    )
    defines = assemble(tmp_path, "a.glsl").text.split("#line", 1)[0].splitlines()[1:]
    near = ", ".join(map(str, next(overlay_of("zones").tints())))
    assert sorted(defines) == [
        f"#define OVERLAY_NEAR vec3({near})",
        f"#define TILE {shader_constants.TILE}",
    ]


def test_assemble_prefers_given_define_over_constant(tmp_path: Path) -> None:
    write_shaders(tmp_path, a="float side = TILE;\n")
    text = assemble(tmp_path, "a.glsl", {"TILE": 7}).text
    assert "#define TILE 7\n" in text and text.count("#define") == 1


def test_shader_texts_do_not_depend_on_hash_seed() -> None:
    """Check two hash seeds: a driver's cache of compiled shaders needs the same text each time."""
    command = [sys.executable, "-c", _EVERY_TEXT]
    first, second = (
        subprocess.check_output(command, text=True, env=ENVIRONMENT | {"PYTHONHASHSEED": seed})
        for seed in "12"
    )
    assert json.loads(first) == json.loads(second)
    built = {name for name, _, _ in json.loads(first)}
    assert built >= shader_names()


def test_shader_files_do_not_redefine_constants() -> None:
    paths = sorted(data_dir("shaders").rglob("*.glsl"))
    assert len(paths) > 50
    tints = (name for overlay in OVERLAYS for name in overlay.colors)
    constants = {*shader_constants.SHADER_CONSTANTS, *tints}
    for path in paths:
        defined = re.findall(r"^\s*#define\s+(\w+)", path.read_text(), re.M)
        assert not set(defined) & constants, path.name


def test_comment_after_an_include_lists_names_that_the_file_uses() -> None:
    folder = data_dir("shaders")
    for path in folder.rglob("*.glsl"):
        text = path.read_text()
        words = set(re.findall(r"\w+", re.sub(r"//.*", "", text)))
        for file, names in re.findall(r'^#include "(\S+)"  // (?!for )([^.\n]+)', text, re.M):
            included = assemble(folder, file).text
            for name in names.rstrip(" ").split(", "):
                assert name in words and re.search(rf"\b{name}\b", included), (path.name, name)


def test_derived_constants_match_their_sources() -> None:
    assert len(list(overlay_of("layers").tints())) == LAYERS_MAX + 1
    growth = 2**shader_constants.SCATTER_GROWTH_LOG2
    assert growth == pytest.approx(shader_constants.SCATTER_GROWTH, rel=1e-6)


def test_assemble_error_names_missing_include(tmp_path: Path) -> None:
    write_shaders(tmp_path, a='#include "gone.glsl"\n')
    with pytest.raises(ShaderError, match=r"gone\.glsl"):
        assemble(tmp_path, "a.glsl")


def test_compile_error_names_file_and_line(
    ctx: Device, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    write_shaders(tmp_path, a='layout(local_size_x = 1) in;\n#include "b.glsl"\nvoid main() {}\n')
    write_shaders(tmp_path, b="\nfloat f() { return nothing_of_that_name; }\n")
    monkeypatch.setattr("heatlens.render.gpu.program.data_dir", lambda _: tmp_path)
    with pytest.raises(ShaderError, match=r"b\.glsl:2"):
        ComputeProgram(ctx, "a.glsl").link()
