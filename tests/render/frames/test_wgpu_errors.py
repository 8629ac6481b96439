"""What wgpu refuses ends in one sentence, as what OpenGL refuses does."""

import subprocess
import sys
from collections.abc import Callable

import pytest

from heatlens.core.base.errors import FAULT_CODE, GpuError
from heatlens.core.base.paths import data_dir
from heatlens.render import frame_renderer
from heatlens.render.gpu.textures import new_array, new_buffer
from heatlens.render.gpu.wgpu import wgpu_device
from heatlens.render.gpu.wgpu.programs import WgCompute
from support.command_line import ENVIRONMENT, stderr_of_run

_PANIC = """
import sys
from heatlens.fronts.commands.worker_process import run_in_worker
from heatlens.media.files.quiet import protect_output
from heatlens.render.gpu.wgpu import wgpu_device

def give_nothing_for_a_device():
    protect_output()
    wgpu_device.headless_device()
    from wgpu.backends.wgpu_native._ffi import ffi, lib
    lib.wgpuDeviceGetQueue(ffi.NULL)

sys.exit(run_in_worker(give_nothing_for_a_device))
"""


def test_texture_and_buffer_beyond_memory_are_refused_in_the_words_for_opengl():
    device = wgpu_device.headless_device()
    with pytest.raises(GpuError, match=r"^wgpu could not make 256 layers of 16384x16384 \(.*proxy"):
        new_array(device, (16384, 16384), 256, 4)
    with pytest.raises(GpuError, match=r"^wgpu could not make a buffer of 1000000 MB \(.*proxy"):
        new_buffer(device, 10**12)
    device.release()


def lose_device(program: WgCompute) -> None:
    program.shared.device.destroy()


def copy_buffer_to_itself(program: WgCompute) -> None:
    uniforms = program.shared.recorder.uniforms
    program.shared.recorder.encoder().copy_buffer_to_buffer(uniforms, 0, uniforms, 0, 8)


@pytest.mark.parametrize(
    ("mishap", "sentence"),
    [
        (lose_device, "The graphics device was lost"),
        (copy_buffer_to_itself, "wgpu refused to go on: Source and destination"),
    ],
)
def test_mishap_while_drawing_ends_in_one_sentence(
    capsys, monkeypatch, tmp_path, mishap: Callable[[WgCompute], None], sentence: str
):
    run, programs = WgCompute.run, list[WgCompute]()

    def run_until_mishap(program: WgCompute, groups: tuple[int, ...]) -> None:
        programs.append(program)
        if len(programs) == 2:
            mishap(program)
        run(program, groups)

    monkeypatch.setattr(frame_renderer, "headless_context", wgpu_device.headless_device)
    monkeypatch.setattr(WgCompute, "run", run_until_mishap)
    plate, out = data_dir("assets") / "still_life.exr", tmp_path / "out.exr"
    quick = ("--proxy", "0.1", "--method", "gather")
    words = stderr_of_run(capsys, 2, "render", plate, "-o", out, *quick)
    assert words.rpartition("heatlens: ")[2].startswith(sentence) and not out.exists()


def test_panic_of_library_ends_in_one_sentence_of_the_parent():
    words = [sys.executable, "-c", _PANIC]
    run = subprocess.run(words, env=ENVIRONMENT, capture_output=True, text=True, check=False)
    (line,) = run.stderr.splitlines()
    assert run.returncode == FAULT_CODE and "in the graphics driver or in a library" in line
