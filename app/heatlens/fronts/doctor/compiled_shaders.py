"""Compile the programs of all builds to SPIR-V, when a wheel or an sdist is made.

So whoever installs heatlens needs no compiler to draw by wgpu.
"""

import zipfile
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from io import BytesIO

from heatlens.fronts.doctor.gpu_check import pass_builds, solver_builds, sources_of
from heatlens.render.gpu.wgpu.spirv import compile_stages, module_names
from heatlens.render.gpu.wgpu.translation import StageText, formatless_images, translate_stages

# Formats of the pictures that are given for an image without one.
_FORMATS = ("rgba8", "rgba16f", "rgba32f")


def packed_shaders() -> bytes:
    """Return a zip archive with all modules, which is the same whenever it is made."""
    programs = list(_programs())
    with ThreadPoolExecutor() as pool:
        compiled = pool.map(compile_stages, programs)
        modules = dict(
            pair
            for stages, made in zip(programs, compiled, strict=True)
            for pair in zip(module_names(stages), made, strict=True)
        )
    content = BytesIO()
    with zipfile.ZipFile(content, "w") as archive:
        for name, module in sorted(modules.items()):
            archive.writestr(zipfile.ZipInfo(name), module, zipfile.ZIP_LZMA)
    return content.getvalue()


def _programs() -> Iterator[Sequence[StageText]]:
    """Yield the stages of every program, once for each format of an image without one."""
    for build in solver_builds() + pass_builds():
        for sources in sources_of(build):
            formatless = [name for one in sources.values() for name in formatless_images(one)]
            for format_ in _FORMATS if formatless else _FORMATS[:1]:
                yield translate_stages(sources, dict.fromkeys(formatless, format_))
