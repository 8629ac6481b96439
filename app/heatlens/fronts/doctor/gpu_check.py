"""Check OpenGL: its version and limits, the build of every shader, and the line solvers.

Shaders are built in every variant that the program uses; `solver_check` measures the solvers.
"""

import itertools
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field

from heatlens.core.base.errors import GpuError, ShaderError
from heatlens.core.base.paths import data_dir
from heatlens.core.model.view.overlays import overlays_by_name
from heatlens.fronts.doctor.finding import Finding
from heatlens.fronts.doctor.solver_check import KERNELS, TOLERANCE, worst_error
from heatlens.media.color.view_table import SIDE, table_glsl
from heatlens.media.color.view_transform import srgb_transform
from heatlens.render.defocus import pass_list
from heatlens.render.defocus.line_solver import (
    SOLVERS,
    Axis,
    LineSystem,
    PartitionSolver,
    SweepSolver,
)
from heatlens.render.display.picture_pass import STRIP_PX, TILE_PX
from heatlens.render.gpu.context import is_software
from heatlens.render.gpu.device import Device
from heatlens.render.gpu.program_versions import PLAIN, Variants, combine_variants, without_and_with
from heatlens.render.gpu.shader_source import ShaderSource, Stage, assemble

_LIMITS = {
    "texture_side_px": "largest texture",
    "storage_block_bytes": "storage block",
    "group_invocations": "invocations of a workgroup",
}
# Fragment shaders whose vertex shader has another name.
_VERTEX_SHADERS = {
    f"scene_gpu/scene_{name}": "scene_gpu/scene_mesh" for name in ("cover", "depth", "surface")
}

Build = tuple[str, dict[str, object]]

_AXES: tuple[Axis, ...] = ("rows", "columns")
_SIZES_PX = ((1920, 1080), (3840, 2160))  # in larger ones an invocation solves more pixels
_SWEEP, _PARTITION = (f"defocus/solve_{n}.comp.glsl" for n in ("sweep", "partition"))
_STRATEGIES = (_SWEEP, _PARTITION)


@dataclass
class Gpu:
    """The context that the checks share, made on first use."""

    make_context: Callable[[], Device]
    report_step: Callable[[str], None] = lambda _: (
        None
    )  # called with the name of each step of a check
    _contexts: list[Device] = field(default_factory=list)

    @property
    def ctx(self) -> Device:
        """The context. Raises GpuError if there is no OpenGL 4.3."""
        if not self._contexts:
            self._contexts.append(self.make_context())
        return self._contexts[0]

    def device(self) -> Iterator[Finding]:
        """Report the driver and its limits."""
        device = self.ctx
        limits = {name: getattr(device.limits, name) for name in _LIMITS}
        details = {
            "renderer": device.name,
            "vendor": device.vendor,
            "version": device.version,
            "is_software": is_software(self.ctx),
            **limits,
        }
        limit_texts = ", ".join(f"{_LIMITS[name]} {value}" for name, value in limits.items())
        kind = "on the processor" if details["is_software"] else "on a GPU"
        message = (
            f"{details['renderer']}, {device.library} {details['version']}, {kind}; {limit_texts}"
        )
        yield Finding(name=device.library, state="ok", said=message, details=details)

    def shaders(self) -> Iterator[Finding]:
        """Build every shader in every variant."""
        builds = solver_builds() + pass_builds()
        failures: list[str] = []
        for step, build in zip(shader_steps(), builds, strict=True):
            self.report_step(step)
            try:
                _build(self.ctx, build)
            except ShaderError as error:
                failures.append(" ".join(str(error).split()))
        for failure in failures:
            yield Finding(name="shaders", state="fault", said=failure)
        built = len(builds) - len(failures)
        message = f"{built} of {len(builds)} builds"
        details = {"built": built, "refused": failures}
        yield Finding("shaders", "fault" if failures else "ok", message, details)

    def solvers(self) -> Iterator[Finding]:
        """Compare each solver on random lines with NumPy in float64."""
        for name, make_solver in SOLVERS.items():
            self.report_step(solver_step(name))
            solver = make_solver(self.ctx)
            errors = {kernel: worst_error(self.ctx, solver, kernel) for kernel in KERNELS}
            solver.release()
            worst = max(errors.values())
            is_right = worst <= TOLERANCE
            message = f"{name}: off by {worst:.1e} at most (allowed {TOLERANCE:.0e})"
            details = {"solver": name, "errors": errors}
            yield Finding("solvers", "ok" if is_right else "fault", message, details)

    def errors(self) -> Iterator[Finding]:
        """Report whether the previous checks left an error in OpenGL."""
        error = self.ctx.error
        if error:
            raise GpuError(f"{self.ctx.library} reports an error: {error}. Update the driver.")
        yield Finding(name=f"{self.ctx.library} errors", state="ok", said="none")


def shader_steps() -> list[str]:
    """Return the name of each step of the shader check."""
    count = len(solver_builds()) + len(pass_builds())
    return [f"shader {number} of {count}" for number in range(1, count + 1)]


def solver_step(name: str) -> str:
    """Return the name of the step that checks one solver."""
    return f"solver {name}"


