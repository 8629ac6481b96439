"""Line solvers with a tile mask solve active tiles like a picture of their own, and no others."""

from dataclasses import dataclass

import numpy as np
import pytest

from heatlens.render.defocus.blur_pass import PACKED, BlurPass, BlurTargets, Diffusion, pole_layers
from heatlens.render.defocus.kernels import Kernel, named_kernel
from heatlens.render.defocus.layer_cuts import Cut, LayerCut
from heatlens.render.defocus.layer_passes import CocFillPass
from heatlens.render.defocus.line_solver import LineSolver, PartitionSolver, SweepSolver
from heatlens.render.defocus.tile_mask import SegmentPass, TileMask, run_length, tile_count
from heatlens.render.gpu.device import Device
from heatlens.render.gpu.shader_constants import TILE
from heatlens.render.gpu.textures import (
    BufferParts,
    FloatArray,
    Storage,
    download,
    new_array,
    new_texture,
    upload,
)

SIZE = (150, 90)  # 10 x 6 tiles, the last of both only in part
ISLANDS = [  # first tile across and down, tiles across and down; none beside another
    (0, 0, 2, 3),
    (3, 0, 1, 1),
    (5, 1, 4, 1),
    (3, 2, 1, 4),
    (8, 3, 2, 3),
    (5, 4, 2, 1),
]
UNTOUCHED = 7.25
CUT = LayerCut(near=Cut(10.0, 2.0), far=Cut(80.0, 2.0))


@dataclass(frozen=True)
class Plate:
    """Color (H, W, 4), coc in pixels (H, W) and the share 0..1 to which it is known (H, W)."""

    color: FloatArray
    coc: FloatArray
    known: FloatArray

    def cut_out(self, island: tuple[slice, slice]) -> "Plate":
        return Plate(self.color[island], self.coc[island], self.known[island])


@pytest.fixture(scope="module", params=[SweepSolver, PartitionSolver])
def solver(request: pytest.FixtureRequest, session_context: Device) -> LineSolver:
    return request.param(session_context)


@pytest.fixture
def plate(rng: np.random.Generator) -> Plate:
    """Return a plate that is NaN outside active tiles, so that reading there shows."""
    shape = SIZE[::-1]
    outside = np.repeat(np.repeat(tile_map() == 0, TILE, 0), TILE, 1)[: shape[0], : shape[1]]
    color = rng.random((*shape, 4), np.float32)
    coc = 30.0 * rng.random(shape, np.float32) ** 2
    known = np.round(rng.random(shape)).astype(np.float32)
    for island in island_slices():  # no light crosses the border of an island
        coc[island][[0, -1]], coc[island][:, [0, -1]] = 0.0, 0.0
    for values in (color, coc, known):
        values[outside] = np.nan
    return Plate(color, coc, known)


def tile_map() -> np.ndarray:
    across, down = tile_count(SIZE)
    tiles = np.zeros((down, across), np.uint32)
    for x, y, width, height in ISLANDS:
        tiles[y : y + height, x : x + width] = 1
    return tiles


def island_slices() -> list[tuple[slice, slice]]:
    return [
        (slice(TILE * y, TILE * (y + height)), slice(TILE * x, TILE * (x + width)))
        for x, y, width, height in ISLANDS
    ]


def mask_of(ctx: Device, tiles: np.ndarray, size: tuple[int, int]) -> TileMask:
    """Return the mask of a picture of `size` in which the `tiles` (down, across) are active."""
    words = ctx.buffer(tiles.astype(np.uint32).tobytes())
    part = BufferParts.bytes_for(SegmentPass.bytes_for(size))
    lists = BufferParts(ctx.buffer(reserve=2 * part), part)
    return SegmentPass(ctx).find([size], BufferParts(words, words.size), lists)[0]


def mask_of_islands(ctx: Device) -> TileMask:
    return mask_of(ctx, tile_map(), SIZE)


def blur_plate(
    solver: LineSolver, plate: Plate, kernel: Kernel, storage: Storage, mask: TileMask | None
) -> FloatArray:
    ctx, size = solver._ctx, plate.coc.shape[::-1]
    color, coc, out = (new_texture(ctx, size, channels) for channels in (4, 1, 4))
    upload(color, plate.color)
    upload(coc, plate.coc)
    upload(out, np.full((*plate.coc.shape, 4), UNTOUCHED))
    layers = pole_layers(kernel, storage)
    poles = new_array(ctx, solver.size_between_axes(size), layers, 4, storage)
    poles.write(b"\xff" * (poles.width * poles.height * layers * 16))
    BlurPass(solver).run(Diffusion(color, coc, kernel, (1.0, 1.0)), BlurTargets(poles, out), mask)
    return download(out)


def fill_coc(solver: LineSolver, plate: Plate, mask: TileMask | None) -> FloatArray:
    ctx, size = solver._ctx, plate.coc.shape[::-1]
    state, out = new_texture(ctx, size, 2), new_texture(ctx, size, 1)
    rows = tuple(ctx.buffer(b"\xff" * CocFillPass.rows_bytes(size)) for _ in range(2))
    upload(state, np.stack([plate.coc, plate.known], axis=-1))
    upload(out, np.full(plate.coc.shape, UNTOUCHED))
    list(CocFillPass(solver).steps(state, CUT, (1.0, 1.0), rows, out, mask))
    return download(out).reshape(plate.coc.shape)


