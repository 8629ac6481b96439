"""Inputs of shader programs by name: misspelled or missing ones are errors, unused ones are not."""

from pathlib import Path

import numpy as np
import pytest

from heatlens.core.base.errors import ShaderError
from heatlens.render.gpu.device import Device
from heatlens.render.gpu.opengl.programs import STRICT_VARIABLE
from heatlens.render.gpu.program import ComputeProgram, DrawProgram, programs_built
from heatlens.render.gpu.shader_source import kinds_in
from heatlens.render.gpu.textures import download, new_array, new_texture

SCALE = """layout(local_size_x = 1) in;
// uniform float commented_out;
#include "lib/unused.glsl"
uniform sampler2D in_tx;
uniform float factor, offset;
uniform float gains[2];
layout(std430) readonly buffer more_block { float more[]; };
layout(std430) readonly buffer summand_block { float summand[]; };
#ifdef NEVER
uniform float only_in_another_build;
#endif
layout(r32f) uniform writeonly image2D out_img;
void main() {
    float x = texelFetch(in_tx, ivec2(0), 0).r;
    imageStore(out_img, ivec2(0), vec4(gains[1] * factor * x + offset + summand[0] + more[0]));
}
"""
VERTEX = """uniform float side;
void main() { gl_Position = vec4(side * vec2(gl_VertexID % 2, gl_VertexID / 2), 0.0, 1.0); }
"""
FRAGMENT = """uniform float red;
out vec4 color;
void main() { color = vec4(red); }
"""


IMAGES = """layout(local_size_x = 1) in;
layout(rgba32f) uniform writeonly image2D FLAT;
layout(rgba32f) uniform writeonly image2DArray LAYERED;
void main() {
    imageStore(FLAT, ivec2(0), vec4(1.0));
    imageStore(LAYERED, ivec3(0, 0, 1), vec4(2.0));
}
"""


