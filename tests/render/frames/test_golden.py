"""Rendered pictures against golden ones (support/golden.py says how these are updated)."""

from pathlib import Path

import numpy as np
import pytest

from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.settings import Bokeh, DefocusSettings, Quality
from heatlens.core.model.shot.shot import Shot
from heatlens.render.frame_renderer import FrameRenderer
from support.golden import check_is_golden, compare_with_golden, require_llvmpipe, write_golden
from support.plates import plate_of, room, wires_and_lamps

GOLDEN = Path(__file__).with_name("golden")
SIZE = (160, 90)

SHOTS = {
    "ball_film_disc": (room, Shot(Lens(50.0, 1.4, 2.0, 36.0))),
    "post_preview_disc": (
        room,
        Shot(Lens(85.0, 2.0, 0.9, 36.0), DefocusSettings(Bokeh.DISC, Quality.PREVIEW)),
    ),
    "sky_gaussian": (
        room,
        Shot(Lens(35.0, 2.0, float("inf"), 24.9), DefocusSettings(Bokeh.GAUSSIAN, Quality.FILM)),
    ),
    "anamorphic_heat_proxy": (
        room,
        Shot(
            Lens(75.0, 1.4, 3.0, 24.9, squeeze=2.0),
            DefocusSettings(Bokeh.HEAT, Quality.DRAFT, proxy=0.5),
        ),
    ),
    "wires_and_lamps_film": (
        wires_and_lamps,
        Shot(Lens(85.0, 1.2, 1.6, 36.0), DefocusSettings(Bokeh.DISC, Quality.FILM)),
    ),
}


@pytest.mark.parametrize("name", SHOTS)
def test_picture_matches_golden(ctx, request, tmp_path, name):
    plate, shot = SHOTS[name]
    renderer = FrameRenderer(ctx)
    renderer.load(plate_of(*plate(*SIZE)))
    picture = renderer.pixels(shot)[..., :3]
    assert np.isfinite(picture).all()
    is_updating = request.config.getoption("--update-golden")
    compare_with_golden(picture, GOLDEN / f"{name}.exr", ctx, is_updating, tmp_path)


def test_golden_files_match_shots():
    assert {path.stem for path in GOLDEN.glob("*")} == set(SHOTS)


def test_check_is_golden_reports_difference_and_saves_evidence(tmp_path):
    golden, evidence = tmp_path / "golden" / "grey.exr", tmp_path / "evidence"
    golden.parent.mkdir()
    evidence.mkdir()
    picture = np.full((40, 50, 3), 0.5, np.float32)
    write_golden(golden, picture)
    picture[0, 0] += 0.1  # one pixel of 2000 is within MOST_PIXELS
    check_is_golden(picture, golden, evidence)
    picture[0, :5, 1] += 0.1
    with pytest.raises(pytest.fail.Exception, match=r"0\.25 % .* worst by 0\.2"):
        check_is_golden(picture, golden, evidence)
    assert {path.name for path in evidence.iterdir()} == {"grey.exr", "grey_difference.png"}


def test_require_llvmpipe_skips_locally_and_fails_in_ci(monkeypatch):
    monkeypatch.delenv("CI", raising=False)
    with pytest.raises(pytest.skip.Exception, match="RTX"):
        require_llvmpipe("NVIDIA GeForce RTX 4090/PCIe/SSE2")
    monkeypatch.setenv("CI", "1")
    with pytest.raises(pytest.fail.Exception, match=r"RTX.*LIBGL_ALWAYS_SOFTWARE"):
        require_llvmpipe("NVIDIA GeForce RTX 4090/PCIe/SSE2")
    require_llvmpipe("llvmpipe (LLVM 15.0.6, 256 bits)")
