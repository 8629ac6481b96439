"""Test messages of the command line about impossible numbers and files: they name the option."""

import numpy as np
import pytest

from heatlens.core.base.errors import InputError
from heatlens.fronts.commands.main import main
from heatlens.media.files.atomic_file import replace_atomically
from heatlens.media.plate.read import read_plate
from support.command_line import CAMERA, channels
from support.exr_files import distances, rgb, write_file


def message_of_refusal(capsys, *words: object) -> str:
    """Return stderr of a refused command line: code 2 and at most two lines."""
    try:
        code = main([str(word) for word in words])
    except SystemExit as exit_error:
        code = exit_error.code
    captured = capsys.readouterr()
    assert code == 2 and captured.out == "" and len(captured.err.splitlines()) <= 2
    return captured.err


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
def test_render_refuses_numbers_out_of_range_with_option_name(capsys, tmp_path, words, expected):
    plate = write_file(tmp_path / "plate.exr", channels(), **CAMERA)
    assert expected in message_of_refusal(capsys, "render", plate, "-o", tmp_path / "o.exr", *words)


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
def test_compare_refuses_impossible_score_limits(capsys, words):
    message = message_of_refusal(capsys, "compare", "a.exr", "b.exr", f"{words[0]}={words[1]}")
    assert words[0] in message and f"'{words[1]}' is not between" in message


def test_shot_show_of_picture_says_it_is_no_text_file(capsys, tmp_path):
    plate = write_file(tmp_path / "p.exr", channels(), **CAMERA)
    message = message_of_refusal(capsys, "shot", "show", plate)
    assert "p.exr is not a text file, as shots" in message and "codec" not in message


def test_export_of_plate_refuses_size_option(capsys, tmp_path):
    plate = write_file(tmp_path / "p.exr", channels(), **CAMERA)
    message = message_of_refusal(capsys, "export", plate, "-o", tmp_path / "o.exr", "--size", "8x8")
    assert message.endswith(
        "p.exr is a plate, but this option is for 3D scenes: leave --size out.\n"
    )


def test_info_of_truncated_exr_says_pixels_cannot_be_read(capsys, tmp_path):
    path = write_file(tmp_path / "p.exr", rgb() | {"Z": distances()})
    content = path.read_bytes()
    path.write_bytes(content[: len(content) - 20])
    message = message_of_refusal(capsys, "info", path)
    assert "its pixels cannot be read" in message and "part(s)" not in message


def test_write_error_names_output_and_not_temporary_file(tmp_path):
    with (
        pytest.raises(InputError) as error,
        replace_atomically(tmp_path / "o.exr") as temporary_path,
    ):
        raise RuntimeError(f"Cannot write {temporary_path}: disk on fire")
    assert str(error.value).count("o.exr") == 2
    assert ".part" not in str(error.value) and str(error.value).endswith("disk on fire.")
    with (
        pytest.raises(InputError, match="no bytes were written") as error,
        replace_atomically(tmp_path / "o.exr"),
    ):
        pass  # nothing was written
    assert ".part" not in str(error.value)


@pytest.mark.parametrize(("factor", "words"), [(1.0, "above 1"), (-1.0, "below -1")])
def test_depth_reason_states_why_values_are_distances(tmp_path, factor, words):
    depth = (factor * distances()).astype(np.float32)
    plate = write_file(tmp_path / "p.exr", rgb() | {"Z": depth})
    assert f"{words}, so they are distances." in read_plate(plate).depth.why
