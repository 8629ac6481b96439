"""Compare pictures with golden ones, which somebody has checked by eye.

    pytest --update-golden tests/render/frames/test_golden.py    # look before you commit

They are compared on llvmpipe only, where they were made. Elsewhere the comparison is skipped,
unless CI is set in the environment: a runner that compares nothing must not pass for green.
"""

import os
from pathlib import Path

import numpy as np
import pytest

from heatlens.core.model.boxes import Box
from heatlens.media.plate.exr.exr_read import read_parts
from heatlens.media.plate.exr.exr_write import write_exr
from heatlens.media.plate.picture.picture_write import write_png
from heatlens.render.gpu.device import Device
from support.plates import Image

MOST_OFF = 1 / 255  # a step of an 8-bit screen, of the light itself or of 1 where that is less
MOST_PIXELS = 0.001  # part of them that may be off by more: the rim of a disc, a cut between layers
AMPLIFIED = 16.0  # factor that makes a difference visible


def compare_with_golden(
    picture: Image, path: Path, ctx: Device, is_updating: bool, evidence: Path
) -> None:
    """Fail where `picture` (H, W, 3) is not the golden picture at `path`; update that if asked."""
    require_llvmpipe(ctx.name)
    if is_updating:
        write_golden(path, picture)
    check_is_golden(picture, path, evidence)


def require_llvmpipe(renderer: str) -> None:
    """Skip the test on another renderer; fail it there where CI is set."""
    if "llvmpipe" in renderer:
        return
    words = f"Golden pictures are compared on llvmpipe only; this is {renderer}."
    if os.environ.get("CI"):
        pytest.fail(f"{words} Set LIBGL_ALWAYS_SOFTWARE=1 on this runner.")
    pytest.skip(words)


def write_golden(path: Path, picture: Image) -> None:
    """Write `picture` (H, W, 3) as a half float EXR."""
    window = Box(0, 0, picture.shape[1], picture.shape[0])
    write_exr(path, {name: picture[..., i] for i, name in enumerate("RGB")}, window, window)


def read_golden(path: Path) -> Image:
    """Return the golden picture at `path` as (H, W, 3) float32."""
    ((_, channels),) = read_parts(path)
    return np.stack([channels[name] for name in "RGB"], axis=-1).astype(np.float32)


def check_is_golden(picture: Image, path: Path, evidence: Path) -> None:
    """Fail if `picture` differs from the golden one; write picture and difference to `evidence`."""
    expected, name = read_golden(path), path.stem
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
