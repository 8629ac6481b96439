"""Declare the passes of the pipeline: the one list of their shaders, memory and bytes.

The lifetimes of scratch memory (`render/defocus/scratch.py`), the costs of `heatlens bench` and the
builds that `heatlens doctor` tries derive from it.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace

from heatlens.render.defocus import pass_costs
from heatlens.render.defocus.line_solver import LineSystem
from heatlens.render.defocus.pass_costs import Traffic, Work
from heatlens.render.gpu.program_versions import PLAIN, Variants, combine_variants, without_and_with
from heatlens.render.gpu.shader_constants import HIGHLIGHT_LEVELS, TILE

# The name of the memory for each name of a texture or buffer; "" if both names are the same.
MemoryNames = Mapping[str, str]


@dataclass(frozen=True)
class Pass:
    """A pass of the pipeline.

    shaders     the builds of each shader, by its file; a file may belong to several passes
    traffic     the bytes per pixel that it moves in a number of runs
    writes      the names whose memory this pass is the first to write
    reads_last  the names whose memory no later pass reads; others stay until the next picture
    private_memory  the names whose memory only this pass uses
    systems     the systems of lines that it solves
    """

    name: str
    shaders: Mapping[str, Variants]
    traffic: Callable[[Work, int], Traffic]
    writes: MemoryNames = field(default_factory=dict)
    reads_last: tuple[str, ...] = ()
    private_memory: MemoryNames = field(default_factory=dict)
    systems: tuple[LineSystem, ...] = ()


# Shapes of the opening: an ellipse, or another one.
SHAPES: Variants = (
    {},
    *combine_variants(({"SHAPED": 1},), without_and_with("COLORED"), without_and_with("IMAGED")),
)
_LISTS, _COUNT = without_and_with("LISTS"), without_and_with("COUNT")
_ON_GPU = {"COUNT": 1, "LEVELS_AT_ONCE": HIGHLIGHT_LEVELS}
_LINES, _HIGHLIGHTS = without_and_with("LINES"), without_and_with("HIGHLIGHTS")
_ENTERED = {"LINES": 1, "ENTERED": 1}
_MATCHED: Variants = ({}, *combine_variants(({"LISTS": 1},), without_and_with("MATCHED")))
_GUESSES = combine_variants(_MATCHED, _LINES)
_STEADINESS = LineSystem("lib/steadiness_system.lib.glsl")
_LARGE = combine_variants(SHAPES, without_and_with("LARGE"))
_WHOLE_PARTS: Variants = ({"ALL_DEPTHS": 1}, {"ALL_DEPTHS": 1, "PART_VARIES": 1})
_BLUR = "lib/blur_system.lib.glsl"
_PACKED = ("HALF_POLES", 1), ("PACKED_PICTURE", 1)


def _comp(*names: str, variants: Variants = PLAIN) -> dict[str, Variants]:
    """Return the builds of compute shaders by their files; all `names` have the same variants."""
    return dict.fromkeys((f"defocus/{name}.comp.glsl" for name in names), variants)


def _draw(name: str, fragment: Variants, vertex: Variants = SHAPES) -> dict[str, Variants]:
    """Return the builds of the vertex and the fragment shader that draw discs, by their files."""
    return {f"defocus/{name}.vert.glsl": vertex, f"defocus/{name}.frag.glsl": fragment}


def _own_memory(*names: str) -> dict[str, str]:
    """Return `names` with memory of their own, which they share with no other name."""
    return dict.fromkeys(names, "")


# The passes in order. "layer split" to "composite" run once for each layer; all passes up to
# "colours" run for each color; each of the last three replaces "alpha" to "highlights drawn".
PASSES: tuple[Pass, ...] = (
    Pass(
        "proxy",
        _comp("proxy", variants=without_and_with("POSITIONS"))
        | _comp("peel_starts")
        | _comp("proxy_lists", "proxy_silhouettes", variants=_COUNT),
        pass_costs.proxy_bytes,
        _own_memory(
            "proxy colour", "proxy depth", "proxy positions", "proxy starts", "proxy fragments"
        )
        | _own_memory(
            "proxy fragment count", "wide colour", "wide depth", "scaled colour", "wide positions"
        )
        | _own_memory("proxy cutout", "proxy cutout alpha", "proxy cutout depth", "proxy ground"),
    ),
    Pass(
        "coc",
        _comp("coc", "coc_shift"),
        pass_costs.coc_bytes,
        _own_memory("coc", "cutout coc", "colours kept"),
    ),
    # Alpha as a picture of its own, which is layered before the color.
    Pass(
        "alpha",
        _comp("alpha_as_color", "alpha_join"),
        pass_costs.alpha_bytes,
        _own_memory("alpha plate"),
    ),
    Pass(
        "highlights found",  # at half size, each pixel is compared with its surroundings
        _comp("highlight_luminance", "highlight_split", variants=_LISTS),
        pass_costs.highlights_found_bytes,
        _own_memory("rest", "rest fragments", "around")
        | {"highlights": "layer", "lit pixels": "pixel list"},
        private_memory={
            "surroundings": "hidden cost",
            "surroundings coc": "layer coc",
            "surroundings blurred": "hidden match",
            "surroundings poles": "poles",
        },
    ),
    Pass(
        "highlights listed",
        _comp("highlight_sprites", variants=combine_variants(SHAPES, (*_COUNT, _ON_GPU)))
        | _comp("highlight_blocks", "highlight_plan")
        | _comp("highlight_restore", variants=_LISTS),
        pass_costs.highlights_listed_bytes,
        _own_memory("highlight plan", "highlight sprite"),
        reads_last=("highlights", "lit pixels"),
        private_memory=_own_memory("highlight row", "highlight blocks")
        | {"highlight tally": "hidden blocks"},
    ),
    Pass(
        "fragments",  # the picture is split at its silhouettes
        _comp("unmix_find", "unmix_own", "unmix_far", "unmix_thin", "unmix_near", variants=_LISTS),
        pass_costs.unmix_bytes,
        _own_memory("kind", "far", "near", "tile content", "tile coc range", "out", "alpha out"),
        private_memory={"rim list": "pixel list", "thin list": "hidden blocks"},
    ),
    Pass(
        "near zones",  # where views of parts of the lens replace all layers
        _comp("overlap_edges", variants=({"ALL_DEPTHS": 1},)) | _comp("overlap_zone"),
        pass_costs.near_zones_bytes,
        _own_memory("whole zone", "whole tiles", "whole tile lists", "whole segments"),
        private_memory={"whole zone rows": "far zone rows", "whole seen": "far seen"},
    ),
    Pass(
        "far parts",  # the views of parts of the lens behind the focus
        _comp("part_links", "part_view", "part_sum", variants=({}, {"PART_VARIES": 1}))
        | _comp("overlap_edges", "overlap_zone", "part_surfaces", "part_order", "part_masks")
        | _comp("part_over", "part_mix")
        | _comp("guess_push", "guess_lists")
        | _comp("guess_pull", variants=without_and_with("FIRST")),
        pass_costs.far_parts_bytes,
        _own_memory("far sum", "far zone"),
        private_memory=_own_memory(
            "far heads", "far links", "far zone rows", "far tiles", "far tile lists", "far segments"
        )
        | _own_memory("far seen")
        | _own_memory("far marks", "far masks", "far runs")
        | _own_memory("guess starts", "guess words", "guess levels")
        | _own_memory("far view", "far limits")
        | {"far coc": "layer coc", "far poles": "poles"},
    ),
    Pass(
        "tiles",
        _comp("tile_layers", variants=combine_variants(_LISTS, ({}, {"ROWS_AT_ONCE": TILE})))
        | _comp("tile_reach_rows", "tile_reach", "line_segments")
        | _comp("composite_begin"),
        pass_costs.tiles_bytes,
        _own_memory("tile mask", "tile list", "line segments"),
        private_memory=_own_memory("tile hole")
        | {"tile distance": "pixel list", "tile hider": "hidden blocks"},
    ),
    Pass(
        "layer split",
        _comp("layer_split", variants=combine_variants(without_and_with("REDUCED"), _LISTS)),
        pass_costs.layer_split_bytes,
        _own_memory("behind", "layer", "layer state", "known") | {"hidden list": "pixel list"},
    ),
    Pass(
        "hidden fill",
        _comp("visible_bits", "visible_words")
        | _comp("hidden_rims", variants=without_and_with("MATCHED"))
        | _comp("hidden_blocks", variants=without_and_with("EACH_PIXEL"))
        | _comp(
            "hidden_cost",
            variants=(*combine_variants(without_and_with("MATCHED"), _LINES), _ENTERED),
        )
        | _comp("hidden_fill", variants=combine_variants((*_GUESSES, _ENTERED), _HIGHLIGHTS)),
        pass_costs.hidden_fill_bytes,
        reads_last=("known", "hidden list"),
        private_memory=_own_memory("hidden blocks", "hidden cost", "hidden match")
        | _own_memory("visible bits", "visible words", "steady rows", "steady columns"),
        systems=(_STEADINESS, replace(_STEADINESS, defines=(("ENTERED", 1),))),
    ),
    Pass(
        "coc fill",
        {},
        pass_costs.coc_fill_bytes,
        _own_memory("layer coc"),
        reads_last=("layer state",),
        private_memory={"coc fill diameters": "pixel list", "coc fill weights": "hidden blocks"},
        systems=(LineSystem("lib/fill_system.lib.glsl"),),
    ),
    Pass(
        "blur",
        {},
        pass_costs.blur_pass_bytes,
        _own_memory("blurred"),
        reads_last=("layer coc",),
        private_memory=_own_memory("poles"),
        systems=(
            *(
                LineSystem(_BLUR, poles, is_complex=poles > 1, defines=(("HALF_POLES", 1),))
                for poles in (1, 2, 3, 4, 5)
            ),
            LineSystem(_BLUR, 4, is_complex=True, defines=(("HALF_POLES", 1), ("SHAPED", 1))),
            *(LineSystem(_BLUR, poles, poles > 1, _PACKED) for poles in (1, 2)),
        ),
    ),
    Pass(
        "composite",
        _comp("composite", variants=without_and_with("MIXED"))
        | _comp("cutout_over", "cutout_backdrop"),
        pass_costs.composite_bytes,
        _own_memory("without far"),
        reads_last=("layer", "behind"),
    ),
    Pass(
        "whole parts",  # the views of parts of the lens around wide surfaces in front of the focus
        _comp("part_surfaces", variants=({"ALL_DEPTHS": 1},))
        | _comp("part_links", "part_view", "part_sum", variants=_WHOLE_PARTS),
        pass_costs.far_parts_bytes,
        _own_memory("whole sum"),
        private_memory=_own_memory("front view", "front coc")
        | {f"whole {name}": f"far {name}" for name in ("heads", "links", "marks", "masks", "runs")}
        | {f"whole {name}": f"far {name}" for name in ("view", "limits")}
        | {"whole coc": "layer coc", "whole poles": "poles", "front state": "layer state"}
        | {"front fill diameters": "pixel list", "front fill weights": "hidden blocks"},
    ),
    Pass(
        "highlights drawn",
        _comp("highlight_ranges")
        | _comp("highlight_nodes", variants=SHAPES)
        | _comp("highlight_shadow", variants=combine_variants(SHAPES, _LISTS))
        | _draw("highlight_draw", combine_variants(_LARGE, _LISTS), _LARGE),
        pass_costs.highlights_drawn_bytes,
        _own_memory("enlarged out"),
        reads_last=(
            *("alpha plate", "rest fragments", "around", "highlight plan"),
            *(
                "far sum",
                "far zone",
                "whole sum",
                "whole zone",
                "whole tiles",
                "whole tile lists",
                "whole segments",
                "tile mask",
                "tile list",
                "line segments",
            ),
            *("highlight sprite", "kind", "far", "near", "tile content", "tile coc range"),
        ),
        # By OpenGL on Vulkan, Mesa 22 computes wrongly in memory that earlier draws have read.
        private_memory=_own_memory("highlight nodes")
        | {"highlight ranges": "layer state", "highlight edges": "layer coc"},
    ),
    Pass(
        "limits",
        _comp("limits"),
        pass_costs.limits_bytes,
        _own_memory("frame", "frame of a plate", "in plate's light"),
        reads_last=("alpha out",),
    ),
    Pass("colours", _comp("channels_copy"), pass_costs.colours_bytes, reads_last=("colours kept",)),
    Pass(
        "gather",
        _comp("gather", variants=SHAPES),
        pass_costs.method_bytes,
        private_memory={"gather weight": "cover", "gather weights": "layer"},
    ),
    Pass(
        "scatter",
        _comp("scatter_sort", variants=_COUNT)
        | _draw("scatter_draw", SHAPES)
        | _comp("scatter_over"),
        pass_costs.method_bytes,
        private_memory=_own_memory("scatter cover", "scatter offsets")
        | {"bin light": "layer", "bin cover": "cover", "scatter order": "pixel list"},
    ),
    Pass(
        "pyramid",
        _comp("pyramid_reduce", "pyramid_read"),
        pass_costs.method_bytes,
        private_memory=_own_memory("pyramid"),
    ),
)


def pass_named(name: str) -> Pass:
    """Return the pass called `name`. Raises KeyError if there is none."""
    return {candidate.name: candidate for candidate in PASSES}[name]
