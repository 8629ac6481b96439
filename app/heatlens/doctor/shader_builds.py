"""List every build that the program makes of its shaders."""

import itertools
import re

from heatlens.defocus.line_solver import Axis, LineSystem, PartitionSolver, SweepSolver
from heatlens.gpu.shader_source import assemble
from heatlens.paths import data_dir

Build = tuple[str, dict[str, object]]

_OVERLAY = "overlay.comp.glsl"
_SYSTEMS = [  # the blur of every kernel, and the fill
    *(
        LineSystem("lib/blur_system.lib.glsl", poles, poles > 1, (("HALF_POLES", 1),))
        for poles in (1, 2, 3, 4, 5)
    ),
    LineSystem("lib/blur_system.lib.glsl", 4, True, (("HALF_POLES", 1), ("SHAPED", 1))),
    LineSystem("lib/fill_system.lib.glsl"),
]
_AXES: tuple[Axis, ...] = ("rows", "columns")
_LENGTHS_PX = (720, 1920)  # of lines; longer ones are cut into longer runs of the same shape
_SWEEP, _PARTITION, _CYCLIC = (f"solve_{n}.comp.glsl" for n in ("sweep", "partition", "cyclic"))
_STRATEGIES = (_SWEEP, _PARTITION, _CYCLIC)
_STAGES = ("LOAD", "REDUCE", "SUBSTITUTE", "STORE")
_SPRITES = "highlight_sprites.comp.glsl"
_COUNTED = (
    *(_SPRITES, "peel_lists.comp.glsl", "proxy_lists.comp.glsl"),
    "scatter_sort.comp.glsl",
)
_SHAPES = (  # of openings that are no ellipses
    {"SHAPED": 1},
    {"SHAPED": 1, "COLORED": 1},
    {"SHAPED": 1, "IMAGED": 1},
    {"SHAPED": 1, "COLORED": 1, "IMAGED": 1},
)
_PLAIN = ("pyramid_read.comp.glsl",)  # asks for the width of the opening alone
_OF_SMALLER_LAYERS = ("layer_split.comp.glsl", "composite.comp.glsl")
# What a scene has decides which of these are defined; PEEL is for what lies behind others.
_OF_SCENES = ("HOLES", "COLORS", "BUMPS", "PLACES", "PEEL")


def solver_builds() -> list[Build]:
    """Return the builds of each solver for each system of lines."""
    return [
        (name, system.shader_defines(axis) | build)
        for system, axis in itertools.product(_SYSTEMS, _AXES)
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
    files = sorted(data_dir("shaders").glob("*.glsl"))
    builds: list[Build] = [(file.name, {}) for file in files if file.name not in _STRATEGIES]
    builds += [(name, {"COUNT": 1}) for name in _COUNTED]
    builds += [(name, {"REDUCED": 1}) for name in _OF_SMALLER_LAYERS]
    builds += [
        (name, defines | {"LISTS": 1})  # for pictures with fragment lists
        for name, defines in builds
        if "#ifdef LISTS" in _text(name)
    ]
    builds += [
        (name, defines | {"MATCHED": 1})  # for lists that are not of the picture's light
        for name, defines in builds
        if "#ifdef MATCHED" in _text(name)
        and ("LISTS" in defines or "#ifdef LISTS" not in _text(name))
    ]
    builds += [
        (name, defines | {"FINE_RIMS": 1})  # for highlights of scenes
        for name, defines in builds
        if "FINE_RIMS" in _whole_text(name) and ("LISTS" in defines or name == _SPRITES)
    ]
    builds += [
        (name, defines | shape)
        for name, defines in builds
        for shape in _SHAPES
        if all(word in _whole_text(name) for word in shape) and name not in _PLAIN
    ]
    builds += [
        (_OVERLAY, {"MODE": mode, "PEAKING": peaking})
        for mode, peaking in itertools.product(overlay_modes(), (0, 1))
    ]
    return builds + [
        (name, dict.fromkeys(chosen, 1))
        for name, _ in builds
        for count in (1, len(_OF_SCENES) - 1, len(_OF_SCENES))
        for chosen in itertools.combinations(_OF_SCENES, count)
        if all(word in _whole_text(name) for word in chosen)
    ]


def overlay_modes() -> list[str]:
    """Return the functions of the overlay's shader, one for each mode."""
    text = (data_dir("shaders") / _OVERLAY).read_text()
    return re.findall(r"^vec4 (\w+)\(ivec2 at, float", text, re.M)


def _text(name: str) -> str:
    return (data_dir("shaders") / name).read_text()


def _whole_text(name: str) -> str:
    """Return the text of a shader with everything that it includes."""
    folder = data_dir("shaders")
    return "".join((folder / file).read_text() for file in assemble(folder, name, {}).files)
