"""What `render` writes beside PNG, what it keeps of the plate, pipes, and `compare` of pictures."""

import io
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from PIL import Image

from heatlens.core.model.lens.lens import Lens
from heatlens.fronts.commands.main import main
from heatlens.media.documents.shot_file import read_shot
from heatlens.media.plate.exr.exr_read import read_parts
from support.command_line import CAMERA, ENVIRONMENT, stderr_of_run
from support.exr_files import part_header, rgb, write_file, write_parts
from support.picture_files import colors, save

HEIGHT, WIDTH = 12, 16
LENS = ["--focal-length", "50", "--f-stop", "8", "--focus-distance", "3", "--method", "pyramid"]
DEPTH = np.linspace(2, 6, HEIGHT * WIDTH, dtype="f4").reshape(HEIGHT, WIDTH)


@pytest.fixture
def plate(tmp_path):
    ids = np.arange(HEIGHT * WIDTH, dtype="u4").reshape(HEIGHT, WIDTH) * 70000
    layers = {
        **{f"diffuse.{n}": v for n, v in rgb(HEIGHT, WIDTH).items()},
        "crypto00.R": DEPTH * np.float32(1.000001),
        "id.Y": ids,
        "Z": DEPTH,
    }
    return write_file(
        tmp_path / "p.exr", rgb(HEIGHT, WIDTH) | layers, **{"cryptomatte/x/name": "crypto"}
    )


def channels_of(path):
    return read_parts(path)[0][1]


@pytest.mark.parametrize("suffix", [".jpg", ".jpeg", ".tif", ".tiff"])
def test_pictures_for_the_eye_are_the_png(plate, tmp_path, suffix, capsys):
    look = ["--view", "sRGB curve"]
    for name in ("o.png", f"o{suffix}"):
        stderr_of_run(capsys, 0, "render", plate, "-o", tmp_path / name, *LENS, *look)
    png, other = (np.asarray(Image.open(tmp_path / n)).astype(int) for n in ("o.png", f"o{suffix}"))
    assert other.shape == png.shape
    assert np.abs(other - png).mean() <= (0 if "tif" in suffix else 12)


@pytest.mark.parametrize("name", ["piz", "zips", "dwaa"])
def test_the_compression_of_the_plate_is_kept_unless_another_is_named(tmp_path, name, capsys):
    import OpenEXR

    kind = getattr(OpenEXR, f"{name.upper()}_COMPRESSION")
    plate = write_file(tmp_path / "p.exr", rgb(HEIGHT, WIDTH) | {"Z": DEPTH}, compression=kind)
    out = tmp_path / "o.exr"
    stderr_of_run(capsys, 0, "render", plate, "-o", out, *LENS)
    assert read_parts(out)[0][0]["compression"] == kind
    stderr_of_run(capsys, 0, "render", plate, "-o", out, *LENS, "--compression", "rle")
    assert read_parts(out)[0][0]["compression"] == OpenEXR.RLE_COMPRESSION


def test_channels_are_kept_bit_for_bit(plate, tmp_path, capsys):
    out, before = tmp_path / "o.exr", channels_of(plate)
    stderr_of_run(capsys, 0, "render", plate, "-o", out, *LENS)
    assert set(channels_of(out)) == set("RGB")
    stderr_of_run(capsys, 0, "render", plate, "-o", out, *LENS, "--keep-channels", "all")
    after = channels_of(out)
    assert set(after) == set(before)
    for name in before.keys() - set("RGB"):
        assert after[name].dtype == before[name].dtype
        assert after[name].tobytes() == before[name].tobytes()
    assert read_parts(out)[0][0]["cryptomatte/x/name"] == "crypto"
    stderr_of_run(capsys, 0, "render", plate, "-o", out, *LENS, "--keep-channels", "diffuse, z")
    assert set(channels_of(out)) == {*"RGBZ", "diffuse.R", "diffuse.G", "diffuse.B"}


def test_kept_channels_of_another_window_lie_where_they_were(tmp_path, capsys):
    window = (np.array([2, 1], "i4"), np.array([WIDTH - 1, HEIGHT - 1], "i4"))
    display = (np.array([0, 0], "i4"), np.array([WIDTH - 1, HEIGHT - 1], "i4"))
    part = rgb(HEIGHT - 1, WIDTH - 2)
    plate = write_parts(
        tmp_path / "p.exr",
        (part_header(name="rgba"), rgb(HEIGHT, WIDTH) | {"Z": DEPTH}),
        (part_header(name="aov", dataWindow=window, displayWindow=display), part),
    )
    out = tmp_path / "o.exr"
    stderr_of_run(capsys, 0, "render", plate, "-o", out, *LENS, "--keep-channels", "aov")
    kept = channels_of(out)["aov.R"]
    np.testing.assert_array_equal(kept[1:, 2:], part["R"])
    assert not kept[0].any() and not kept[:, :2].any()


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("-o", "o.exr", "--keep-channels", "diffus"), "Did you mean diffuse?"),
        (("-o", "o.png", "--keep-channels", "all"), "for EXR"),
        (("-o", "o.png", "--compression", "zip"), "for EXR"),
        (("-o", "o.exr", "--keep-channels", "all", "--proxy", "0.5"), "leave --proxy out"),
        (
            (
                "-o",
                "o.gif",
            ),
            "must end in .exr, .png",
        ),
    ],
)
def test_what_cannot_be_kept_is_said(plate, tmp_path, monkeypatch, capsys, words, said):
    monkeypatch.chdir(tmp_path)
    assert said in stderr_of_run(capsys, 2, "render", plate, *words, *LENS)
    assert not (tmp_path / words[1]).exists()


