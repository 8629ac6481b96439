"""Every line system fulfills the contract that shaders/README.md states for a SYSTEM.

A fake solver solves nothing: it builds a shader that calls each function of the contract with the
types written there, and returns the numbers by which the tests check its laws.
"""

import shutil
from pathlib import Path

import numpy as np
import pytest

from heatlens.core.base.paths import data_dir
from heatlens.render.defocus.blur_pass import PACKED, BlurPass, BlurTargets, Diffusion, pole_layers
from heatlens.render.defocus.hidden_fill import Ends, Steadiness, SteadinessPass
from heatlens.render.defocus.kernels import named_kernel
from heatlens.render.defocus.layer_cuts import FARTHER_THAN_ALL, NEARER_THAN_ALL, LayerCut
from heatlens.render.defocus.layer_passes import CocFillPass
from heatlens.render.defocus.line_solver import Band, LineSolver, LineSystem
from heatlens.render.defocus.tile_mask import VisiblePixels
from heatlens.render.gpu.device import Device
from heatlens.render.gpu.program import ComputeProgram
from heatlens.render.gpu.shader_constants import LINE_NODE
from heatlens.render.gpu.textures import new_array, new_texture, upload

SIZE = (24, 16)
NUMBERS = 5  # that each pixel gives back

WHOLE = """
    Input before = input_at(at), here = input_at(at + axis), after = input_at(at + 2 * axis);
    float b_in = conductance(before, here), back = conductance(here, before);
    Source s = source_of(before, here, after, b_in, conductance(here, after));
    float heat = specific_heat(here);
    Input end = here;
    Output o;
    clear_output(o);
    for (int pole = 0; pole < POLES; ++pole) {
        Value right_hand_side = source(s, pole);
        add_pole(o, pole, right_hand_side);
    }
    store(at + axis, here, o);
"""
IN_PARTS = """
    Link from = link_at(at), link = link_at(at + axis), to = link_at(at + 2 * axis);
    float b_in = conductance(from, link), back = conductance(link, from);
    float b_out = conductance(link, to), heat = specific_heat(link);
    Link end = link;
    Source s;
    Output o;
    clear_output(o);
    for (int part = 0; part < PARTS; ++part) {
        for (int pole = 0; pole < POLES; ++pole) {
            Input before = input_at(at, part, pole), here = input_at(at + axis, part, pole);
            Input after = input_at(at + 2 * axis, part, pole);
            s = source_of(before, here, after, b_in, b_out);
            Value right_hand_side = source(s, part, pole);
            add_pole(o, part, pole, right_hand_side);
        }
        store(at + axis, link, true, o, part);
    }
"""
SHADER = """
#include SYSTEM
#if defined IN_PARTS && !defined Link
#include "lib/one_part.lib.glsl"
#endif
layout(local_size_x = 64) in;
layout(std430) buffer laws_block {{ float laws[]; }};
void main() {{
    int line = int(gl_GlobalInvocationID.y), i = int(gl_GlobalInvocationID.x);
    if (line >= line_count || i + 2 >= line_length) return;
    ivec2 at = pixel_at(first_line + line, i);
{calls}
    Num nothing = flow(0, 0.0);
    int first = {numbers} * (line * line_length + i);
    laws[first] = b_in;
    laws[first + 1] = back;
    laws[first + 2] = heat;
#if COMPLEX
    laws[first + 3] = length(nothing);
#else
    laws[first + 3] = abs(nothing);
#endif
    laws[first + 4] = 0.0;
    for (int pole = 0; pole < POLES; ++pole) {{
        Num beyond = repeated_heat(pole, end), out_there = flow(pole, conductance(end, end));
        Num one_more = num(heat) + beyond;  // a repeated pixel and all that lie beyond it
        Num again = mul(mul(out_there, one_more), inverted(out_there + one_more));
        Num off = IS_REPEATED ? again - beyond : beyond;
        laws[first + 4] = max(laws[first + 4], length(off) / (1.0 + length(beyond)));
    }}
}}
"""


class ContractProbe(LineSolver):
    """A line solver that runs the contract shader and stores its numbers by axis."""

    name = "probe"

    def __init__(self, ctx: Device, parts: dict[str, int]) -> None:
        super().__init__(ctx)
        self._parts = parts
        self.seen: dict[str, np.ndarray] = {}
        self.files: set[str] = set()

    def _bytes_per_line(self, system: LineSystem, length: int) -> dict[str, int]:
        return {}

    def _bands(self, system, length, lines):
        yield 0, lines

    def _solve_band(self, band: Band) -> None:
        defines = band.system.shader_defines(band.axis) | self._parts
        program = ComputeProgram(self._ctx, "contract.comp.glsl", defines)
        laws = self._ctx.buffer(bytes(4 * NUMBERS * band.count * band.length))
        program.dispatch(
            (1, band.count),
            textures=band.bindings.textures,
            images=band.bindings.images,
            buffers={"laws_block": laws, **band.bindings.buffers},
            uniforms=band.bindings.uniforms,
        )
        numbers = np.frombuffer(laws.read(), np.float32)
        self.seen[band.axis] = numbers.reshape(band.count, band.length, NUMBERS)[:, :-2]
        self.files.add(band.system.file)
        program.release()


