"""Every build that the program makes of its shaders, read from the files themselves."""

import itertools
import re

from heatlens.gpu.shader_source import assemble
from heatlens.paths import data_dir

Build = tuple[str, dict[str, object]]

_OVERLAY = "overlay.comp.glsl"
_SYSTEMS = {"lib/blur_system.lib.glsl": (1, 2, 5), "lib/fill_system.lib.glsl": (1,)}
_STRATEGIES: dict[str, list[dict[str, object]]] = {
    "solve_sweep.comp.glsl": [{"LINES_PER_GROUP": 8, "BLOCK": 4, "STRIPS": 1}],
    "solve_partition.comp.glsl": [{"LINES_PER_GROUP": 2, "RUNS": 256, "RUN": 8}],
    "solve_cyclic.comp.glsl": [
        {"STAGE": stage} for stage in ("LOAD", "REDUCE", "SUBSTITUTE", "STORE")
    ],
}
_COUNTED = ("highlight_sprites.comp.glsl", "scatter_sort.comp.glsl")
_OF_SMALLER_LAYERS = ("layer_split.comp.glsl", "composite.comp.glsl")
_OF_SCENES = ("HOLES", "COLORS", "BUMPS")  # what a scene has decides which of them are defined


def solver_builds() -> list[Build]:
    """Each strategy for each system of lines."""
    builds: list[Build] = []
    for (system, poles), rows in itertools.product(_SYSTEMS.items(), (True, False)):
        for count, half in itertools.product(poles, (True, False)):
            defines: dict[str, object] = {
                "SYSTEM": system,
                "POLES": count,
                "COMPLEX": int(count > 1),
            }
            defines |= {"ROWS": 1} if rows else {}
            defines |= {"HALF_POLES": 1} if half else {}
            for name, variants in _STRATEGIES.items():
                builds += [(name, defines | variant) for variant in variants]
    return builds


def pass_builds() -> list[Build]:
    """All other shaders, in each form that the program or a scene asks for."""
    files = sorted(data_dir("shaders").glob("*.glsl"))
    builds: list[Build] = [(file.name, {}) for file in files if file.name not in _STRATEGIES]
    builds += [(name, {"COUNT": 1}) for name in _COUNTED]
    builds += [(name, {"REDUCED": 1}) for name in _OF_SMALLER_LAYERS]
    builds += [(_OVERLAY, {"MODE": mode}) for mode in overlay_modes()]
    return builds + [
        (name, dict.fromkeys(chosen, 1))
        for name, _ in builds
        for count in (1, 2, 3)
        for chosen in itertools.combinations(_OF_SCENES, count)
        if all(word in _whole_text(name) for word in chosen)
    ]


def overlay_modes() -> list[str]:
    """The functions of the overlay's shader, one a mode."""
    text = (data_dir("shaders") / _OVERLAY).read_text()
    return re.findall(r"^vec4 (\w+)\(ivec2 at, float", text, re.M)


def _whole_text(name: str) -> str:
    """Of a shader and of all that it includes."""
    folder = data_dir("shaders")
    return "".join((folder / file).read_text() for file in assemble(folder, name, {}).files)
