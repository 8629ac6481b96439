"""The legend has the colors that the overlay draws, and the numbers of the lens."""

import numpy as np
import pytest

from heatlens.core.model.depth_words import DepthConvention, DepthKind
from heatlens.core.model.view.guides import USUAL_PEAKING
from heatlens.core.model.view.overlays import legend_entries, overlays_by_name
from heatlens.media.plate.plate import DepthReport
from heatlens.render.defocus.optics import Optics
from heatlens.render.display.overlay_pass import OverlayPass
from heatlens.render.gpu.textures import new_texture, upload
from heatlens.studio.ui.picture.legend import legend_facts

COCS = np.array([[-40.0, -7.0, 0.0, 0.5, 6.0, 30.0]], np.float32)
OPTICS = Optics(None, np.sort(COCS.ravel()).astype(np.float64))
LIMITS = (-10.0, -1.0, 10.0)
DEPTH = DepthReport("Z", DepthConvention.DISTANCE, DepthKind.PLANAR, "", 0.5, 8.0, 3, 0)


def draw_overlay(ctx, overlay: str) -> np.ndarray:
    """Draw the overlay; return the (6, 3) display colors of the six pixels."""
    size = COCS.shape[::-1]
    depth, out = new_texture(ctx, size, 1), ctx.texture(size, 4)
    upload(depth, COCS)
    OverlayPass(ctx).run(overlay, depth, OPTICS, 1.0, LIMITS, out)
    return np.frombuffer(out.read(), np.uint8).reshape(-1, 4)[:, :3] / 255


@pytest.mark.parametrize(
    ("overlay", "of_entry"),
    [
        ("zones", {0: 0, 1: 2, 2: 5}),
        ("coc", {0: 0, 1: 2}),
        ("layers", {0: 0, 1: 1, 2: 3, 3: 5}),
        ("depth", {0: 0, 1: 5}),
        ("focus plane", {0: 2}),
    ],
)
def test_legend_colors_equal_those_of_the_overlay(ctx, overlay, of_entry):
    legend = legend_entries(overlay, legend_facts(OPTICS, 1.0, LIMITS, DEPTH, "m"))
    assert len(legend) >= len(of_entry)
    pixels = draw_overlay(ctx, overlay)
    for entry, pixel in of_entry.items():
        assert legend[entry].color == pytest.approx(tuple(pixels[pixel]), abs=0.01)


def test_legend_numbers_come_from_lens_and_plate():
    facts = legend_facts(OPTICS, 1.25, LIMITS, DEPTH, "ft")
    words = {o: [e.words for e in legend_entries(o, facts)] for o in overlays_by_name()}
    assert words["coc"] == ["nearest 40.0 px", "in focus, up to 1.2 px", "farthest 30.0 px"]
    assert words["depth"] == ["1'7.7\"", "infinity"]
    assert words["layers"] == ["up to -10 px", "-10 to -1 px", "-1 to +10 px", "from +10 px"]
    assert words["none"] == []


def test_legend_lists_peaking_after_the_overlay():
    facts = legend_facts(OPTICS, 1.25, LIMITS, DEPTH, "m")
    entries = legend_entries("zones", facts, USUAL_PEAKING)
    alone = legend_entries("none", facts, USUAL_PEAKING)
    assert len(entries) == 4 and entries[-1] == alone[0]
    assert alone[0].color == USUAL_PEAKING.rgb and alone[0].words == "edges in focus, up to 1.2 px"