# Pipes


def piped(*words, data=b""):
    command = [sys.executable, "-m", "heatlens", *map(str, words)]
    return subprocess.run(command, input=data, capture_output=True, env=ENVIRONMENT, check=False)


def test_an_exr_goes_through_a_pipe_as_through_files(plate, tmp_path, capsys):
    done = piped("render", "-", "-o", "-", *LENS, data=plate.read_bytes())
    assert done.returncode == 0, done.stderr
    through = tmp_path / "through.exr"
    through.write_bytes(done.stdout)
    stderr_of_run(capsys, 0, "render", plate, "-o", tmp_path / "o.exr", *LENS)
    np.testing.assert_array_equal(channels_of(through)["R"], channels_of(tmp_path / "o.exr")["R"])


@pytest.mark.parametrize(("data", "said"), [(b"", "is empty"), (b"text", "neither an EXR nor")])
def test_what_is_piped_and_no_picture(data, said, capsys, monkeypatch):
    stdin = SimpleNamespace(buffer=io.BytesIO(data), isatty=lambda: False)
    monkeypatch.setattr(sys, "stdin", stdin)
    assert said in stderr_of_run(capsys, 2, "info", "-")


def test_info_and_compare_read_from_a_pipe(plate, capsys, monkeypatch):
    for words in (["info", "-"], ["compare", "-", str(plate)]):
        stdin = SimpleNamespace(buffer=io.BytesIO(plate.read_bytes()), isatty=lambda: False)
        monkeypatch.setattr(sys, "stdin", stdin)
        assert main(words) == 0
    assert "PSNR       99.000 dB" in capsys.readouterr().out


def pipe(monkeypatch, data: bytes) -> None:
    stdin = SimpleNamespace(buffer=io.BytesIO(data), isatty=lambda: False)
    monkeypatch.setattr(sys, "stdin", stdin)


def test_a_shot_takes_the_lens_of_a_piped_plate(tmp_path, capsys, monkeypatch):
    plate = write_file(tmp_path / "p.exr", rgb(HEIGHT, WIDTH) | {"Z": DEPTH}, **CAMERA)
    out = tmp_path / "s.heatlens.json"
    pipe(monkeypatch, plate.read_bytes())
    said = stderr_of_run(capsys, 0, "shot", "new", "-", "-o", out, "--f-stop", "4")
    assert "the shot has no plate" in said
    shot = read_shot(out)
    assert shot.source is None and shot.lens == Lens(50.0, 4.0, float(np.float32(2.24)), 36.0)


def test_a_study_of_a_piped_plate(plate, tmp_path, capsys, monkeypatch):
    pipe(monkeypatch, plate.read_bytes())
    words = ("--methods", "gather,heat", "--runs", "1", *LENS[:-2])
    stderr_of_run(capsys, 0, "study", "-", "-o", tmp_path / "report", *words)
    assert (tmp_path / "report" / "index.html").is_file()


def test_the_window_opens_when_all_of_a_pipe_was_read(plate, capsys, monkeypatch):
    held: list[bytes] = []
    monkeypatch.setattr(
        "heatlens.studio.ui.window.run_window",
        lambda start: held.append(Path(start.source).read_bytes()),
    )
    pipe(monkeypatch, plate.read_bytes())
    assert main(["-"]) == 0 and held == [plate.read_bytes()]


def test_a_terminal_is_no_pipe(capsys, monkeypatch):
    monkeypatch.setattr(sys, "stdin", SimpleNamespace(isatty=lambda: True))
    assert "nothing is piped" in stderr_of_run(capsys, 2, "info", "-")


# Compare


def test_compare_takes_pictures_for_the_eye(tmp_path, capsys):
    values = colors(24, 36)
    first = save(tmp_path / "a.png", values)
    same = save(tmp_path / "a.tif", values)
    off = save(tmp_path / "b.png", np.clip(values.astype(int) + 10, 0, 255).astype("u1"))
    assert main(["compare", str(first), str(same)]) == 0
    assert "PSNR       99.000 dB" in capsys.readouterr().out
    assert main(["compare", str(off), str(first), "--min-psnr", "40"]) == 1
    expected = 20 * np.log10(255 / np.sqrt(np.mean((np.clip(values + 10.0, 0, 255) - values) ** 2)))
    said = capsys.readouterr().out.splitlines()[0]
    assert float(said.split()[1]) == pytest.approx(expected, abs=0.01)
