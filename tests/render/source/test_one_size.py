"""sequence_of_one_size: numbered pictures form a sequence if they have the same size."""

import numpy as np
import pytest
from PIL import Image

from heatlens.render.source.plate_source import sequence_of_one_size
from support.exr_files import write_file


def write_picture(folder, name, size):
    if name.endswith(".exr"):
        grey = np.zeros((size[1], size[0]), np.float16)
        return write_file(folder / name, {"R": grey, "G": grey, "B": grey, "Z": grey})
    Image.new("RGB", size).save(folder / name)
    return folder / name


@pytest.mark.parametrize("suffix", ["exr", "png"])
def test_sequence_of_one_size_leaves_out_files_of_other_size(tmp_path, suffix):
    path = write_picture(tmp_path, f"hero.0720.{suffix}", (16, 9))
    write_picture(tmp_path, f"hero.1080.{suffix}", (24, 13))
    sequence = sequence_of_one_size(str(path))
    assert sequence.present == (720,) and sequence.path_at(720) == path
    assert sequence_of_one_size(str(tmp_path / f"hero.####.{suffix}")).present == (720, 1080)


def test_sequence_of_one_size_includes_unreadable_file(tmp_path):
    path = write_picture(tmp_path, "shot.1001.exr", (16, 9))
    (tmp_path / "shot.1002.exr").write_bytes(b"being written")
    write_picture(tmp_path, "shot.1003.exr", (16, 9))
    assert sequence_of_one_size(str(path)).present == (1001, 1002, 1003)