def probe_blur(ctx: Device, probe: ContractProbe, kernel_name: str, rng) -> None:
    """Run the probe on the lines of a blur with kernel `kernel_name`."""
    color, coc, out = (new_texture(ctx, SIZE, channels) for channels in (4, 1, 4))
    upload(color, rng.random((*SIZE[::-1], 4), np.float32))
    upload(coc, (12 * rng.random(SIZE[::-1]) - 6).astype(np.float32))
    kernel = named_kernel(kernel_name)
    poles = new_array(ctx, SIZE, pole_layers(kernel), 4, PACKED)
    diffusion = Diffusion(color, coc, kernel, (1.0, 1.3))
    BlurPass(probe).run(diffusion, BlurTargets(poles, out))


def probe_coc_fill(ctx: Device, probe: ContractProbe, rng) -> None:
    """Run the probe on the lines of a coc fill."""
    state, out = (new_texture(ctx, SIZE, channels) for channels in (2, 1))
    upload(state, rng.random((*SIZE[::-1], 2), np.float32) * np.float32([9.0, 1.0]))
    words = CocFillPass.rows_bytes(SIZE) // 4
    rows = tuple(ctx.buffer(rng.random(words, np.float32).tobytes()) for _ in range(2))
    cut = LayerCut(NEARER_THAN_ALL, FARTHER_THAN_ALL)
    for _ in CocFillPass(probe).steps(state, cut, (1.0, 1.3), rows, out):
        pass


def probe_steadiness(ctx: Device, probe: ContractProbe, rng) -> None:
    """Run the probe on lines of nodes, of which some are hidden."""
    across, down = size = SIZE[0] * LINE_NODE, SIZE[1] * LINE_NODE
    color = new_texture(ctx, size, 4)
    upload(color, rng.random((down, across, 4), np.float32))
    words = rng.integers(0, 1 << 32, VisiblePixels.bytes_for(size) // 4, np.uint32)
    words[rng.random(words.size) < 0.5] = 0
    lines = Steadiness(*(new_texture(ctx, nodes, 1) for nodes in Steadiness.sizes(size)))
    ends = Ends(color, LayerCut(NEARER_THAN_ALL, FARTHER_THAN_ALL))
    for _ in SteadinessPass(probe).steps(color, size, ctx.buffer(words.tobytes()), ends, lines):
        pass


SYSTEMS = ("heat", "disc_2", "disc_3", "fill", "steadiness")


def probe_system(ctx: Device, system: str, parts: dict[str, int], rng) -> ContractProbe:
    probe = ContractProbe(ctx, parts)
    if system == "fill":
        probe_coc_fill(ctx, probe, rng)
    elif system == "steadiness":
        probe_steadiness(ctx, probe, rng)
    else:
        probe_blur(ctx, probe, system, rng)
    return probe


@pytest.fixture
def contract(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """Write the shader that calls the functions given, beside a copy of all others."""
    folder = tmp_path / "shaders"
    shutil.copytree(data_dir("shaders"), folder)
    monkeypatch.setattr("heatlens.render.gpu.program.data_dir", lambda _: folder)

    def write(calls: str) -> None:
        text = SHADER.format(calls=calls, numbers=NUMBERS)
        (folder / "contract.comp.glsl").write_text(text)

    return write


@pytest.mark.parametrize("form", ["whole", "in parts"])
@pytest.mark.parametrize("system", SYSTEMS)
def test_system_has_all_functions_and_fulfills_their_laws(ctx, contract, rng, system, form) -> None:
    contract(WHOLE if form == "whole" else IN_PARTS)
    complex_parts = 2 if system.startswith("disc") else 1
    parts = {} if form == "whole" else {"IN_PARTS": 1, "PARTS": complex_parts}
    probe = probe_system(ctx, system, parts, rng)
    assert set(probe.seen) == {"rows", "columns"}
    for numbers in probe.seen.values():
        b_in, back, heat, nothing, off = np.moveaxis(numbers, -1, 0)
        assert np.isfinite(numbers).all()
        np.testing.assert_array_equal(b_in, back)  # what flows one way flows the other way
        assert (b_in >= 0).all() and np.ptp(b_in) > 0
        assert (heat > 0).all()  # so that no elimination divides by 0
        assert (nothing == 0).all()  # no conductance, no flow
        assert (off < 1e-6).all()  # one repeated pixel more changes nothing


def test_contract_is_tested_for_every_system_file(ctx, contract, rng) -> None:
    contract(WHOLE)
    tested_files = {file for system in SYSTEMS for file in probe_system(ctx, system, {}, rng).files}
    files = data_dir("shaders").glob("lib/*_system.lib.glsl")
    assert tested_files == {f"lib/{file.name}" for file in files}
