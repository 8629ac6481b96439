"""Test what `render` writes besides PNG, what it keeps of a plate, pipes, and `compare`."""

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


def first_part_channels(path):
    return read_parts(path)[0][1]


@pytest.mark.parametrize("suffix", [".jpg", ".jpeg", ".tif", ".tiff"])
def test_render_to_jpeg_and_tiff_matches_png(plate, tmp_path, suffix, capsys):
    view_options = ["--view", "sRGB curve"]
    for name in ("o.png", f"o{suffix}"):
        stderr_of_run(capsys, 0, "render", plate, "-o", tmp_path / name, *LENS, *view_options)
    png, image = (np.asarray(Image.open(tmp_path / n)).astype(int) for n in ("o.png", f"o{suffix}"))
    assert image.shape == png.shape
    assert np.abs(image - png).mean() <= (0 if "tif" in suffix else 12)


@pytest.mark.parametrize("name", ["piz", "zips", "dwaa"])
def test_render_keeps_compression_of_plate_unless_named(tmp_path, name, capsys):
    import OpenEXR

    kind = getattr(OpenEXR, f"{name.upper()}_COMPRESSION")
    plate = write_file(tmp_path / "p.exr", rgb(HEIGHT, WIDTH) | {"Z": DEPTH}, compression=kind)
    out = tmp_path / "o.exr"
    stderr_of_run(capsys, 0, "render", plate, "-o", out, *LENS)
    assert read_parts(out)[0][0]["compression"] == kind
    stderr_of_run(capsys, 0, "render", plate, "-o", out, *LENS, "--compression", "rle")
    assert read_parts(out)[0][0]["compression"] == OpenEXR.RLE_COMPRESSION


def test_render_keep_channels_copies_them_bit_for_bit(plate, tmp_path, capsys):
    out, original = tmp_path / "o.exr", first_part_channels(plate)
    stderr_of_run(capsys, 0, "render", plate, "-o", out, *LENS)
    assert set(first_part_channels(out)) == set("RGB")
    stderr_of_run(capsys, 0, "render", plate, "-o", out, *LENS, "--keep-channels", "all")
    copied = first_part_channels(out)
    assert set(copied) == set(original)
    for name in original.keys() - set("RGB"):
        assert copied[name].dtype == original[name].dtype
        assert copied[name].tobytes() == original[name].tobytes()
    assert read_parts(out)[0][0]["cryptomatte/x/name"] == "crypto"
    stderr_of_run(capsys, 0, "render", plate, "-o", out, *LENS, "--keep-channels", "diffuse, z")
    assert set(first_part_channels(out)) == {*"RGBZ", "diffuse.R", "diffuse.G", "diffuse.B"}


def test_render_keep_channels_places_part_by_its_window(tmp_path, capsys):
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
    channel = first_part_channels(out)["aov.R"]
    np.testing.assert_array_equal(channel[1:, 2:], part["R"])
    assert not channel[0].any() and not channel[:, :2].any()


@pytest.mark.parametrize(
    ("words", "message_part"),
    [
        (("-o", "o.exr", "--keep-channels", "diffus"), "Did you mean diffuse?"),
        (("-o", "o.png", "--keep-channels", "all"), "only an EXR holds this"),
        (("-o", "o.png", "--compression", "zip"), "only an EXR holds this"),
        (("-o", "o.exr", "--keep-channels", "all", "--proxy", "0.5"), "leave --proxy out"),
        (("-o", "o.gif"), "must end in .exr, .png"),
    ],
)
def test_render_rejects_impossible_keep_channels(
    plate, tmp_path, monkeypatch, capsys, words, message_part
):
    monkeypatch.chdir(tmp_path)
    assert message_part in stderr_of_run(capsys, 2, "render", plate, *words, *LENS)
    assert not (tmp_path / words[1]).exists()


# Pipes


def run_piped(*words, data=b""):
    command = [sys.executable, "-m", "heatlens", *map(str, words)]
    return subprocess.run(command, input=data, capture_output=True, env=ENVIRONMENT, check=False)


