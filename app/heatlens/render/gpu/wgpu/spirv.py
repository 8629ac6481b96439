"""Compile the stages of a program to SPIR-V, which puts loose uniforms into one block.

An installed heatlens holds the SPIR-V of all its programs (`fronts/doctor/compiled_shaders.py`).
For other programs glslangValidator must be installed. What it makes is kept in the cache folder.
"""

import hashlib
import shutil
import subprocess
import tempfile
import zipfile
from collections.abc import Sequence
from functools import cache
from io import BytesIO
from pathlib import Path

from heatlens.core.base.errors import GpuError, ShaderError
from heatlens.core.base.paths import compiled_shaders_dir, data_dir, read_file_bytes
from heatlens.core.base.system_packages import shader_compiler_advice
from heatlens.media.files.kept_files import keep_file, read_kept_file
from heatlens.render.gpu.wgpu.translation import StageText

COMPILER = "glslangValidator"
PACKED = "spirv.zip"  # in the folder of shaders
SHADERS_MOST_BYTES = 64 << 20  # in the cache folder; a version has 14 MB if all is drawn
_WORDS = (COMPILER, "-V", "-R", "--auto-map-bindings", "--auto-map-locations")


def compile_stages(stages: Sequence[StageText]) -> list[bytes]:
    """Return the SPIR-V of the stages of one program.

    Raises ShaderError with the compiler's log, and GpuError where the compiler is missing.
    """
    names = module_names(stages)
    found = [_packed_module(one) or _kept_module(one) for one in names]
    modules = [module for module in found if module is not None]
    if len(modules) < len(names):
        modules = _run_compiler(stages)
        for one, module in zip(names, modules, strict=True):
            keep_file(compiled_shaders_dir() / one, module, SHADERS_MOST_BYTES)
    return modules


def module_names(stages: Sequence[StageText]) -> list[str]:
    """Return the names of the files with the SPIR-V of each stage, which hold a hash of all."""
    parts = [" ".join(_WORDS), *(f"{one.stage}\n{one.text}" for one in stages)]
    key = hashlib.sha256("\0".join(parts).encode()).hexdigest()[:32]
    return [f"{key}.{one.stage}.spv" for one in stages]


def has_compiler() -> bool:
    """Return whether programs can be compiled that are not in the package."""
    return shutil.which(COMPILER) is not None


def _packed_module(name: str) -> bytes | None:
    """Return a module that came with heatlens, or None."""
    packed = _packed_modules()
    return packed.read(name) if packed is not None and name in packed.NameToInfo else None


@cache
def _packed_modules() -> zipfile.ZipFile | None:
    """Return the modules that came with heatlens: none with a checkout."""
    file = data_dir("shaders") / PACKED
    return zipfile.ZipFile(BytesIO(read_file_bytes(file))) if file.is_file() else None


def _kept_module(name: str) -> bytes | None:
    """Return a module of the cache folder, or None."""
    return read_kept_file(compiled_shaders_dir() / name)


def _run_compiler(stages: Sequence[StageText]) -> list[bytes]:
    """Run the compiler on the stages, which it also links."""
    with tempfile.TemporaryDirectory(prefix="heatlens_spirv_") as folder:
        for one in stages:
            Path(folder, f"program.{one.stage}").write_text(one.text, encoding="utf-8")
        words = [*_WORDS, *(f"program.{one.stage}" for one in stages)]
        try:
            run = subprocess.run(words, cwd=folder, capture_output=True, text=True, check=False)
        except FileNotFoundError:
            raise GpuError(
                "wgpu needs compiled shaders, which this heatlens was installed without, or their "
                f"compiler {COMPILER}: {shader_compiler_advice()}."
            ) from None
        if run.returncode != 0:
            raise ShaderError(" ".join(run.stdout.split()))
        return [read_file_bytes(Path(folder, f"{one.stage}.spv")) for one in stages]
