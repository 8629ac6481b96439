"""What the command line says of numbers and files that cannot be: the option, in words."""

import numpy as np
import pytest

from heatlens.core.base.errors import InputError
from heatlens.fronts.commands.main import main
from heatlens.media.files.atomic_file import replacing
from heatlens.media.plate.read import read_plate
from support.command_line import CAMERA, channels
from support.exr_files import distances, rgb, write_file


def refused(capsys, *words: object) -> str:
    """Return stderr of a refused command line: code 2 and at most two lines."""
    try:
        code = main([str(word) for word in words])
    except SystemExit as stopped:
        code = stopped.code
    said = capsys.readouterr()
    assert code == 2 and said.out == "" and len(said.err.splitlines()) <= 2
    return said.err


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (("--layers", "0"), "heatlens: --layers must be 1 to 7, got 0.\n"),
        (("--proxy", "1.5"), "heatlens: --proxy must be 0.0625 to 1, got 1.5.\n"),
        (("--method", "accumulation", "--views", "0"), "--views must be 1 to 65536, got 0."),
        (("--layers", "1.5"), "--layers: '1.5' is not a whole number"),
        (("--f-stop", "wide"), "--f-stop: 'wide' is not a number"),
        (("--near", "nan"), "--near: 'nan' is not a finite number"),
    ],
)
def test_numbers_that_no_blur_has(capsys, tmp_path, words, expected):
    plate = write_file(tmp_path / "plate.exr", channels(), **CAMERA)
    assert expected in refused(capsys, "render", plate, "-o", tmp_path / "o.exr", *words)


@pytest.mark.parametrize(
    "words",
    [
        ("--min-ssim", "7"),
        ("--min-ssim", "1.01"),
        ("--max-flip", "-1"),
        ("--max-flip", "1.5"),
        ("--min-psnr", "120"),
        ("--min-psnr", "-1"),
    ],
)
def test_a_limit_that_no_score_can_reach_or_miss(capsys, words):
    said = refused(capsys, "compare", "a.exr", "b.exr", f"{words[0]}={words[1]}")
    assert words[0] in said and f"'{words[1]}' is not between" in said


def test_a_picture_is_no_shot(capsys, tmp_path):
    plate = write_file(tmp_path / "p.exr", channels(), **CAMERA)
    said = refused(capsys, "shot", "show", plate)
    assert "p.exr is not a text file, as shots" in said and "codec" not in said


def test_a_plate_has_nothing_of_a_scene(capsys, tmp_path):
    plate = write_file(tmp_path / "p.exr", channels(), **CAMERA)
    said = refused(capsys, "export", plate, "-o", tmp_path / "o.exr", "--size", "8x8")
    assert said.endswith("p.exr is a plate, but this option is for 3D scenes: leave --size out.\n")


def test_what_is_damaged_is_counted_as_people_count(capsys, tmp_path):
    path = write_file(tmp_path / "p.exr", rgb() | {"Z": distances()})
    content = path.read_bytes()
    path.write_bytes(content[: len(content) - 20])
    said = refused(capsys, "info", path)
    assert "its pixels cannot be read" in said and "part(s)" not in said


def test_a_file_that_cannot_be_written_is_told_by_its_own_name(tmp_path):
    with pytest.raises(InputError) as error, replacing(tmp_path / "o.exr") as beside:
        raise RuntimeError(f"Cannot write {beside}: disk on fire")
    assert str(error.value).count("o.exr") == 2
    assert ".part" not in str(error.value) and str(error.value).endswith("disk on fire.")
    with (
        pytest.raises(InputError, match="no bytes were written") as error,
        replacing(tmp_path / "o.exr"),
    ):
        pass  # nothing was written
    assert ".part" not in str(error.value)


@pytest.mark.parametrize(("factor", "words"), [(1.0, "above 1"), (-1.0, "below -1")])
def test_why_values_are_distances(tmp_path, factor, words):
    depth = (factor * distances()).astype(np.float32)
    plate = write_file(tmp_path / "p.exr", rgb() | {"Z": depth})
    assert f"{words}, so they are distances." in read_plate(plate).depth.why
