"""PixelBands: passes over every pixel, run in bands of rows to keep the window responsive."""

import math
from pathlib import PurePath
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.settings import DefocusSettings, Quality
from heatlens.core.model.shot.shot import Shot
from heatlens.render.defocus import pixel_list
from heatlens.render.defocus.pixel_list import PixelBands
from heatlens.render.frame_renderer import FrameRenderer, run_all_steps
from heatlens.render.gpu.program import ComputeProgram
from heatlens.render.gpu.shader_constants import PIXEL_GROUP
from heatlens.render.gpu.textures import download
from support.plates import plate_of, room

SHOT = Shot(Lens(50.0, 1.4, 1.0, 36.0), DefocusSettings(quality=Quality.DRAFT))
PER_PIXEL = ("coc", "unmix_find", "highlight_luminance", "highlight_split", "highlight_blocks")
PER_PIXEL += ("highlight_ranges",)
SIDES = st.integers(1, 5000)


class RecordingProgram:
    """A fake program that records the rows on which it was run."""

    def __init__(self) -> None:
        self.rows: list[range] = []

    def dispatch(self, groups: tuple[int, int], uniforms: dict[str, int]) -> None:
        first = uniforms["first_row"]
        self.rows.append(range(first, first + groups[1] * PIXEL_GROUP))


def bands_on(renderer: str) -> PixelBands:
    return PixelBands(SimpleNamespace(is_software="llvmpipe" in renderer))


@given(SIDES, SIDES, st.sampled_from([1, 2, 8]))
def test_bands_cover_each_row_once_within_most_pixels(width, height, side):
    listener = RecordingProgram()
    steps = sum(1 for _ in bands_on("llvmpipe").run(listener, (width, height), side=side))
    assert steps == len(listener.rows)
    covered_rows = [row for rows in listener.rows for row in rows]
    assert covered_rows == list(range(math.ceil(height / PIXEL_GROUP) * PIXEL_GROUP))
    most_px = max(pixel_list.BAND_PX, PIXEL_GROUP * width * side * side)
    assert all(len(rows) * width * side * side <= most_px for rows in listener.rows)


def render_in_bands(loaded: FrameRenderer, band_px: int, monkeypatch) -> tuple[np.ndarray, dict]:
    """Render with bands of `band_px` pixels; return the picture and the dispatches by program."""
    runs: dict[str, int] = {}
    dispatch = ComputeProgram.dispatch

    def count_and_dispatch(program: ComputeProgram, *args, **inputs) -> None:
        name = PurePath(program.name).name.partition(".")[0]
        runs[name] = runs.get(name, 0) + 1
        dispatch(program, *args, **inputs)

    with monkeypatch.context() as patch:
        patch.setattr(pixel_list, "BAND_PX", band_px)
        patch.setattr(ComputeProgram, "dispatch", count_and_dispatch)
        return download(run_all_steps(loaded.steps(SHOT))), runs


def test_picture_in_bands_equals_whole_picture(renderer, monkeypatch):
    color, depth = (np.concatenate([part, part]) for part in room())
    color[::7, ::11] *= 200.0  # lamps, also across the borders of bands
    renderer.load(plate_of(color, depth))
    for render_pass in vars(renderer._passes).values():
        if isinstance(getattr(render_pass, "_bands", None), PixelBands):
            monkeypatch.setattr(render_pass._bands, "_uses_bands", True)
    whole, whole_runs = render_in_bands(renderer, 1 << 30, monkeypatch)
    banded, band_runs = render_in_bands(renderer, 1, monkeypatch)
    np.testing.assert_array_equal(banded, whole)
    assert all(band_runs[name] > whole_runs[name] for name in PER_PIXEL)


@pytest.mark.parametrize("name, is_cut", [("llvmpipe (LLVM 19)", True), ("NVIDIA H100", False)])
def test_bands_are_cut_on_software_renderer_only(name, is_cut):
    listener = RecordingProgram()
    list(bands_on(name).run(listener, (4096, 2160)))
    assert (len(listener.rows) > 1) is is_cut
