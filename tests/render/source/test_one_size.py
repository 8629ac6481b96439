"""Numbered pictures of two sizes are no sequence; those of one size are."""

import numpy as np
import pytest
from PIL import Image

from heatlens.render.source.plate_source import sequence_of_one_size
from support.exr_files import write_file


def written(folder, name, size):
    if name.endswith(".exr"):
        grey = np.zeros((size[1], size[0]), np.float16)
        return write_file(folder / name, {"R": grey, "G": grey, "B": grey, "Z": grey})
    Image.new("RGB", size).save(folder / name)
    return folder / name


@pytest.mark.parametrize("suffix", ["exr", "png"])
def test_files_of_another_size_are_another_picture(tmp_path, suffix):
    named = written(tmp_path, f"hero.0720.{suffix}", (16, 9))
    written(tmp_path, f"hero.1080.{suffix}", (24, 13))
    found = sequence_of_one_size(str(named))
    assert found.present == (720,) and found.path_at(720) == named
    assert sequence_of_one_size(str(tmp_path / f"hero.####.{suffix}")).present == (720, 1080)


def test_files_of_one_size_are_a_sequence_also_with_one_that_cannot_be_read(tmp_path):
    named = written(tmp_path, "shot.1001.exr", (16, 9))
    (tmp_path / "shot.1002.exr").write_bytes(b"being written")
    written(tmp_path, "shot.1003.exr", (16, 9))
    assert sequence_of_one_size(str(named)).present == (1001, 1002, 1003)
