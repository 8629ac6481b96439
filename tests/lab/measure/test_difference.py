"""Test the difference picture by reading it back pixel by pixel."""

import numpy as np
import pytest
from PIL import Image

from heatlens.core.base.errors import InputError
from heatlens.lab.measure.compared_pictures import absolute_difference, flip_map, write_difference

# Light whose sRGB value is one half.
HALF = 0.21404114


def flat_picture(value: float) -> np.ndarray:
    return np.full((8, 10, 3), value, np.float32)


@pytest.mark.parametrize(
    ("result", "gain", "expected"),
    [(HALF, 0.5, 0.25), (HALF, 1, 0.5), (HALF, 4, 1.0), (0.0, 9, 0.0)],
)
def test_absolute_difference_is_amplified_and_clamped(result, gain, expected):
    for pair in (
        (flat_picture(result), flat_picture(0.0)),
        (flat_picture(0.0), flat_picture(result)),
    ):
        np.testing.assert_allclose(absolute_difference(*pair, gain), expected, atol=1e-6)


def test_flip_map_uses_magma_colors():
    # Magma begins at (0.0015, 0.0005, 0.0139) and ends at (0.9871, 0.9914, 0.7495).
    same = flip_map(flat_picture(1), flat_picture(1)).reshape(-1, 3)
    np.testing.assert_allclose(same, np.tile([0.0015, 0.0005, 0.0139], (80, 1)), atol=1e-4)
    white_on_black = flip_map(flat_picture(1), flat_picture(0))
    assert white_on_black.shape == (8, 10, 3)
    assert (white_on_black > [0.95, 0.85, 0.6]).all()


def test_write_difference_puts_result_truth_and_error_side_by_side(tmp_path):
    path = tmp_path / "difference.png"
    write_difference(path, flat_picture(1.0), flat_picture(0.0), flat_picture(0.5))
    pixels = np.asarray(Image.open(path))
    assert pixels.shape == (8, 30, 3)
    assert [set(pixels[:, x].ravel()) for x in (0, 9, 10, 19, 20, 29)] == [
        *({255}, {255}, {0}, {0}, {128}, {128})
    ]


@pytest.mark.parametrize("name", ["difference.exr", "difference", "difference.jpg"])
def test_write_difference_rejects_other_formats(tmp_path, name):
    with pytest.raises(InputError, match=name):
        write_difference(tmp_path / name, flat_picture(0), flat_picture(0), flat_picture(0))
    assert not list(tmp_path.iterdir())


def test_write_difference_rejects_missing_folder(tmp_path):
    with pytest.raises(InputError, match="no_folder"):
        write_difference(
            tmp_path / "no_folder" / "a.png", flat_picture(0), flat_picture(0), flat_picture(0)
        )
