"""List every build that the program makes of its shaders."""

import itertools
import re

from heatlens.base.paths import data_dir
from heatlens.defocus import pass_list
from heatlens.defocus.line_solver import Axis, LineSystem, PartitionSolver, SweepSolver
from heatlens.gpu.program_versions import PLAIN, Variants, crossed, either

Build = tuple[str, dict[str, object]]

_OVERLAY = "overlay.comp.glsl"
_AXES: tuple[Axis, ...] = ("rows", "columns")
_LENGTHS_PX = (720, 1920)  # of lines; longer ones are cut into longer runs of the same shape
_SWEEP, _PARTITION, _CYCLIC = (f"solve_{n}.comp.glsl" for n in ("sweep", "partition", "cyclic"))
_STRATEGIES = (_SWEEP, _PARTITION, _CYCLIC)
_STAGES = ("LOAD", "REDUCE", "SUBSTITUTE", "STORE")


def solver_builds() -> list[Build]:
    """Return the builds of each solver for each system of lines."""
    return [
        (name, system.shader_defines(axis) | build)
        for one in pass_list.PASSES
        for system, axis in itertools.product(one.systems, _AXES)
        for name, build in _strategy_builds(system)
    ]


def _strategy_builds(system: LineSystem) -> list[Build]:
    lines = SweepSolver.LINES_PER_GROUP
    sweep: Build = (_SWEEP, {"LINES_PER_GROUP": lines, "BLOCK": SweepSolver.BLOCK, "STRIPS": 1})
    shapes = (PartitionSolver.shape(system, length) for length in _LENGTHS_PX)
    partition: list[Build] = [(_PARTITION, dict(shape)) for shape in shapes]
    cyclic: list[Build] = [(_CYCLIC, {"STAGE": stage}) for stage in _STAGES]
    return [sweep, *partition, *cyclic]


def pass_builds() -> list[Build]:
    """Return the builds of all other shaders, in each variant that the program or a scene uses."""
    declared: dict[str, Variants] = _elsewhere()
    for one in pass_list.PASSES:
        declared |= one.shaders
    files = {file.name for file in data_dir("shaders").glob("*.glsl")} - set(_STRATEGIES)
    names = sorted(files | declared.keys())
    return [(name, dict(defines)) for name in names for defines in declared.get(name, PLAIN)]


def _elsewhere() -> dict[str, Variants]:
    """Return the variants of shaders that belong to no pass of the pipeline."""
    scene = _of_scenes("HOLES", "COLORS", "BUMPS", "PLACES")
    peeled = _of_scenes("HOLES", "COLORS", "BUMPS", "PLACES", "PEEL")
    modes: Variants = tuple({"MODE": mode} for mode in overlay_modes())
    peaking: Variants = ({"PEAKING": 0}, {"PEAKING": 1})
    return {
        "accumulate.comp.glsl": pass_list.SHAPES,
        "peel_lists.comp.glsl": either("COUNT"),
        "ray_trace.comp.glsl": crossed(pass_list.SHAPES, scene),
        "scene_cover.frag.glsl": peeled,
        "scene_depth.frag.glsl": scene,
        "scene_mesh.vert.glsl": _of_scenes("COLORS", "BUMPS", "PLACES", "PEEL"),
        "scene_sky.frag.glsl": _of_scenes("HOLES", "BUMPS", "PLACES", "PEEL"),
        "scene_surface.frag.glsl": peeled,
        _OVERLAY: ({}, *crossed(modes, peaking)),
    }


def _of_scenes(*words: str) -> Variants:
    """Return the variants with none, one, four and five of the defines that a scene decides.

    PEEL draws hidden surfaces.
    """
    chosen = (names for count in (0, 1, 4, 5) for names in itertools.combinations(words, count))
    return tuple(dict.fromkeys(names, 1) for names in chosen)


def overlay_modes() -> list[str]:
    """Return the functions of the overlay's shader, one for each mode."""
    text = (data_dir("shaders") / _OVERLAY).read_text()
    return re.findall(r"^vec4 (\w+)\(ivec2 at, float", text, re.M)
