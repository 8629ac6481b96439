"""Check OpenGL: its version and limits, the build of every shader, and the line solvers."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field

import moderngl

from heatlens.base.errors import GpuError, ShaderError
from heatlens.base.paths import data_dir
from heatlens.color.view_transform import srgb_transform
from heatlens.defocus.line_solver import SOLVERS
from heatlens.doctor.finding import Finding
from heatlens.doctor.shader_builds import Build, pass_builds, solver_builds
from heatlens.doctor.solver_check import KERNELS, TOLERANCE, worst_error
from heatlens.gpu.context import is_software
from heatlens.gpu.program import ComputeProgram, DrawProgram

_LIMITS = {
    "GL_MAX_TEXTURE_SIZE": "largest texture",
    "GL_MAX_SHADER_STORAGE_BLOCK_SIZE": "storage block",
    "GL_MAX_COMPUTE_WORK_GROUP_INVOCATIONS": "invocations of a workgroup",
}
# Fragment shaders whose vertex shader has another name.
_VERTEX = {f"scene_{name}": "scene_mesh" for name in ("cover", "depth", "surface")}


@dataclass
class Gpu:
    """The context that the checks share, made on first use."""

    make_context: Callable[[], moderngl.Context]
    tell: Callable[[str], None] = lambda _: None  # is called with the words of each part
    _made: list[moderngl.Context] = field(default_factory=list)

    @property
    def ctx(self) -> moderngl.Context:
        """The context. Raises GpuError if there is no OpenGL 4.3."""
        if not self._made:
            self._made.append(self.make_context())
        return self._made[0]

    def device(self) -> Iterator[Finding]:
        """Report the driver and its limits."""
        info = self.ctx.info
        limits = {name: int(info[name]) for name in _LIMITS}
        details = {
            "renderer": str(info["GL_RENDERER"]),
            "vendor": str(info["GL_VENDOR"]),
            "version": str(info["GL_VERSION"]),
            "is_software": is_software(self.ctx),
            **limits,
        }
        listed = ", ".join(f"{_LIMITS[name]} {value}" for name, value in limits.items())
        kind = "on the processor" if details["is_software"] else "on a GPU"
        said = f"{details['renderer']}, OpenGL {details['version']}, {kind}; {listed}"
        yield Finding("OpenGL", "ok", said, details)

    def shaders(self) -> Iterator[Finding]:
        """Build every shader in every variant."""
        builds = solver_builds() + pass_builds()
        refused: list[str] = []
        for words, build in zip(shader_words(), builds, strict=True):
            self.tell(words)
            try:
                _build(self.ctx, build)
            except ShaderError as error:
                refused.append(" ".join(str(error).split()))
        for words in refused:
            yield Finding("shaders", "fault", words)
        built = len(builds) - len(refused)
        said = f"{built} of {len(builds)} builds"
        details = {"built": built, "refused": refused}
        yield Finding("shaders", "fault" if refused else "ok", said, details)

    def solvers(self) -> Iterator[Finding]:
        """Compare each solver on random lines with NumPy in float64."""
        for name, make in SOLVERS.items():
            self.tell(solver_words(name))
            solver = make(self.ctx)
            errors = {kernel: worst_error(self.ctx, solver, kernel) for kernel in KERNELS}
            solver.release()
            worst = max(errors.values())
            good = worst <= TOLERANCE
            said = f"{name}: off by {worst:.1e} at most (allowed {TOLERANCE:.0e})"
            details = {"solver": name, "errors": errors}
            yield Finding("solvers", "ok" if good else "fault", said, details)

    def errors(self) -> Iterator[Finding]:
        """Report whether the previous checks left an error in OpenGL."""
        error = self.ctx.error
        if error != "GL_NO_ERROR":
            raise GpuError(f"OpenGL reports an error: {error}.")
        yield Finding("OpenGL errors", "ok", "none")


def shader_words() -> list[str]:
    """Return the words of each part of the check of shaders."""
    count = len(solver_builds()) + len(pass_builds())
    return [f"shader {number} of {count}" for number in range(1, count + 1)]


def solver_words(name: str) -> str:
    """Return the words of the check of one solver."""
    return f"solver {name}"


def _build(ctx: moderngl.Context, build: Build) -> None:
    """Compile, link and release. Vertex shaders are built with their fragment shaders."""
    name, defines = build
    stem, stage, _ = name.split(".")
    if stage == "frag":
        DrawProgram(ctx, _vertex_of(stem), stem, defines).release()
    elif stage == "comp":
        functions = srgb_transform().glsl if stem.startswith("display") else ""
        ComputeProgram(ctx, name, defines, functions).release()


def _vertex_of(fragment: str) -> str:
    """Return the vertex shader of the same or a shorter name: `picture` for `picture_detail`."""
    name = _VERTEX.get(fragment, fragment)
    while "_" in name and not (data_dir("shaders") / f"{name}.vert.glsl").is_file():
        name = name.rpartition("_")[0]
    return name