@pytest.fixture
def shaders(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    (tmp_path / "lib").mkdir()
    (tmp_path / "lib" / "unused.glsl").write_text("uniform float unused;\n")
    (tmp_path / "scale.comp.glsl").write_text(SCALE)
    (tmp_path / "spot.vert.glsl").write_text(VERTEX)
    (tmp_path / "spot.frag.glsl").write_text(FRAGMENT)
    monkeypatch.setattr("heatlens.render.gpu.program.data_dir", lambda _: tmp_path)
    return tmp_path


class Scale:
    """The shader SCALE with all its inputs, which a test can remove or misspell one by one."""

    def __init__(self, ctx: Device) -> None:
        self.program = ComputeProgram(ctx, "scale.comp.glsl")
        self.out = new_texture(ctx, (1, 1), 1)
        source = new_texture(ctx, (1, 1), 1)
        source.write(np.float32([5.0]))
        buffers = [ctx.buffer(np.float32([number])) for number in (100.0, 1000.0)]
        self.inputs = {
            "textures": {"in_tx": source},
            "images": {"out_img": self.out},
            "buffers": dict(zip(("summand_block", "more_block"), buffers, strict=True)),
            "uniforms": {"factor": 2.0, "offset": 0.5, "gains": [0.0, 3.0]},
        }

    def result(self) -> float:
        self.program.dispatch((1, 1), **self.inputs)
        return float(download(self.out)[0, 0])


def test_dispatch_passes_inputs_by_name(ctx: Device, shaders: Path) -> None:
    assert Scale(ctx).result() == 3.0 * 2.0 * 5.0 + 0.5 + 100.0 + 1000.0


@pytest.mark.parametrize(
    ("kind", "right", "wrong"),
    [
        ("textures", "in_tx", "inn_tx"),
        ("images", "out_img", "out_image"),
        ("buffers", "more_block", "moer_block"),
        ("uniforms", "factor", "fcator"),
    ],
)
def test_dispatch_with_misspelled_name_suggests_right_one(
    ctx: Device, shaders: Path, kind: str, right: str, wrong: str
) -> None:
    scale = Scale(ctx)
    scale.inputs[kind][wrong] = scale.inputs[kind].pop(right)
    with pytest.raises(ShaderError, match=rf"scale\.comp\.glsl: .*'{wrong}'.*'{right}'"):
        scale.result()


def test_dispatch_rejects_sampler_given_as_uniform(ctx: Device, shaders: Path) -> None:
    scale = Scale(ctx)
    scale.inputs["uniforms"]["in_tx"] = 0
    with pytest.raises(ShaderError, match="'in_tx' is declared as a sampler, not as a uniform"):
        scale.result()


def test_dispatch_rejects_name_declared_only_in_comment(ctx: Device, shaders: Path) -> None:
    scale = Scale(ctx)
    scale.inputs["uniforms"]["commented_out"] = 0
    with pytest.raises(ShaderError, match="'commented_out'"):
        scale.result()


@pytest.mark.parametrize("name", ["unused", "only_in_another_build"])
def test_dispatch_accepts_name_that_compiler_removed(ctx: Device, shaders: Path, name: str) -> None:
    scale = Scale(ctx)
    scale.inputs["uniforms"][name] = 1.0
    assert scale.result() == 1130.5


@pytest.mark.usefixtures("of_opengl")
@pytest.mark.parametrize(
    ("kind", "name"),
    [
        ("textures", "in_tx"),
        ("images", "out_img"),
        ("buffers", "more_block"),
        ("uniforms", "offset"),
        ("uniforms", "gains"),
    ],
)
def test_dispatch_in_strict_mode_rejects_missing_input(
    ctx: Device, shaders: Path, kind: str, name: str
) -> None:
    scale = Scale(ctx)
    del scale.inputs[kind][name]
    with pytest.raises(ShaderError, match=rf"scale\.comp\.glsl: .*never given: {name}\."):
        scale.result()


class CountingProgram:
    """A linked program that counts how often a uniform is set."""

    def __init__(self, linked: object) -> None:
        self.linked, self.count = linked, 0

    def __setitem__(self, name: str, value: object) -> None:
        self.count += 1
        self.linked[name] = value


@pytest.mark.usefixtures("of_opengl")
def test_dispatch_sets_only_changed_uniforms(ctx: Device, shaders: Path) -> None:
    scale = Scale(ctx)
    uniforms, linked = scale.inputs["uniforms"], scale.program.link()
    uniforms["gains"] = (0.0, 3.0)
    counting = linked.raw = CountingProgram(linked.raw)
    assert scale.result() == scale.result() == 1130.5
    assert counting.count == 3
    uniforms["factor"] = 4.0
    assert scale.result() == 1160.5 and counting.count == 4
    uniforms["gains"] = [0.0, 1.0]
    assert scale.result() == 1120.5
    uniforms["gains"][1] = 2.0  # in place, as only a list can be
    assert scale.result() == 1140.5


def test_version_is_kept_and_built_on_first_use(ctx: Device, shaders: Path) -> None:
    program, built = ComputeProgram(ctx, "scale.comp.glsl", {"A": 1}), programs_built()
    version = program.version(B=True, C=2, D=False)
    assert version is program.version(C=2, B=1) and version is not program.version(B=True)
    assert program.version(D=False) is program
    assert programs_built() == built
    assert version.link() is version.link() and programs_built() == built + 1
    program.release()
    assert program.version(C=2, B=True) is not version


@pytest.mark.usefixtures("of_opengl")
def test_dispatch_keeps_uniforms_but_needs_textures_each_time(ctx: Device, shaders: Path) -> None:
    scale = Scale(ctx)
    first = scale.result()
    scale.inputs["uniforms"] = {}
    assert scale.result() == first
    scale.inputs["textures"] = {}
    with pytest.raises(ShaderError, match=r"never given: in_tx\."):
        scale.result()


def test_dispatch_without_strict_mode_accepts_missing_input(
    ctx: Device, shaders: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv(STRICT_VARIABLE)
    scale = Scale(ctx)
    del scale.inputs["uniforms"]["factor"]
    assert scale.result() == 1100.5


@pytest.mark.usefixtures("of_opengl")
def test_draw_program_binds_inputs_of_both_shaders(ctx: Device, shaders: Path) -> None:
    program = DrawProgram(ctx, "spot")
    with pytest.raises(ShaderError, match=r"spot\.vert\.glsl and spot\.frag\.glsl: .*'red'"):
        program.bind(uniforms={"side": 1.0, "rde": 1.0})
    with pytest.raises(ShaderError, match=r"never given: red\."):
        program.bind(uniforms={"side": 1.0})
    program.bind(uniforms={"side": 1.0, "red": 1.0})


def test_draw_program_error_names_refused_shader(ctx: Device, shaders: Path) -> None:
    (shaders / "spot.vert.glsl").write_text("void main() { gl_Position = nothing; }\n")
    with pytest.raises(ShaderError, match=r"^spot\.vert\.glsl: [\s\S]*spot\.vert\.glsl:1"):
        DrawProgram(ctx, "spot").link()


def test_kinds_in_finds_declarations_of_all_kinds() -> None:
    text = """
    layout(rgba32ui) uniform writeonly uimage2DArray a_img;
    writeonly uniform image2D b_img;
    uniform highp sampler2DShadow c_tx;
    uniform mat3 d , e[2 * 3],
        f;
    layout(std430) buffer g_block { vec4 g[]; } name_of_instance;
    """
    assert kinds_in(text) == {
        "a_img": "image",
        "b_img": "image",
        "c_tx": "sampler",
        "d": "uniform",
        "e": "uniform",
        "f": "uniform",
        "g_block": "storage block",
    }


@pytest.mark.parametrize(("flat", "layered"), [("a_img", "b_img"), ("b_img", "a_img")])
def test_dispatch_writes_image_and_image_array_in_any_order(
    ctx: Device, shaders: Path, flat: str, layered: str
) -> None:
    text = IMAGES.replace("FLAT", flat).replace("LAYERED", layered)
    (shaders / "images.comp.glsl").write_text(text)
    image, array = new_texture(ctx, (1, 1), 4), new_array(ctx, (1, 1), 2, 4)
    for texture, values in ((image, 4), (array, 8)):
        texture.write(bytes(4 * values))
    program = ComputeProgram(ctx, "images.comp.glsl")
    program.dispatch((1, 1), images={flat: image, layered: array})
    layers = np.frombuffer(array.read(), np.float32).reshape(2, 4)
    assert np.all(download(image) == 1.0) and layers.tolist() == [[0.0] * 4, [2.0] * 4]


@pytest.mark.usefixtures("of_opengl")
def test_compute_program_refuses_two_image_arrays(ctx: Device, shaders: Path) -> None:
    text = IMAGES.replace("FLAT, ivec2(0)", "FLAT, ivec3(0)").replace("image2D ", "image2DArray ")
    (shaders / "images.comp.glsl").write_text(text)
    with pytest.raises(ShaderError, match=r"images\.comp\.glsl: two arrays of images"):
        ComputeProgram(ctx, "images.comp.glsl").link()
