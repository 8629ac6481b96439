"""Compile the stages of a program to SPIR-V, by glslangValidator, which must be installed.

The compiler puts loose uniforms into one block, and links the stages. What it made is kept in the
user's cache folder.
"""

import hashlib
import subprocess
import tempfile
from collections.abc import Sequence
from pathlib import Path

from heatlens.core.base.errors import GpuError, ShaderError
from heatlens.core.base.paths import compiled_shaders_dir, read_file_bytes
from heatlens.core.base.system_packages import shader_compiler_advice
from heatlens.media.files.atomic_file import write_atomically
from heatlens.render.gpu.wgpu.translation import StageText

COMPILER = "glslangValidator"
_WORDS = (COMPILER, "-V", "-R", "--auto-map-bindings", "--auto-map-locations")


def compile_stages(stages: Sequence[StageText], name: str) -> list[bytes]:
    """Return the SPIR-V of the stages of one program, which is called `name` in messages.

    Raises ShaderError with the compiler's log, and GpuError where the compiler is missing.
    """
    parts = [" ".join(_WORDS), *(f"{one.stage}\n{one.text}" for one in stages)]
    key = hashlib.sha256("\0".join(parts).encode()).hexdigest()[:32]
    files = [compiled_shaders_dir() / f"{key}.{one.stage}.spv" for one in stages]
    if all(file.is_file() for file in files):
        return [read_file_bytes(file) for file in files]
    modules = _run_compiler(stages, name)
    for file, module in zip(files, modules, strict=True):
        file.parent.mkdir(parents=True, exist_ok=True)
        write_atomically(file, module)
    return modules


def _run_compiler(stages: Sequence[StageText], name: str) -> list[bytes]:
    """Run the compiler on the stages, which it also links."""
    with tempfile.TemporaryDirectory(prefix="heatlens_spirv_") as folder:
        for one in stages:
            Path(folder, f"program.{one.stage}").write_text(one.text, encoding="utf-8")
        words = [*_WORDS, *(f"program.{one.stage}" for one in stages)]
        try:
            run = subprocess.run(words, cwd=folder, capture_output=True, text=True, check=False)
        except FileNotFoundError:
            raise GpuError(
                f"wgpu needs the compiler {COMPILER}: {shader_compiler_advice()}."
            ) from None
        if run.returncode != 0:
            raise ShaderError(f"{name}: {' '.join(run.stdout.split())}")
        return [read_file_bytes(Path(folder, f"{one.stage}.spv")) for one in stages]
