"""Test the command `heatlens compare`: its output and its exit codes."""

import argparse
import json

import numpy as np
import pytest
from PIL import Image

from heatlens.core.base.errors import HeatlensError, InputError
from heatlens.core.model.boxes import Box
from heatlens.fronts.commands.command_parser import add_command
from heatlens.lab.commands import compare
from heatlens.media.plate.exr.exr_write import write_exr

# Light whose sRGB value is one half: 6.021 dB away from black, and from white.
HALF = 0.21404114


def run_compare(*argv: object) -> int:
    parser = argparse.ArgumentParser()
    add_command(parser.add_subparsers(), "compare", "", compare)
    args = parser.parse_args(["compare", *map(str, argv)])
    return args.run(args)


@pytest.fixture
def exr(tmp_path):
    """Return a function that writes a flat gray picture and returns its path."""

    def write(name, value, data=Box(0, 0, 16, 12), display=Box(0, 0, 16, 12)):  # noqa: B008
        grey = np.full(data.shape, value, np.float32)
        write_exr(tmp_path / name, dict.fromkeys("RGB", grey), data, display, half=False)
        return tmp_path / name

    return write


def test_compare_prints_aligned_scores(exr, capsys):
    assert run_compare(exr("a.exr", 0.0), exr("b.exr", 1.0)) == 0
    out, err = capsys.readouterr()
    lines = out.splitlines()
    names = ["PSNR", "SSIM", "FLIP", "HDR-FLIP", "relMSE", "nonfinite"]
    assert [line.split()[0] for line in lines] == names
    assert len({len(line) - len(line.split(maxsplit=1)[1]) for line in lines}) == 1
    assert [lines[i].split()[1] for i in (0, 1, 4, 5)] == ["0.000", "0.00010", "0.990099", "0"]
    assert err == ""


def test_compare_json_holds_every_score(exr, capsys):
    assert run_compare(exr("a.exr", HALF), exr("b.exr", 1.0), "--json") == 0
    scores = json.loads(capsys.readouterr().out)
    assert list(scores) == ["psnr_db", "ssim", "flip", "flip_hdr", "relmse", "nonfinite"]
    assert scores["psnr_db"] == pytest.approx(6.0206, abs=1e-4)


@pytest.mark.parametrize(
    ("limits", "code", "missed"),
    [
        (["--min-psnr", 6], 0, []),
        (["--min-psnr", 7], 1, ["PSNR 6.021 dB is below the limit of 7 dB"]),
        (["--min-ssim", 0.80001], 0, []),
        (["--min-ssim", 0.81], 1, ["SSIM 0.80002 is below the limit of 0.81"]),
        (["--max-flip", 1], 0, []),
        (["--max-flip", 0.01], 1, ["is above the limit of 0.01"]),
        (["--min-psnr", 7, "--min-ssim", 0.8, "--max-flip", 0], 1, ["PSNR", "FLIP"]),
    ],
)
def test_compare_limits_decide_exit_code(exr, capsys, limits, code, missed):
    assert run_compare(exr("a.exr", HALF), exr("b.exr", 1.0), *limits) == code
    out, err = capsys.readouterr()
    assert "PSNR" in out
    assert len(err.splitlines()) == len(missed)
    assert all(words in line for words, line in zip(missed, err.splitlines(), strict=True))


@pytest.mark.parametrize("text", ["nan", "inf", "much"])
@pytest.mark.parametrize("option", ["--min-psnr", "--min-ssim", "--max-flip", "--gain"])
def test_compare_rejects_limits_that_are_no_finite_numbers(exr, capsys, option, text):
    with pytest.raises(SystemExit) as exit_error:
        run_compare(exr("a.exr", 0.0), exr("b.exr", 0.0), option, text)
    assert exit_error.value.code == 2
    assert f"'{text}' is not a" in capsys.readouterr().err


def test_compare_rejects_gain_of_zero(exr, capsys):
    with pytest.raises(SystemExit):
        run_compare(exr("a.exr", 0.0), exr("b.exr", 0.0), "--gain", 0)
    assert "'0' is not a number above 0" in capsys.readouterr().err


def test_compare_rejects_different_sizes_and_names_both(exr):
    other_size = exr("b.exr", 0.0, Box(0, 0, 20, 10), Box(0, 0, 20, 10))
    with pytest.raises(InputError, match=r"a\.exr is 16 x 12 pixels.*b\.exr is 20 x 10"):
        run_compare(exr("a.exr", 0.0), other_size)


def test_compare_uses_common_pixels_of_crop(exr, capsys):
    crop = exr("b.exr", 1.0, Box(4, 2, 20, 11))
    assert run_compare(exr("a.exr", 1.0), crop, "--min-psnr", 99) == 0
    assert "12 x 9 pixels at (4, 2)" in capsys.readouterr().err


@pytest.mark.parametrize("name", ["absent.exr", "broken.exr"])
def test_compare_names_unreadable_file(exr, tmp_path, name):
    (tmp_path / "broken.exr").write_bytes(b"\x76\x2f\x31\x01 and no more")
    for pair in ((tmp_path / name, exr("a.exr", 0.0)), (exr("a.exr", 0.0), tmp_path / name)):
        with pytest.raises(HeatlensError, match=name):
            run_compare(*pair)


def test_compare_counts_nonfinite_pixels_and_warns_of_truth(exr, capsys):
    assert run_compare(exr("a.exr", np.nan), exr("b.exr", np.inf)) == 0
    out, err = capsys.readouterr()
    assert out.splitlines()[-1].split() == ["nonfinite", "192"]
    assert "192 pixels of the truth" in err


@pytest.mark.parametrize(
    ("options", "expected_code"), [([], 255), (["--gain", 1], 128), (["--gain", 0.5], 64)]
)
def test_compare_difference_option_writes_amplified_error(exr, tmp_path, options, expected_code):
    path = tmp_path / "difference.png"
    assert run_compare(exr("a.exr", HALF), exr("b.exr", 0.0), "--difference", path, *options) == 0
    pixels = np.asarray(Image.open(path))
    assert pixels.shape == (12, 48, 3)
    assert [pixels[5, x, 0] for x in (8, 24, 40)] == [128, 0, expected_code]


def test_compare_show_flip_writes_flip_map(exr, tmp_path):
    path = tmp_path / "difference.png"
    same = exr("a.exr", HALF), exr("b.exr", HALF)
    assert run_compare(*same, "--difference", path, "--show", "flip") == 0
    assert tuple(np.asarray(Image.open(path))[5, 40]) == (0, 0, 4)


def test_compare_rejects_difference_that_is_no_png(exr, tmp_path):
    with pytest.raises(InputError, match=r"written as \.png"):
        run_compare(tmp_path / "absent.exr", tmp_path / "absent.exr", "--difference", "a.exr")