def outside_of_islands(picture: FloatArray) -> FloatArray:
    outside = picture.copy()
    for island in island_slices():
        outside[island] = UNTOUCHED
    return outside


@pytest.mark.parametrize(
    ("name", "storage"), [("heat", "f4"), ("disc_3", "f4"), ("disc_3", PACKED), ("disc_4", PACKED)]
)
def test_masked_blur_of_island_equals_blur_of_island_alone(
    ctx: Device, solver: LineSolver, plate: Plate, name: str, storage: Storage
) -> None:
    kernel, tolerance = named_kernel(name), 1e-5 if storage == "f4" else 2e-3
    masked = blur_plate(solver, plate, kernel, storage, mask_of_islands(ctx))
    for island in island_slices():
        alone = blur_plate(solver, plate.cut_out(island), kernel, storage, None)
        np.testing.assert_allclose(masked[island], alone, atol=tolerance)
    assert np.all(outside_of_islands(masked) == UNTOUCHED)


def test_masked_coc_fill_of_island_equals_fill_of_island_alone(
    ctx: Device, solver: LineSolver, plate: Plate
) -> None:
    masked = fill_coc(solver, plate, mask_of_islands(ctx))
    for island in island_slices():
        alone = fill_coc(solver, plate.cut_out(island), None)
        np.testing.assert_allclose(masked[island], alone, rtol=1e-4, atol=1e-4)
    assert np.all(outside_of_islands(masked) == UNTOUCHED)


@pytest.mark.parametrize("name", ["heat", "disc_4"])
def test_masked_blur_of_segments_at_line_ends_equals_whole_blur(
    ctx: Device, solver: LineSolver, rng: np.random.Generator, name: str
) -> None:
    """Compare lines of two segments, with pixels in focus between them, with the whole lines."""
    height, width = SIZE[::-1]
    tiles = np.ones(tile_count(SIZE)[::-1], int)
    tiles[:, 4], tiles[2] = 0, 0
    coc = np.full((height, width), 40.0, np.float32)
    coc[:, 4 * TILE - 1 : 5 * TILE + 1], coc[2 * TILE - 1 : 3 * TILE + 1] = 0.0, 0.0
    plate = Plate(rng.random((height, width, 4), np.float32), coc, coc)
    kernel, active = named_kernel(name), np.repeat(np.repeat(tiles, TILE, 0), TILE, 1) == 1
    whole = blur_plate(solver, plate, kernel, "f4", None)
    parts = blur_plate(solver, plate, kernel, "f4", mask_of(ctx, tiles, SIZE))
    inside = active[:height, :width]
    np.testing.assert_allclose(parts[inside], whole[inside], atol=1e-5)


def test_blur_with_empty_tile_mask_leaves_output_untouched(
    ctx: Device, solver: LineSolver, plate: Plate
) -> None:
    empty_mask = mask_of(ctx, np.zeros_like(tile_map()), SIZE)
    assert np.all(
        blur_plate(solver, plate, named_kernel("disc_2"), PACKED, empty_mask) == UNTOUCHED
    )


@pytest.mark.parametrize(
    ("length", "run_px"),
    [(4096, 8), (8192 + 8 * TILE, 2 * TILE)],  # several runs in a tile; two tiles in a run
)
@pytest.mark.parametrize(("name", "storage"), [("disc_3", "f4"), ("disc_4", PACKED)])
def test_masked_blur_of_long_line_solves_active_tiles_only(
    ctx: Device,
    solver: LineSolver,
    rng: np.random.Generator,
    length: int,
    run_px: int,
    name: str,
    storage: Storage,
) -> None:
    assert run_length(length) == run_px
    kernel, tolerance = named_kernel(name), 1e-5 if storage == "f4" else 2e-3
    active = np.tile([1, 0, 0, 1, 1, 0, 1, 1], length // (8 * TILE)).astype(np.uint32)
    inside = np.repeat(active, TILE) == 1
    color = np.where(inside[:, None], rng.random((length, 4), np.float32), np.nan)[None]
    coc = np.where(inside, np.float32(20.0), np.nan)[None]
    ends = inside & ~(np.roll(inside, 1) & np.roll(inside, -1))
    coc[0, ends], coc[0, 0], coc[0, -1] = 0.0, coc[0, 0] * 0.0, coc[0, -1] * 0.0
    plate = Plate(color, coc, coc)
    mask = mask_of(ctx, active[None], (length, 1))
    masked = blur_plate(solver, plate, kernel, storage, mask)
    island = (slice(None), slice(3 * TILE, 5 * TILE))
    alone = blur_plate(solver, plate.cut_out(island), kernel, storage, None)
    np.testing.assert_allclose(masked[island], alone, atol=tolerance)
    assert np.all(masked[:, ~inside] == UNTOUCHED) and np.all(masked[:, inside] != UNTOUCHED)