@pytest.mark.draws_in_process
def test_render_through_pipe_equals_render_of_files(plate, tmp_path, capsys):
    process = run_piped("render", "-", "-o", "-", *LENS, data=plate.read_bytes())
    assert process.returncode == 0, process.stderr
    piped_file = tmp_path / "through.exr"
    piped_file.write_bytes(process.stdout)
    stderr_of_run(capsys, 0, "render", plate, "-o", tmp_path / "o.exr", *LENS)
    np.testing.assert_array_equal(
        first_part_channels(piped_file)["R"], first_part_channels(tmp_path / "o.exr")["R"]
    )


@pytest.mark.parametrize(
    ("data", "message_part"), [(b"", "is empty"), (b"text", "neither an EXR nor")]
)
def test_info_rejects_piped_data_that_is_no_picture(data, message_part, capsys, monkeypatch):
    stdin = SimpleNamespace(buffer=io.BytesIO(data), isatty=lambda: False)
    monkeypatch.setattr(sys, "stdin", stdin)
    assert message_part in stderr_of_run(capsys, 2, "info", "-")


def test_info_and_compare_read_from_pipe(plate, capsys, monkeypatch):
    for words in (["info", "-"], ["compare", "-", str(plate)]):
        stdin = SimpleNamespace(buffer=io.BytesIO(plate.read_bytes()), isatty=lambda: False)
        monkeypatch.setattr(sys, "stdin", stdin)
        assert main(words) == 0
    assert "PSNR       99.000 dB" in capsys.readouterr().out


def set_stdin(monkeypatch, data: bytes) -> None:
    stdin = SimpleNamespace(buffer=io.BytesIO(data), isatty=lambda: False)
    monkeypatch.setattr(sys, "stdin", stdin)


def test_shot_new_takes_lens_of_piped_plate(tmp_path, capsys, monkeypatch):
    plate = write_file(tmp_path / "p.exr", rgb(HEIGHT, WIDTH) | {"Z": DEPTH}, **CAMERA)
    out = tmp_path / "s.heatlens.json"
    set_stdin(monkeypatch, plate.read_bytes())
    stderr = stderr_of_run(capsys, 0, "shot", "new", "-", "-o", out, "--f-stop", "4")
    assert "the shot has no plate" in stderr
    shot = read_shot(out)
    assert shot.source is None and shot.lens == Lens(50.0, 4.0, float(np.float32(2.24)), 36.0)


def test_study_accepts_piped_plate(plate, tmp_path, capsys, monkeypatch):
    set_stdin(monkeypatch, plate.read_bytes())
    words = ("--methods", "gather,heat", "--runs", "1", *LENS[:-2])
    stderr_of_run(capsys, 0, "study", "-", "-o", tmp_path / "report", *words)
    assert (tmp_path / "report" / "index.html").is_file()


def test_window_opens_piped_plate(plate, capsys, monkeypatch):
    opened_files: list[bytes] = []
    monkeypatch.setattr(
        "heatlens.studio.ui.window.run_window",
        lambda start: opened_files.append(Path(start.source).read_bytes()),
    )
    set_stdin(monkeypatch, plate.read_bytes())
    assert main(["-"]) == 0 and opened_files == [plate.read_bytes()]


def test_info_without_piped_data_reports_it(capsys, monkeypatch):
    monkeypatch.setattr(sys, "stdin", SimpleNamespace(isatty=lambda: True))
    assert "nothing is piped" in stderr_of_run(capsys, 2, "info", "-")


# Compare


def test_compare_accepts_png_and_tiff(tmp_path, capsys):
    values = colors(24, 36)
    first = save(tmp_path / "a.png", values)
    same_image = save(tmp_path / "a.tif", values)
    brighter_image = save(tmp_path / "b.png", np.clip(values.astype(int) + 10, 0, 255).astype("u1"))
    assert main(["compare", str(first), str(same_image)]) == 0
    assert "PSNR       99.000 dB" in capsys.readouterr().out
    assert main(["compare", str(brighter_image), str(first), "--min-psnr", "40"]) == 1
    expected = 20 * np.log10(255 / np.sqrt(np.mean((np.clip(values + 10.0, 0, 255) - values) ** 2)))
    first_line = capsys.readouterr().out.splitlines()[0]
    assert float(first_line.split()[1]) == pytest.approx(expected, abs=0.01)
