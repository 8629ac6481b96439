"""Changed shader files reach running programs; a mistake in one keeps the last good program."""

from pathlib import Path

import numpy as np
import pytest

from heatlens.core.base.errors import ShaderError
from heatlens.render.gpu import shader_reload
from heatlens.render.gpu.device import Device
from heatlens.render.gpu.framebuffer import Primitive
from heatlens.render.gpu.program import ComputeProgram, DrawProgram, pixel_groups
from heatlens.render.gpu.shader_reload import EVERY_S, VARIABLE, ShaderReload
from heatlens.render.gpu.textures import download, new_texture
from support.shader_copies import edit_shader_file, reloading_copy

LIMITS, DONE = "defocus/limits.comp.glsl", "scene_gpu/scene_done.vert.glsl"


@pytest.fixture
def shaders(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    return reloading_copy(tmp_path / "shaders", monkeypatch)


class Clock:
    """Seconds that pass when the test says so."""

    def __init__(self) -> None:
        self.now = 0.0

    def __call__(self) -> float:
        return self.now

    def tick(self) -> None:
        self.now += EVERY_S


def run_limits(ctx: Device, program: ComputeProgram) -> float:
    """Run the limits pass on one pixel of value 2.0 and return the result."""
    color_texture = new_texture(ctx, (1, 1), 4)
    color_texture.write(np.full(4, 2.0, np.float32))
    images = {"color_img": color_texture}
    program.dispatch(pixel_groups((1, 1)), images=images, uniforms={"is_opaque": True})
    return float(download(color_texture)[0, 0, 0])


def test_reload_updates_program_of_changed_file(ctx: Device, shaders: Path) -> None:
    clock, program = Clock(), ComputeProgram(ctx, LIMITS)
    program.link()
    reload = ShaderReload(clock)
    edit_shader_file(shaders / LIMITS, "max(color.rgb, 0.0)", "vec3(7.0)")
    assert reload.poll() is None and run_limits(ctx, program) == 2.0  # not looked at again so soon
    clock.tick()
    news = reload.poll()
    assert news is not None and news.programs == 1 and LIMITS in news.message
    assert run_limits(ctx, program) == 7.0
    clock.tick()
    assert reload.poll() is None


def test_reload_reports_mistake_and_keeps_last_good_program(ctx: Device, shaders: Path) -> None:
    clock, program = Clock(), ComputeProgram(ctx, LIMITS)
    program.link()
    reload = ShaderReload(clock)
    edit_shader_file(shaders / LIMITS, "max(color.rgb, 0.0)", "nothing_of_that_name")
    clock.tick()
    news = reload.poll()
    assert news is not None and news.programs == 0
    assert f"{LIMITS}:" in news.message and "nothing_of_that_name" in news.message
    assert run_limits(ctx, program) == 2.0
    edit_shader_file(shaders / LIMITS, "nothing_of_that_name", "vec3(3.0)")
    clock.tick()
    assert reload.poll() is not None and run_limits(ctx, program) == 3.0


def test_reload_follows_included_file_and_reports_missing_one(ctx: Device, shaders: Path) -> None:
    clock, program = Clock(), ComputeProgram(ctx, "defocus/unmix_far.comp.glsl")
    program.link()
    reload = ShaderReload(clock)
    edit_shader_file(shaders / "lib" / "tone.lib.glsl", "0.98", "0.97")
    clock.tick()
    news = reload.poll()
    assert news is not None and news.programs == 1
    (shaders / "lib" / "tone.lib.glsl").unlink()
    edit_shader_file(shaders / "defocus/unmix_far.comp.glsl", "0.1", "0.2")
    clock.tick()
    news = reload.poll()
    assert news is not None and "tone.lib.glsl" in news.message
    with pytest.raises(ShaderError):
        program.rebuild()


def test_vertex_array_draws_with_reloaded_program(ctx: Device, shaders: Path) -> None:
    clock, program = Clock(), DrawProgram(ctx, "display/picture")
    quad, reload = program.vertex_array([]), ShaderReload(clock)
    source, out = new_texture(ctx, (1, 1), 4), ctx.texture((1, 1), 4, dtype="f4")
    source.write(np.ones(4, np.float32))
    target = ctx.framebuffer([out])

    def drawn() -> float:
        target.use()
        ctx.draw_with()
        program.bind(
            textures={"picture_tx": source},
            uniforms={
                "first_px": (0, 0),
                "last_px": (1, 1),
                "screen_px": (1, 1),
                "is_nearest": True,
            },
        )
        quad.render(Primitive.TRIANGLE_STRIP, 4)
        return float(np.frombuffer(out.read(), np.float32)[0])

    assert drawn() == 1.0
    edit_shader_file(
        shaders / "display/picture.frag.glsl",
        "out_color = is_nearest ?",
        "out_color = 5.0 * is_nearest ?",
    )
    clock.tick()
    assert "display/picture.frag.glsl:" in reload.poll().message and drawn() == 1.0  # a mistake
    edit_shader_file(shaders / "display/picture.frag.glsl", "5.0 * is_nearest", "is_nearest")
    edit_shader_file(
        shaders / "display/picture.frag.glsl",
        "texture(picture_tx, texture_uv);",
        "vec4(0.0); out_color *= 5.0;",
    )
    clock.tick()
    assert reload.poll().programs == 1 and drawn() == 5.0
    quad.release()
    program.release()
    source.release()
    ctx.simple_framebuffer((1, 1)).use()
    target.release()


def test_programs_that_were_used_are_built_again(ctx: Device, shaders: Path) -> None:
    used, unused = ComputeProgram(ctx, LIMITS), ComputeProgram(ctx, LIMITS)
    old = used.link()
    shader_reload.rebuild_used()
    assert used.link() is not old and run_limits(ctx, used) == 2.0 and not unused.files
    used.release()


def test_reload_watches_nothing_without_its_variable(
    ctx: Device, shaders: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv(VARIABLE)
    before = len(shader_reload._watched)
    program = ComputeProgram(ctx, LIMITS)
    assert len(shader_reload._watched) == before and not shader_reload.is_on()
    program.release()
