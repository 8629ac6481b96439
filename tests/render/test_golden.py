"""Pictures as they were when somebody looked at them and found them right.

    pytest tests/render/test_golden.py --update-golden    # look before you commit

Compared on llvmpipe only, where they were made: elsewhere they are rendered and the comparison is
skipped. HEATLENS_EXPECT_LLVMPIPE makes that skip a failure, so that it cannot pass for green.
"""

import os
from pathlib import Path

import moderngl
import numpy as np
import pytest

from heatlens.model.boxes import Box
from heatlens.model.lens import Lens
from heatlens.model.settings import Bokeh, DefocusSettings, Quality
from heatlens.model.shot import Shot
from heatlens.plate.exr_read import read_parts
from heatlens.plate.exr_write import write_exr
from heatlens.plate.png_write import write_png
from heatlens.render import FrameRenderer
from support.plates import Image, plate_of, room

GOLDEN = Path(__file__).with_name("golden")
SIZE = (160, 90)
MOST_OFF = 1 / 255  # a step of an 8-bit screen, of the light itself or of 1 where that is less
MOST_PIXELS = 0.001  # part of them that may be off by more: the rim of a disc, a cut between layers
AMPLIFIED = 16.0  # times brighter than it is, a difference can be seen

SHOTS = {
    "ball_film_disc": Shot(Lens(50.0, 1.4, 2.0, 36.0)),
    "post_preview_disc": Shot(
        Lens(85.0, 2.0, 0.9, 36.0), DefocusSettings(Bokeh.DISC, Quality.PREVIEW)
    ),
    "sky_gaussian": Shot(
        Lens(35.0, 2.0, float("inf"), 24.9), DefocusSettings(Bokeh.GAUSSIAN, Quality.FILM)
    ),
    "anamorphic_heat_proxy": Shot(
        Lens(75.0, 1.4, 3.0, 24.9, squeeze=2.0),
        DefocusSettings(Bokeh.HEAT, Quality.DRAFT, proxy=0.5),
    ),
}


def write_golden(path: Path, picture: Image) -> None:
    """Half, zip: under 30 kB each."""
    window = Box(0, 0, picture.shape[1], picture.shape[0])
    write_exr(path, {name: picture[..., i] for i, name in enumerate("RGB")}, window, window)


def read_golden(path: Path) -> Image:
    """(H, W, 3) float32."""
    ((_, channels),) = read_parts(path)
    return np.stack([channels[name] for name in "RGB"], axis=-1).astype(np.float32)


def check_is_golden(picture: Image, name: str, golden: Path, evidence: Path) -> None:
    """Fail, with both pictures written to the folder `evidence`, where `picture` is off."""
    expected = read_golden(golden / f"{name}.exr")
    assert picture.shape == expected.shape
    difference = np.abs(picture - expected) / np.maximum(1.0, np.abs(expected))
    share = float((difference.max(axis=2) > MOST_OFF).mean())
    if share <= MOST_PIXELS:
        return
    write_golden(evidence / f"{name}.exr", picture)
    write_png(evidence / f"{name}_difference.png", AMPLIFIED * difference)
    pytest.fail(
        f"{name}: {100 * share:.2f} % of the pixels are off by more than {MOST_OFF:.4f}, the worst "
        f"by {difference.max():.4f}. See {evidence}: the picture, and the difference x "
        f"{AMPLIFIED:g}. If it is better, --update-golden."
    )


def is_llvmpipe(ctx: moderngl.Context) -> bool:
    return "llvmpipe" in str(ctx.info["GL_RENDERER"])


@pytest.mark.parametrize("name", SHOTS)
def test_it_looks_as_it_did(ctx, request, tmp_path, name):
    renderer = FrameRenderer(ctx)
    renderer.load(plate_of(*room(*SIZE)))
    picture = renderer.pixels(SHOTS[name])[..., :3]
    assert np.isfinite(picture).all()
    if not is_llvmpipe(ctx):
        assert "HEATLENS_EXPECT_LLVMPIPE" not in os.environ
        pytest.skip(f"compared on llvmpipe only, this is {ctx.info['GL_RENDERER']}")
    if request.config.getoption("--update-golden"):
        write_golden(GOLDEN / f"{name}.exr", picture)
    check_is_golden(picture, name, GOLDEN, tmp_path)


def test_every_golden_picture_has_its_shot():
    assert {path.stem for path in GOLDEN.glob("*")} == set(SHOTS)


def test_a_difference_is_found_and_shown(tmp_path):
    golden, evidence = tmp_path / "golden", tmp_path / "evidence"
    golden.mkdir()
    evidence.mkdir()
    picture = np.full((40, 50, 3), 0.5, np.float32)
    write_golden(golden / "grey.exr", picture)
    picture[0, 0] += 0.1  # one pixel of 2000 is within MOST_PIXELS
    check_is_golden(picture, "grey", golden, evidence)
    picture[0, :5, 1] += 0.1
    with pytest.raises(pytest.fail.Exception, match=r"0\.25 % .* worst by 0\.2"):
        check_is_golden(picture, "grey", golden, evidence)
    assert {path.name for path in evidence.iterdir()} == {"grey.exr", "grey_difference.png"}