def _build(ctx: Device, build: Build) -> None:
    """Compile and link a shader, and release it. Raises ShaderError if the driver refuses."""
    for sources in sources_of(build):
        if "comp" in sources:
            ctx.compute_program(sources["comp"]).release()
        else:
            ctx.draw_program(sources["vert"], sources["frag"]).release()


def sources_of(build: Build) -> list[dict[Stage, ShaderSource]]:
    """Return the texts of the programs of a build, by stage.

    There are none for vertex shaders, which are built with their fragment shaders, and two for
    shaders with a view: sRGB and a table.
    """
    name, defines = build
    stem, stage, _ = name.split(".")
    source = assemble(data_dir("shaders"), name, defines)
    if stage == "frag":
        vertex = assemble(
            data_dir("shaders"), f"{_VERTEX_SHADERS.get(stem, stem)}.vert.glsl", defines
        )
        return [{"vert": vertex, "frag": source}]
    if stem.startswith("display/display"):
        views = srgb_transform().glsl, table_glsl(SIDE)
        return [{"comp": source.append_functions(view)} for view in views]
    return [{"comp": source}] if stage == "comp" else []


def solver_builds() -> list[Build]:
    """Return the builds of each solver for each system of lines."""
    return [
        (name, system.shader_defines(axis) | build)
        for blur_pass in pass_list.PASSES
        for system, axis in itertools.product(blur_pass.systems, _AXES)
        for name, build in _strategy_builds(system)
    ]


def _strategy_builds(system: LineSystem) -> list[Build]:
    """Return each solver's shader with the defines that it is built with for a system."""
    lines = SweepSolver.LINES_PER_GROUP
    sweep: Build = (_SWEEP, {"LINES_PER_GROUP": lines, "BLOCK": SweepSolver.BLOCK, "STRIPS": 1})
    all_defines = (PartitionSolver.run_defines(system, *size) for size in _SIZES_PX)
    partition: list[Build] = [(_PARTITION, dict(defines)) for defines in all_defines]
    return [sweep, *partition]


def shader_names() -> set[str]:
    """Return the name of every shader with its folder, such as "defocus/coc.comp.glsl"."""
    folder = data_dir("shaders")
    files = (file for file in folder.glob("*/*.glsl") if file.parent.name != "lib")
    return {file.relative_to(folder).as_posix() for file in files}


def pass_builds() -> list[Build]:
    """Return the builds of all other shaders, in each variant that the program or a scene uses."""
    declared: dict[str, Variants] = _variants_outside_passes()
    for blur_pass in pass_list.PASSES:
        for name, variants in blur_pass.shaders.items():  # a file may belong to several passes
            known = declared.get(name, ())
            declared[name] = *known, *(defines for defines in variants if defines not in known)
    names = sorted((shader_names() - set(_STRATEGIES)) | declared.keys())
    return [(name, dict(defines)) for name in names for defines in declared.get(name, PLAIN)]


def _variants_outside_passes() -> dict[str, Variants]:
    """Return the variants of shaders that belong to no pass of the pipeline."""
    scene = _scene_variants("HOLES", "MAPS", "COLORS", "BUMPS", "PLACEMENTS")
    peeled = combine_variants(scene, without_and_with("PEEL"))
    sides: Variants = ({"FRONT_SIDE": 4, "BEHIND_SIDE": 2}, {"FRONT_SIDE": 2, "BEHIND_SIDE": 1})
    modes: Variants = tuple({"MODE": it.function} for it in overlays_by_name().values())
    peaking: Variants = ({"PEAKING": 0}, {"PEAKING": 1})
    return {
        "scene_gpu/accumulate.comp.glsl": pass_list.SHAPES,
        "defocus/focus_offset_bins.comp.glsl": without_and_with("LISTS"),
        "scene_gpu/peel_lists.comp.glsl": sides,
        "scene_gpu/ray_trace.comp.glsl": combine_variants(pass_list.SHAPES, scene),
        "scene_gpu/scene_cover.frag.glsl": peeled,
        "scene_gpu/scene_depth.frag.glsl": scene,
        "scene_gpu/scene_mesh.vert.glsl": _scene_variants("COLORS", "BUMPS", "PLACEMENTS", "PEEL"),
        "scene_gpu/scene_sky.frag.glsl": _scene_variants("HOLES", "BUMPS", "PLACEMENTS", "PEEL"),
        "scene_gpu/scene_surface.frag.glsl": peeled,
        "defocus/enlarge.comp.glsl": ({"FACTOR": 2}, {"FACTOR": 3}),
        "display/enlarge_ready.comp.glsl": ({"STRIP": STRIP_PX},),
        "display/picture_detail.frag.glsl": ({"TILE": TILE_PX},),
        "display/overlay.comp.glsl": ({}, *combine_variants(modes, peaking)),
    }


def _scene_variants(*defines: str) -> Variants:
    """Return the variants with none, one and all of the defines that a scene decides.

    PEEL draws hidden surfaces.
    """
    counts = (0, 1, len(defines))
    define_sets = (names for count in counts for names in itertools.combinations(defines, count))
    return tuple(dict.fromkeys(names, 1) for names in define_sets)
